#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <vector>

namespace rivid::benchmarks {

/// Seconds that each of several runs took in each of several turns, sorted. They take turns, so that all meet the same
/// disturbances of a busy machine.
template <std::size_t N>
std::array<std::vector<double>, N> turns(int count, const std::array<std::function<void()>, N>& runs) {
  std::array<std::vector<double>, N> out;
  for (int turn = 0; turn < count; ++turn) {
    for (std::size_t i = 0; i < N; ++i) {
      const auto start = std::chrono::steady_clock::now();
      runs[i]();
      out[i].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
  }
  for (std::vector<double>& seconds : out) {
    std::ranges::sort(seconds);
  }
  return out;
}

inline double median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

}  // namespace rivid::benchmarks
