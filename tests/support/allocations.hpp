#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

// Counts what a program allocates, the library and Eigen within it included. For the one source file of a test that is
// linked with -Wl,--wrap=malloc, see rivid_count_allocations() in tests/CMakeLists.txt.

namespace rivid::test {

inline std::atomic<long> allocations = 0;

/// How often `action` allocates.
template <typename Action>
long allocations_of(const Action& action) {
  const long before = allocations;
  action();
  return allocations - before;
}

// Not inlined: the compiler would see malloc's kind of memory go to delete, and warn.
[[gnu::noinline]] inline void* allocated(std::size_t size) {
  if (void* const p = std::malloc(size)) {
    return p;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] inline void released(void* p) { std::free(p); }

}  // namespace rivid::test

extern "C" void* __real_malloc(std::size_t size);
extern "C" void* __wrap_malloc(std::size_t size);
extern "C" void* __wrap_malloc(std::size_t size) {
  ++rivid::test::allocations;
  return __real_malloc(size);
}

void* operator new(std::size_t size) { return rivid::test::allocated(size); }
void operator delete(void* p) noexcept { rivid::test::released(p); }
void operator delete(void* p, std::size_t) noexcept { rivid::test::released(p); }
