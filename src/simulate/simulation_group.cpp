#include "simulate/simulation_group.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace rivid::detail {

namespace {

thread_local SimulationGroup::Member* this_member = nullptr;

// A step of so few loops is as fast one by one.
constexpr int fewest_in_a_pack = 2;

}  // namespace

SimulationGroup::Member::Member(SimulationGroup& group) : group_(group), turn_(group.turn_) {
  this_member = this;
}

SimulationGroup::Member::~Member() {
  this_member = nullptr;
  group_.leave();
}

void SimulationGroup::give_up() {
  const std::scoped_lock turn(turn_);
  leave();
}

// Those who wait no longer wait for this one.
void SimulationGroup::leave() {
  --members_;
  if (!waiting_.empty() && waiting_.size() == members_) {
    carry_out_all();
  }
}

void SimulationGroup::carry_out(std::span<LoopRun* const> runs) {
  std::vector<Request> requests;
  requests.reserve(runs.size());
  std::vector<Request*> all;
  for (LoopRun* const run : runs) {
    all.push_back(&requests.emplace_back(run));
    if (this_member != nullptr) {
      this_member->group_.wait_for(requests.back(), this_member->turn_);
    }
  }
  if (this_member == nullptr) {
    carry_out_in_packs(all);
  }
  for (const Request& request : requests) {
    if (request.failure) {
      std::rethrow_exception(request.failure);
    }
  }
}

void SimulationGroup::wait_for(Request& request, std::unique_lock<std::mutex>& turn) {
  waiting_.push_back(&request);
  if (waiting_.size() == members_) {
    carry_out_all();
  } else {
    done_.wait(turn, [&] { return request.done; });
  }
}

void SimulationGroup::carry_out_all() {
  const std::vector<Request*> all = std::move(waiting_);
  waiting_.clear();
  carry_out_in_packs(all);
  for (Request* request : all) {
    request->done = true;
  }
  done_.notify_all();
}

void SimulationGroup::carry_out_in_packs(std::vector<Request*> left) {
  while (!left.empty()) {
    const LoopOde& first = left.front()->run->ode();
    const auto unfit = std::stable_partition(left.begin() + 1, left.end(), [&](const Request* request) {
      return LoopPack::fit(first, request->run->ode());
    });
    const auto rest = left.begin() + std::min<std::ptrdiff_t>(unfit - left.begin(), LoopPack::lanes());
    carry_out_together({left.begin(), rest});
    left.erase(left.begin(), rest);
  }
}

void SimulationGroup::carry_out_together(const std::vector<Request*>& requests) {
  // What a control law or a reference of one's own throws is for the thread that brought it.
  const auto guarded = [](Request& request, const auto& work) {
    try {
      work(*request.run);
    } catch (...) {
      request.failure = std::current_exception();
    }
  };
  if (std::ssize(requests) < fewest_in_a_pack) {
    guarded(*requests.front(), [](LoopRun& run) { run.carry_out(); });
    return;
  }
  std::vector<LoopOde*> loops;
  for (Request* request : requests) {
    loops.push_back(&request->run->ode());
    request->run->start_clock();
  }
  LoopPack pack(loops);
  std::vector<LoopPackStep> steps(requests.size());
  const auto goes_on = [](const Request* request) { return !request->failure && !request->run->over(); };
  while (std::ranges::any_of(requests, goes_on)) {
    int together = 0;
    for (std::size_t lane = 0; lane < requests.size(); ++lane) {
      steps[lane] = {};
      if (goes_on(requests[lane])) {
        guarded(*requests[lane], [&](LoopRun& run) {
          if (run.period_ended()) {
            run.begin_period();
          }
          steps[lane] = run.step_for_pack();
          together += steps[lane].h > 0.0 ? 1 : 0;
        });
      }
    }
    const bool stepped = together >= fewest_in_a_pack && pack.step(steps);
    for (std::size_t lane = 0; lane < requests.size(); ++lane) {
      if (goes_on(requests[lane])) {
        guarded(*requests[lane], [&](LoopRun& run) {
          if (stepped && steps[lane].h > 0.0 && pack.valid(lane)) {
            run.take(pack, lane);
          } else {
            run.finish_period();
          }
        });
      }
    }
  }
}

}  // namespace rivid::detail
