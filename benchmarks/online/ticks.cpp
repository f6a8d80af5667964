// Time of one tick of each estimator, seven joints.

#include <algorithm>
#include <ctime>
#include <iomanip>
#include <iostream>

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
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
            << ", 99.9 % " << at(0.999) << ", worst " << us.back() << ", 99.9 % over median "
            << at(0.999) / at(0.5) << '\n';
}

}  // namespace

void tick_study(const std::string& data) {
  const Arm arm = arms(data).back();
  const Index n = arm.robot.size();
  const Motion motion = test::Wandering(n, 4, 0.6, 0.9).at(test::ticks(60.0, f_m));
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
  const auto timed = [&](const char* name, const auto& tick) {
    std::vector<double> us;
    us.reserve(static_cast<std::size_t>(q.cols()));
    for (Index k = 0; k < q.cols(); ++k) {
      const double begin = now_us();
      tick(k);
      us.push_back(now_us() - begin);
    }
    print_times(name, us);
  };
  std::cout << n << " joints, " << arm.model.base.size() << " base parameters, stride " << stream.stride()
            << " ticks\n";
  timed("nothing (the clock)", [](Index /*k*/) {});
  timed("rows alone", [&](Index k) { stream.update(q.col(k), tau.col(k)); });
  timed("payload", [&](Index k) { payload.update(q.col(k), tau.col(k)); });
  timed("contact", [&](Index k) { contact.update(q.col(k), qd.col(k), tau.col(k)); });
  timed("friction", [&](Index k) { friction.update(q.col(k), tau.col(k)); });
  timed("all base parameters", [&](Index k) { identifier.update(q.col(k), tau.col(k)); });
  timed("all base parameters, solved each tick", [&](Index k) {
    identifier.update(q.col(k), tau.col(k));
    static_cast<void>(identifier.chi());
  });
}

}  // namespace rivid::benchmarks
