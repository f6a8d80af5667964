#pragma once

#include <algorithm>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

// Threads within what the machine has and the system gives. No result depends on their number.
namespace rivid::detail {

/// As many as are asked for, but no more than four a processor: further ones only take turns.
[[nodiscard]] inline int useful_threads(int wanted) {
  constexpr int for_each_processor = 4;  // a choice
  const int processors = std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
  return std::clamp(wanted, 1, for_each_processor * processors);
}

/// Starts a thread with these arguments, or returns false where the system gives no more.
template <typename Thread, typename... Arguments>
[[nodiscard]] bool started(std::vector<Thread>& threads, Arguments&&... arguments) {
  try {
    threads.emplace_back(std::forward<Arguments>(arguments)...);
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

}  // namespace rivid::detail
