#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

// Counts heap allocations. It replaces operator new, so that one file of a program alone may include it.
// Those of Eigen go past operator new: see mallocs.hpp.

namespace rivid::test {

/// Heap allocations of this program so far.
inline std::atomic<long> allocations = 0;

/// How often `action` allocates.
template <typename Action>
long allocations_of(const Action& action) {
  const long before = allocations;
  action();
  return allocations - before;
}

// Not inlined: the compiler would see malloc's kind of memory go to delete, and warn.
[[gnu::noinline]] inline void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* const p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) {
    throw std::bad_alloc();
  }
  return p;
}
[[gnu::noinline]] inline void release(void* p) { std::free(p); }

}  // namespace rivid::test

// The arrays' forms call these.
void* operator new(std::size_t size) { return rivid::test::counted(size, 16); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return rivid::test::counted(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return rivid::test::counted(size, 16);
}
void operator delete(void* p) noexcept { rivid::test::release(p); }
void operator delete(void* p, std::size_t) noexcept { rivid::test::release(p); }
void operator delete(void* p, std::align_val_t) noexcept { rivid::test::release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { rivid::test::release(p); }
