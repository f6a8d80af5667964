#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

namespace rivid {

namespace detail {

// Counts, writes or reads the bytes of a state. An estimator names its state in `visit_state(visit)`, which calls
// visit(pointer, count) for arrays of plain values, always in the same order.
class StateSize {
 public:
  template <typename Value>
  void operator()(const Value* /*values*/, std::size_t count) noexcept {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes += count * sizeof(Value);
  }
  std::size_t bytes = 0;
};

class StateWriter {
 public:
  explicit StateWriter(std::byte* to) : to_(to) {}
  template <typename Value>
  void operator()(const Value* values, std::size_t count) noexcept {
    std::memcpy(to_, values, count * sizeof(Value));
    to_ += count * sizeof(Value);
  }

 private:
  std::byte* to_;
};

class StateReader {
 public:
  explicit StateReader(const std::byte* from) : from_(from) {}
  template <typename Value>
  void operator()(Value* values, std::size_t count) noexcept {
    std::memcpy(values, from_, count * sizeof(Value));
    from_ += count * sizeof(Value);
  }

 private:
  const std::byte* from_;
};

}  // namespace detail

/// Bytes that the state of an estimator takes: what it has learned, without model and options.
template <typename Estimator>
[[nodiscard]] std::size_t state_size(const Estimator& estimator) noexcept {
  detail::StateSize size;
  // Visitors take pointers to what they may change; this one changes nothing.
  const_cast<Estimator&>(estimator).visit_state(size);
  return size.bytes;
}

/// Writes the state of an estimator. No allocation: the memory is the caller's.
///
/// @param to  at least state_size(estimator) bytes
/// @return    whether it fits; else nothing is written
template <typename Estimator>
[[nodiscard]] bool save_state(const Estimator& estimator, std::span<std::byte> to) noexcept {
  if (to.size() < state_size(estimator)) {
    return false;
  }
  detail::StateWriter writer(to.data());
  const_cast<Estimator&>(estimator).visit_state(writer);
  return true;
}

/// Puts an estimator, made with the same model and options, back into a state that save_state() wrote on the same kind of
/// machine. What comes after is the same, bit by bit.
///
/// @param from  exactly state_size(estimator) bytes
/// @return      whether the size is right; else nothing has changed
template <typename Estimator>
[[nodiscard]] bool restore_state(Estimator& estimator, std::span<const std::byte> from) noexcept {
  if (from.size() != state_size(estimator)) {
    return false;
  }
  detail::StateReader reader(from.data());
  estimator.visit_state(reader);
  return true;
}

}  // namespace rivid
