#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ranges>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "rivid/model/chain.hpp"

namespace rivid {

namespace detail {

// FNV-1a, a word at a time.
[[nodiscard]] constexpr std::uint64_t hashed(std::uint64_t hash, std::uint64_t word) noexcept {
  hash = (hash ^ word) * 0x100000001b3U;
  return hash ^ (hash >> 32U);
}
inline constexpr std::uint64_t first_hash = 0xcbf29ce484222325U;  // offset basis of FNV-1a of 64 bits

// Calls take(first, count) for all plain values of a state, always in the same order. A class lists the parts
// of its state in `state()`: classes with a state of their own, arrays, plain values and structs of these.
template <typename Part, typename Take>
void for_each_saved(Part& part, const Take& take) noexcept {
  if constexpr (requires { part.state(); }) {
    std::apply([&](auto&... parts) { (for_each_saved(parts, take), ...); }, part.state());
  } else if constexpr (requires { part.data(); }) {
    static_assert(std::is_trivially_copyable_v<std::remove_cvref_t<decltype(*part.data())>>);
    take(part.data(), static_cast<std::size_t>(part.size()));
  } else {
    static_assert(std::is_trivially_copyable_v<Part>);
    take(&part, std::size_t{1});
  }
}

// Bytes of a state, and a hash of the sizes of its arrays.
struct StateSize {
  template <typename Estimator>
  explicit StateSize(const Estimator& estimator) noexcept {
    // What visits a state may change it; this changes nothing.
    for_each_saved(const_cast<Estimator&>(estimator), [this](const auto* values, std::size_t count) {
      bytes += count * sizeof *values;
      layout = hashed(hashed(layout, sizeof *values), count);
    });
  }
  std::size_t bytes = 0;
  std::uint64_t layout = first_hash;
};

// A number that is another one, all but surely, where any of the values is.
class Fingerprint {
 public:
  template <typename... Values>
  [[nodiscard]] static std::uint64_t of(const Values&... values) noexcept {
    Fingerprint out;
    (out.add(values), ...);
    return out.hash_;
  }

 private:
  template <typename Value>
  void add(const Value& value) noexcept {
    if constexpr (std::is_floating_point_v<Value>) {
      add(std::bit_cast<std::uint64_t>(static_cast<double>(value)));
    } else if constexpr (std::is_integral_v<Value> || std::is_enum_v<Value>) {
      hash_ = hashed(hash_, static_cast<std::uint64_t>(value));
    } else if constexpr (requires { value.rows(); }) {
      add(value.rows());
      for (Index i = 0; i < value.size(); ++i) {
        add(value(i % value.rows(), i / value.rows()));
      }
    } else if constexpr (std::is_same_v<Value, Chain>) {
      add(value.gravity);
      add(value.parents);
      for (const auto& [type, R, p, axes, signs] : value.links) {
        add(of(type, R, p, axes, signs));
      }
      for (const Chain::Dependent& dependent : value.dependents) {
        add(dependent.numbers());
      }
    } else {
      for (const auto& each : value) {
        add(each);
      }
    }
  }

  std::uint64_t hash_ = first_hash;
};

// Whose state it is: fingerprints of what an estimator was made of.
struct StateOwner {
  std::uint64_t kind = 0;
  std::uint64_t arm = 0;
  std::uint64_t rate = 0;
  std::uint64_t flange = 0;
  std::uint64_t options = 0;
};

template <typename Scalar>
[[nodiscard]] std::uint64_t kind_of(std::string_view estimator) noexcept {
  return Fingerprint::of(estimator, sizeof(Scalar));
}

// What stands before the bytes of a state.
struct StateHeader {
  static constexpr std::uint64_t rivids = 0x3254415453564952U;  // "RIVSTAT2"

