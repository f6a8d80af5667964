#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// f of each element of a range, or of each number below a count, in their order
template <typename Range, typename Function>
  requires(!std::integral<Range>)
[[nodiscard]] auto made_of(const Range& range, const Function& f) {
  std::vector<std::decay_t<decltype(std::invoke(f, *std::begin(range)))>> out;
  out.reserve(static_cast<std::size_t>(std::size(range)));
  for (const auto& x : range) {
    out.push_back(std::invoke(f, x));
  }
  return out;
}
template <std::integral Count, typename Function>
[[nodiscard]] auto made_of(Count count, const Function& f) {
  std::vector<std::decay_t<decltype(f(count))>> out;
  out.reserve(static_cast<std::size_t>(count));
  for (Count k{}; k < count; ++k) {
    out.push_back(f(k));
  }
  return out;
}

// Σ f over a range, from 0 on in its order
template <typename Range, typename Function>
[[nodiscard]] auto sum_of(const Range& range, const Function& f) {
  std::decay_t<decltype(std::invoke(f, *std::begin(range)))> out{};
  for (const auto& x : range) {
    out += std::invoke(f, x);
  }
  return out;
}

// Those of the indices below a count that satisfy f.
template <typename Function>
[[nodiscard]] std::vector<Index> places_where(Index count, const Function& f) {
  std::vector<Index> out;
  for (Index k = 0; k < count; ++k) {
    if (f(k)) {
      out.push_back(k);
    }
  }
  return out;
}

}  // namespace rivid::detail
