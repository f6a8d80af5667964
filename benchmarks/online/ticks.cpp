// Time of one tick of each estimator, seven joints.
//
// The same ticks from the same state take the same work. So each tick is timed in many repetitions of the
// whole sequence, and the least time counts: what the code takes, without what interrupts it. The worst of
// these is the code's worst tick.

#include <algorithm>
#include <ctime>
#include <iomanip>
#include <iostream>

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/saved_state.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

double now_us() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

void print_times(const char* name, std::vector<double> us) {
  std::ranges::sort(us);
  const auto at = [&](double part) {
    return us[static_cast<std::size_t>(part * static_cast<double>(us.size() - 1))];
  };
  std::cout << std::setprecision(3) << name << ": median " << at(0.5) << " µs, 99 % " << at(0.99)
            << ", 99.9 % " << at(0.999) << ", worst " << us.back() << ", worst over median "
            << us.back() / at(0.5) << '\n';
}

constexpr double seconds = 10.0;  // of motion that is repeated

}  // namespace

void tick_study(const std::string& data, int repetitions) {
  const Arm arm = arms(data).back();
  const Index n = arm.robot.size();
  const Motion motion = test::Wandering(n, 4, 0.6, 0.9).at(test::ticks(2.0 * seconds, f_m));
  std::mt19937_64 random(3);
  const Matrix tau = noisy(torques_of(arm.robot, arm.chi_st, motion), arm.torque_noise, random).transpose();
  const Matrix q = noisy(motion.q, Vector::Constant(n, encoder_noise), random).transpose();
  const Matrix qd = motion.qd.transpose();
  const RowStreamOptions rows = {.f_m = f_m};
  RowStream<double> stream(arm.robot, arm.model.base.columns(), rows);
  PayloadEstimator<double> payload(arm.model, {.rows = rows});
  FrictionMonitor<double> friction(arm.model, {.rows = rows});
  ContactObserver<double> contact(DynamicModel(arm.robot, arm.model.base, arm.model.chi), {.f_m = f_m});
  RecursiveIdentifier<double> identifier(arm.model, {.rows = rows, .forgetting = 60.0});
  // The first half of the motion brings an estimator into its usual state, from which the second half is
  // repeated.
  const Index half = q.cols() / 2;
  const auto timed = [&](const char* name, auto& estimator, const auto& tick) {
    for (Index k = 0; k < half; ++k) {
      tick(k);
    }
    // Rows alone have no state to be put back into: their time does not depend on it.
    constexpr bool has_state = requires { estimator.state_owner(); };
    std::vector<std::byte> state;
    if constexpr (has_state) {
      state.resize(state_size(estimator));
      static_cast<void>(save_state(estimator, state));
    }
    std::vector<double> us(static_cast<std::size_t>(q.cols() - half), 1e300);
    for (int i = 0; i < repetitions; ++i) {
      if constexpr (has_state) {
        static_cast<void>(restore_state(estimator, state));
      }
      for (Index k = half; k < q.cols(); ++k) {
        const double begin = now_us();
        tick(k);
        double& least = us[static_cast<std::size_t>(k - half)];
        least = std::min(least, now_us() - begin);
      }
    }
    print_times(name, us);
  };
  std::cout << n << " joints, " << arm.model.base.size() << " base parameters, stride " << stream.stride()
            << " ticks\n";
  timed("nothing (the clock)", stream, [](Index /*k*/) {});
  timed("rows alone", stream, [&](Index k) { stream.update(q.col(k), tau.col(k)); });
  timed("payload", payload, [&](Index k) { payload.update(q.col(k), tau.col(k)); });
  timed("contact", contact, [&](Index k) { contact.update(q.col(k), qd.col(k), tau.col(k)); });
  timed("friction", friction, [&](Index k) { friction.update(q.col(k), tau.col(k)); });
  timed("all base parameters", identifier, [&](Index k) { identifier.update(q.col(k), tau.col(k)); });
  timed("all base parameters, solved each tick", identifier, [&](Index k) {
    identifier.update(q.col(k), tau.col(k));
    static_cast<void>(identifier.chi());
  });
}

}  // namespace rivid::benchmarks