  std::uint64_t magic = rivids;
  StateOwner owner = {};
  std::uint64_t layout = 0;
  std::uint64_t checksum = 0;
};

[[nodiscard]] inline std::uint64_t checksum_of(const std::byte* bytes, std::size_t count) noexcept {
  std::uint64_t hash = first_hash;
  for (std::size_t at = 0; at < count; at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + at, std::min(sizeof word, count - at));
    hash = hashed(hash, word);
  }
  return hash;
}

}  // namespace detail

/// Bytes that the state of an estimator takes: what it has learned, without model and options.
template <typename Estimator>
[[nodiscard]] std::size_t state_size(const Estimator& estimator) noexcept {
  return sizeof(detail::StateHeader) + detail::StateSize(estimator).bytes;
}

/// Writes the state of an estimator. No allocation: the memory is the caller's.
///
/// @param to  at least state_size(estimator) bytes
/// @return    whether it fits; else nothing is written
template <typename Estimator>
[[nodiscard]] bool save_state(const Estimator& estimator, std::span<std::byte> to) noexcept {
  const detail::StateSize size(estimator);
  detail::StateHeader header{.owner = estimator.state_owner(), .layout = size.layout};
  if (to.size() < sizeof header + size.bytes) {
    return false;
  }
  std::byte* const content = to.data() + sizeof header;
  std::byte* next = content;
  detail::for_each_saved(const_cast<Estimator&>(estimator), [&](const auto* values, std::size_t count) {
    std::memcpy(next, values, count * sizeof *values);
    next += count * sizeof *values;
  });
  header.checksum = detail::checksum_of(content, size.bytes);
  std::memcpy(to.data(), &header, sizeof header);
  return true;
}

/// What restore_state() says: true where the estimator has the state, else words.
struct Restored {
  const char* refusal = nullptr;  ///< what does not fit; null where nothing does not

  explicit operator bool() const noexcept { return refusal == nullptr; }
};

/// Puts an estimator, made with the same model and options, back into a state that save_state() wrote with
/// the same build on the same kind of machine. What comes after is the same, bit by bit.
///
/// @param from  exactly state_size(estimator) bytes
/// @return      whether they are such a state, and what differs where they are not; then nothing has changed
template <typename Estimator>
[[nodiscard]] Restored restore_state(Estimator& estimator, std::span<const std::byte> from) noexcept {
  const detail::StateSize size(estimator);
  detail::StateHeader header;
  if (from.size() < sizeof header) {
    return {"restore_state: these bytes are no state"};
  }
  std::memcpy(&header, from.data(), sizeof header);
  const std::span<const std::byte> content = from.subspan(sizeof header);
  const detail::StateOwner& its = header.owner;
  const detail::StateOwner& own = estimator.state_owner();
  struct Check {
    bool passed;
    const char* words;
  };
  const std::array checks = {
      Check{header.magic == detail::StateHeader::rivids,
            "restore_state: these bytes are no state of this version of rivid"},
      Check{its.kind == own.kind,
            "restore_state: the state is that of another class of estimators or another Scalar"},
      Check{its.arm == own.arm,
            "restore_state: the state is that of another arm: its model or covariance differs"},
      Check{its.rate == own.rate, "restore_state: the state is that of another rate: f_m differs"},
      Check{its.flange == own.flange,
            "restore_state: the state is that of another flange: its pose R, p differs"},
      Check{its.options == own.options,
            "restore_state: the state is that of an estimator with other options"},
      Check{header.layout == size.layout && content.size() == size.bytes,
            "restore_state: the state has not the size of this estimator's"},
      Check{header.checksum == detail::checksum_of(content.data(), content.size()),
            "restore_state: the state is damaged: its checksum differs"}};
  for (const Check& check : checks) {
    if (!check.passed) {
      return {check.words};
    }
  }
  const std::byte* next = content.data();
  detail::for_each_saved(estimator, [&](auto* values, std::size_t count) {
    std::memcpy(values, next, count * sizeof *values);
    next += count * sizeof *values;
  });
  return {};
}

}  // namespace rivid
