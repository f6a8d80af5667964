// PayloadEstimator on simulated pick-ups, and its false alarms.

#include <algorithm>
#include <array>
#include <iomanip>
#include <iostream>
#include <numeric>

#include "rivid/online/payload_estimator.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

double quantile(std::vector<double> x, double part) {
  if (x.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::ranges::sort(x);
  return x[static_cast<std::size_t>(part * static_cast<double>(x.size() - 1))];
}

PayloadEstimatorOptions options() {
  return {.rows = {.f_m = f_m, .torque_held = false}, .friction_change = friction_error};
}

// A pick-up that was seen late.
struct Late {
  double mass = 0.0;   // [kg]
  double delay = 0.0;  // [s]
};

struct Tally {
  int pick_ups = 0;
  int missed = 0;
  int false_alarms = 0;
  double quiet_hours = 0.0;
  std::vector<double> delays;
  std::array<int, 4> held{};  // intervals of mass and centre of mass that hold the truth
  int told = 0;
  std::vector<double> half_widths;
  std::vector<double> errors;
  std::vector<Late> late;
};

void pick_up(const Arm& arm, std::uint64_t seed, Tally& tally) {
  const PickUp scene(arm, seed);
  const Inertial& body = scene.body;
  const Index change = scene.change;
  PayloadEstimator<double> estimator(arm.model, options());
  bool found = false;
  ++tally.pick_ups;
  for (Index k = 0; k < scene.q.cols(); ++k) {
    if (estimator.update(scene.q.col(k), scene.tau.col(k))) {
      if (k < change || found) {
        ++tally.false_alarms;
      } else {
        found = true;
        tally.delays.push_back(static_cast<double>(k - change) / f_m);
      }
    }
    for (const double later : {2.0, 5.0, 9.9}) {
      if (k == change + static_cast<Index>(later * f_m)) {
        const auto& p = estimator.payload();
        ++tally.told;
        const Eigen::Vector3d com = body.segment<3>(6) / body[9];
        tally.held[0] += std::abs(p.mass - body[9]) <= p.mass_half_width() ? 1 : 0;
        for (Index i = 0; i < 3; ++i) {
          tally.held[static_cast<std::size_t>(i) + 1] +=
              std::abs(p.com[i] - com[i]) <= 1.96 * p.com_sigma[i] ? 1 : 0;
        }
        tally.half_widths.push_back(p.mass_half_width());
        tally.errors.push_back(std::abs(p.mass - body[9]));
      }
    }
  }
  tally.quiet_hours += (PickUp::before + PickUp::after) / 3600.0;
  tally.missed += found ? 0 : 1;
  if (!found || tally.delays.back() > asked_delay) {
    tally.late.push_back({body[9], found ? tally.delays.back() : PickUp::after});
  }
}

void print(const std::string& name, const Tally& tally) {
  std::cout << std::setprecision(3) << name << ": " << tally.pick_ups << " pick-ups, missed " << tally.missed
            << ", delay median " << quantile(tally.delays, 0.5) << " 95 % " << quantile(tally.delays, 0.95)
            << " worst " << quantile(tally.delays, 1.0) << " s, false alarms " << tally.false_alarms << " in "
            << tally.quiet_hours << " h; coverage";
  for (const int held : tally.held) {
    std::cout << ' ' << 100.0 * held / std::max(tally.told, 1);
  }
  std::cout << " %, all "
            << 25.0 * std::accumulate(tally.held.begin(), tally.held.end(), 0) / std::max(tally.told, 1)
            << " %; half width of the mass " << quantile(tally.half_widths, 0.5) << " kg, error "
            << quantile(tally.errors, 0.5) << " kg\n";
  for (const Late& one : tally.late) {
    std::cout << "  " << one.mass << " kg seen after " << one.delay << " s\n";
  }
}

}  // namespace

void pick_up_study(const std::string& data, int pick_ups, const std::string& only) {
  for (const Arm& arm : arms(data, only)) {
    Tally tally;
    for (int k = 0; k < pick_ups; ++k) {
      pick_up(arm, static_cast<std::uint64_t>(k) + 1, tally);
    }
    print(arm.name, tally);
  }
}

void false_alarm_study(const std::string& data, double hours, const std::string& only) {
  constexpr double seconds = 300.0;
  for (const Arm& arm : arms(data, only)) {
    int alarms = 0;
    double done = 0.0;
    double highest = 0.0;
    for (std::uint64_t seed = 1; done < hours * 3600.0; ++seed, done += seconds) {
      std::mt19937_64 random(seed);
      Vector chi_st = with_friction_error(arm.robot, arm.chi_st, friction_error, random);
      if (seed % 2 == 0) {
        chi_st = test::loaded(arm.robot, chi_st, random_payload(random));
      }
      const Motion motion =
          test::Wandering(arm.robot.size(), seed + 9000, 0.6, 0.9).at(test::ticks(seconds, f_m));
      const Matrix tau = noisy(torques_of(arm.robot, chi_st, motion), arm.torque_noise, random).transpose();
      const Matrix q = noisy(motion.q, Vector::Constant(arm.robot.size(), encoder_noise), random).transpose();
      PayloadEstimator<double> estimator(arm.model, options());
      for (Index k = 0; k < q.cols(); ++k) {
        alarms += estimator.update(q.col(k), tau.col(k)) ? 1 : 0;
        highest = std::max(highest, estimator.suspicion());
      }
    }
    std::cout << arm.name << ": " << alarms << " false alarms in " << done / 3600.0 << " h, highest test "
              << highest << " of the threshold" << std::endl;
  }
}

}  // namespace rivid::benchmarks
