// FrictionMonitor while dry friction grows by 30 % in ten minutes.

#include <iomanip>
#include <iostream>

#include "rivid/online/friction_monitor.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

void drift_study(const std::string& data, const std::string& only) {
  constexpr double seconds = 600.0;
  constexpr double growth = 0.3;
  for (const Arm& arm : arms(data, only)) {
    const Index n = arm.robot.size();
    FrictionMonitor<double> monitor(arm.model, {.rows = {.f_m = f_m, .torque_held = false}});
    // The same ticks without the drift.
    FrictionMonitor<double> unworn = monitor;
    Vector fresh(n);
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    InverseDynamics dynamics{DynamicModel(arm.robot, arm.chi_st)};
    std::vector<double> worst(monitor.coefficients().size(), 0.0);
    std::vector<double> advised(static_cast<std::size_t>(n), -1.0);
    Vector tau(n);
    Vector q(n);
    Index k = 0;
    // One motion of sines, in pieces that follow one another.
    const test::Wandering wandering(n, 8123, 0.6, 0.9);
    for (double done = 0.0; done < seconds; done += 60.0) {
      const Vector t = test::ticks(60.0, f_m).array() + done;
      const Motion motion = wandering.at(t);
      const Matrix positions = motion.q.transpose();
      const Matrix velocities = motion.qd.transpose();
      const Matrix accelerations = motion.qdd.transpose();
      for (Index i = 0; i < t.size(); ++i, ++k) {
        dynamics.torque(positions.col(i), velocities.col(i), accelerations.col(i), tau);
        for (Index j = 0; j < n; ++j) {
          const double Fc = arm.robot.joints[static_cast<std::size_t>(j)].Fc;
          fresh[j] = tau[j] + arm.torque_noise[j] * normal(random);
          tau[j] = fresh[j] + Fc * growth * t[i] / seconds * sign(velocities(j, i));
          q[j] = positions(j, i) + encoder_noise * normal(random);
        }
        monitor.update(q, tau);
        unworn.update(q, fresh);
        for (Index j = 0; j < n; ++j) {
          if (advised[static_cast<std::size_t>(j)] < 0.0 && monitor.identify_anew(j)) {
            advised[static_cast<std::size_t>(j)] = t[i];
          }
        }
        for (std::size_t c = 0; t[i] > 60.0 && c < worst.size(); ++c) {
          const auto& coefficient = monitor.coefficients()[c];
          if (coefficient.kind == ParameterKind::Fc) {
            const double Fc = arm.robot.joints[static_cast<std::size_t>(coefficient.joint)].Fc;
            const double now = Fc * (1.0 + growth * t[i] / seconds);
            worst[c] = std::max(worst[c], std::abs(monitor.value(static_cast<Index>(c)) / now - 1.0));
          }
        }
      }
    }
    monitor.finish();
    unworn.finish();
    const Vector chi = monitor.chi();
    const Vector without = unworn.chi();
    const Vector truth = arm.model.base.from_standard(arm.chi_st);
    int inertial = 0;
    int within = 0;         // the 95 % intervals of the identification
    int within_unworn = 0;  // … without the drift
    int hold = 0;           // intervals as wide that hold the truth
    double moved = 0.0;     // by the drift, in deviations of the identification
    for (Index i = 0; i < chi.size(); ++i) {
      if (is_friction(arm.model.base.parameters[static_cast<std::size_t>(i)].leading.kind)) {
        continue;
      }
      const double sigma = std::sqrt(arm.model.C_chi(i, i));
      const auto inside = [&](double x, double centre) {
        return std::abs(x - centre) <= 1.96 * sigma ? 1 : 0;
      };
      ++inertial;
      within += inside(chi[i], arm.model.chi[i]);
      within_unworn += inside(without[i], arm.model.chi[i]);
      hold += inside(truth[i], chi[i]);
      moved = std::max(moved, std::abs(chi[i] - without[i]) / sigma);
    }
    std::cout << std::setprecision(3) << arm.name
              << ": largest error of Fc after the first minute, by joint [%]:";
    for (std::size_t c = 0; c < worst.size(); ++c) {
      if (monitor.coefficients()[c].kind == ParameterKind::Fc) {
        std::cout << ' ' << 100.0 * worst[c];
      }
    }
    std::cout << "; drift at the end in deviations:";
    for (std::size_t c = 0; c < worst.size(); ++c) {
      if (monitor.coefficients()[c].kind == ParameterKind::Fc) {
        std::cout << ' ' << monitor.drift(static_cast<Index>(c));
      }
    }
    std::cout << "; a new identification advised after [s]:";
    for (const double at : advised) {
      std::cout << ' ' << at;
    }
    std::cout << "; inertial parameters within their 95 % intervals " << within << " of " << inertial << ", "
              << within_unworn << " without the drift, which moves them by " << moved
              << " deviations at most; intervals as wide about the new values hold the truth of " << hold
              << std::endl;
  }
}

}  // namespace rivid::benchmarks
