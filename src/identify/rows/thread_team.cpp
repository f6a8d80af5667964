#include "identify/rows/thread_team.hpp"

#include <utility>

#include "threads.hpp"

namespace rivid::detail {

namespace {

// Waits until the value is another one. The next piece of work usually comes within microseconds, and
// sleeping costs more than that; where it takes longer, the processor is left to others.
template <typename T>
void wait_while(const std::atomic<T>& value, T old) {
  // pauses, tens of microseconds; a choice: a longer wait takes a processor from others
  constexpr int patience = 2000;
  for (int k = 0; k < patience; ++k) {
    if (value.load(std::memory_order_acquire) != old) {
      return;
    }
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

ThreadTeam::ThreadTeam(int size) {
  const int most = useful_threads(size);
  failures_.resize(static_cast<std::size_t>(most));
  for (int member = 1; member < most && started(others_, [this, member] { serve(member); });) {
    ++member;
  }
}

ThreadTeam::~ThreadTeam() {
  leaving_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& other : others_) {
    other.join();
  }
}

void ThreadTeam::attempt(int member) {
  try {
    (*work_)(member);
  } catch (...) {
    failures_[static_cast<std::size_t>(member)] = std::current_exception();
  }
}

void ThreadTeam::serve(int member) {
  for (std::uint32_t seen = 0;; ++seen) {
    wait_while(round_, seen);
    if (leaving_) {
      return;
    }
    attempt(member);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      busy_.notify_one();
    }
  }
}

void ThreadTeam::run(const Work& work) {
  if (others_.empty()) {
    work(0);
    return;
  }
  work_ = &work;
  busy_.store(static_cast<int>(others_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  attempt(0);
  for (int busy = busy_.load(std::memory_order_acquire); busy != 0;
       busy = busy_.load(std::memory_order_acquire)) {
    wait_while(busy_, busy);
  }
  for (std::exception_ptr& failure : failures_) {
    if (failure) {
      std::rethrow_exception(std::exchange(failure, nullptr));
    }
  }
}

}  // namespace rivid::detail
