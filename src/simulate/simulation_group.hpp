#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <span>
#include <vector>

#include "simulate/loop_run.hpp"

namespace rivid::detail {

// Threads that take turns: one of them works at a time, until it calls simulate(). When all of them have,
// these simulations are carried out together, in the lanes of a LoopPack, and one after the other they go on.
// No result depends on it.
class SimulationGroup {
 public:
  // As many threads as gain from being together.
  [[nodiscard]] static int worthwhile() { return LoopPack::lanes(); }

  explicit SimulationGroup(int members) : members_(static_cast<std::size_t>(members)) {}

  // The calling thread is one of the members while this lives.
  class Member {
   public:
    explicit Member(SimulationGroup& group);
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;
    ~Member();

   private:
    friend class SimulationGroup;
    SimulationGroup& group_;
    std::unique_lock<std::mutex> turn_;
  };
  // In place of a Member that never comes.
  void give_up();

  // Carries simulations out: all of them together, or where the calling thread has a group one after the
  // other, each with those of the other members. What one of them throws is thrown here; of several, what the
  // first one threw.
  static void carry_out(std::span<LoopRun* const> runs);

 private:
  struct Request {
    LoopRun* run;
    bool done = false;
    std::exception_ptr failure = {};
  };

  void wait_for(Request& request, std::unique_lock<std::mutex>& turn);
  void leave();
  void carry_out_all();
  static void carry_out_in_packs(std::vector<Request*> left);
  static void carry_out_together(const std::vector<Request*>& requests);

  std::mutex turn_;
  std::condition_variable done_;
  std::size_t members_;
  std::vector<Request*> waiting_;
};

}  // namespace rivid::detail
