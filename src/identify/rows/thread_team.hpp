#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace rivid::detail {

/// Threads that stay, for work that comes in pieces of a few microseconds: making a thread costs as much as
/// such a piece.
class ThreadTeam {
 public:
  using Work = std::function<void(int member)>;

  /// @param size  at least 1, the calling thread included
  explicit ThreadTeam(int size);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;
  ThreadTeam(ThreadTeam&&) = delete;
  ThreadTeam& operator=(ThreadTeam&&) = delete;

  [[nodiscard]] int size() const { return static_cast<int>(others_.size()) + 1; }

  /// Calls work(0) … work(size() − 1), each on a thread of its own, and returns when all are done. What one
  /// of them throws is thrown here; of several, what the first member threw.
  void run(const Work& work);

 private:
  void serve(int member);
  void attempt(int member);

  const Work* work_ = nullptr;
  std::atomic<std::uint32_t> round_ = 0;
  std::atomic<int> busy_ = 0;
  std::atomic<bool> leaving_ = false;
  std::vector<std::exception_ptr> failures_;
  std::vector<std::thread> others_;
};

}  // namespace rivid::detail
