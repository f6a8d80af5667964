#pragma once

#include <cmath>
#include <random>

#include "rivid/data/log.hpp"
#include "rivid/online/model.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid::test {

/// Sums of sines, each joint with its own: positions with their exact derivatives.
class Wandering {
 public:
  Wandering(Index joints, std::uint64_t seed, double amplitude = 0.5, double slowest = 0.8) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (Index j = 0; j < joints; ++j) {
      for (Index k = 0; k < waves; ++k) {
        const double omega = slowest * (static_cast<double>(k + 1) + 0.6 * unit(random));
        waves_.push_back(
            {amplitude * (0.5 + unit(random)) / static_cast<double>(k + 1), omega, 6.28 * unit(random)});
      }
    }
    joints_ = joints;
  }

  [[nodiscard]] Motion at(const Vector& t) const {
    Motion out;
    out.q = out.qd = out.qdd = Matrix::Zero(t.size(), joints_);
    for (Index i = 0; i < t.size(); ++i) {
      for (Index j = 0; j < joints_; ++j) {
        for (Index k = 0; k < waves; ++k) {
          const Wave& w = waves_[static_cast<std::size_t>(j * waves + k)];
          const double phase = w.omega * t[i] + w.phase;
          out.q(i, j) += w.amplitude * std::sin(phase);
          out.qd(i, j) += w.amplitude * w.omega * std::cos(phase);
          out.qdd(i, j) -= w.amplitude * w.omega * w.omega * std::sin(phase);
        }
      }
    }
    return out;
  }

 private:
  static constexpr Index waves = 4;
  struct Wave {
    double amplitude, omega, phase;
  };
  Index joints_ = 0;
  std::vector<Wave> waves_;
};

/// Times 0, 1 / f_m, …
inline Vector ticks(double seconds, double f_m) {
  const auto count = static_cast<Index>(std::lround(seconds * f_m));
  return Vector::LinSpaced(count, 0.0, static_cast<double>(count - 1) / f_m);
}

/// Torques of a motion, one row a sample, by inverse_dynamics().
inline Matrix torques(const DynamicModel& model, const Motion& motion) {
  Matrix out(motion.samples(), motion.joints());
  for (Index k = 0; k < motion.samples(); ++k) {
    out.row(k) = inverse_dynamics(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                  motion.qdd.row(k).transpose())
                     .transpose();
  }
  return out;
}

/// Standard parameters with another body on the last link [frame of the link].
inline Vector loaded(const Robot& robot, Vector chi_st, const Inertial& body) {
  const std::vector<StandardParameter> all = robot.standard_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto k = static_cast<Index>(all[i].kind);
    if (all[i].joint == robot.size() - 1 && k < inertial_count) {
      chi_st[static_cast<Index>(i)] += body[k];
    }
  }
  return chi_st;
}

/// A model that an identification might have found: true values with a covariance of 1 %, at least 0.01 of
/// the unit.
inline OnlineModel known_model(const Robot& robot, const Vector& chi_st, double sigma_rho) {
  OnlineModel out;
  out.robot = robot;
  out.base = base_parameters(robot);
  out.chi = out.base.from_standard(chi_st);
  out.C_chi = out.chi.cwiseAbs().cwiseMax(1.0).cwiseAbs2().asDiagonal();
  out.C_chi *= 1e-4;
  out.sigma_rho = Vector::Constant(robot.size(), sigma_rho);
  out.velocity_threshold = Vector::Constant(robot.size(), 0.02);
  return out;
}

}  // namespace rivid::test
