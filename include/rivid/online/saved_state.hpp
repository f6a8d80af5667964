#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
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
    layout = hashed(hashed(layout, sizeof(Value)), count);
  }
  // FNV-1a, a word at a time.
  [[nodiscard]] static constexpr std::uint64_t hashed(std::uint64_t hash, std::uint64_t word) noexcept {
    hash = (hash ^ word) * 0x100000001b3U;
    return hash ^ (hash >> 32U);
  }
  static constexpr std::uint64_t first_hash = 0xcbf29ce484222325U;

  std::size_t bytes = 0;
  std::uint64_t layout = first_hash;  // sizes of the arrays
};

// What stands before the bytes of a state.
struct StateHeader {
  static constexpr std::uint64_t rivids = 0x3154415453564952U;  // "RIVSTAT1"

  std::uint64_t magic = rivids;
  std::uint64_t layout = 0;
  std::uint64_t checksum = 0;
};

[[nodiscard]] inline std::uint64_t checksum_of(const std::byte* bytes, std::size_t count) noexcept {
  std::uint64_t hash = StateSize::first_hash;
  for (std::size_t at = 0; at < count; at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + at, std::min(sizeof word, count - at));
    hash = StateSize::hashed(hash, word);
  }
  return hash;
}

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
  return sizeof(detail::StateHeader) + size.bytes;
}

/// Writes the state of an estimator. No allocation: the memory is the caller's.
///
/// @param to  at least state_size(estimator) bytes
/// @return    whether it fits; else nothing is written
template <typename Estimator>
[[nodiscard]] bool save_state(const Estimator& estimator, std::span<std::byte> to) noexcept {
  detail::StateSize size;
  const_cast<Estimator&>(estimator).visit_state(size);
  detail::StateHeader header{.layout = size.layout};
  if (to.size() < sizeof header + size.bytes) {
    return false;
  }
  std::byte* const content = to.data() + sizeof header;
  detail::StateWriter writer(content);
  const_cast<Estimator&>(estimator).visit_state(writer);
  header.checksum = detail::checksum_of(content, size.bytes);
  std::memcpy(to.data(), &header, sizeof header);
  return true;
}

/// Puts an estimator, made with the same model and options, back into a state that save_state() wrote on the same kind of
/// machine. What comes after is the same, bit by bit.
///
/// @param from  exactly state_size(estimator) bytes
/// @return      whether they are such a state, by size, layout and checksum; else nothing has changed
template <typename Estimator>
[[nodiscard]] bool restore_state(Estimator& estimator, std::span<const std::byte> from) noexcept {
  detail::StateSize size;
  estimator.visit_state(size);
  detail::StateHeader header;
  if (from.size() != sizeof header + size.bytes) {
    return false;
  }
  const std::byte* const content = from.data() + sizeof header;
  std::memcpy(&header, from.data(), sizeof header);
  if (header.magic != detail::StateHeader::rivids || header.layout != size.layout ||
      header.checksum != detail::checksum_of(content, size.bytes)) {
    return false;
  }
  detail::StateReader reader(content);
  estimator.visit_state(reader);
  return true;
}

}  // namespace rivid
