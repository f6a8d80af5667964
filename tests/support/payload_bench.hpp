#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>

#include "rivid/identify/payload.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/regressor/base.hpp"
#include "support/normal.hpp"
#include "support/online.hpp"

namespace rivid::test {

// A box on the flange.
struct Box {
  double mass = 3.0;
  Eigen::Vector3d com = {0.04, -0.02, 0.11};
  Eigen::Matrix3d inertia = Eigen::Vector3d(0.03, 0.025, 0.012).asDiagonal();

  [[nodiscard]] Inertial inertial() const { return inertial_from_com(mass, com, inertia); }
};

// Normal numbers whose mean and variance are exactly 0 and 1: what a few dozen random ones miss of that is no
// error of an interval.
inline Vector standard_normal(Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Normal normal;
  Vector out = Vector::NullaryExpr(count, [&](Index /*at*/) { return normal(random); });
  out.array() -= out.mean();
  return std::sqrt(static_cast<double>(count)) / out.norm() * out;
}

// An arm that moves by sines, and its torques with any load on a link.
class PayloadBench {
 public:
  explicit PayloadBench(Robot its_robot, Index samples = 2500)
      : robot(std::move(its_robot)), samples_(samples) {
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::symmetric;
      joint.Fv = 1.0 + 0.1 * static_cast<double>(joint.name.size());
      joint.Fc = 2.0;
    }
  }

  [[nodiscard]] Log log(const Inertial& load, double sigma, std::uint64_t seed, std::uint64_t motion) const {
    Log out;
    out.source = "run_" + std::to_string(motion) + ".csv";
    out.f_m = 100.0;
    out.t = Vector::NullaryExpr(samples_, [&](Index k) { return static_cast<double>(k) / out.f_m; });
    std::mt19937_64 random(motion);
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    out.q = Matrix::Zero(samples_, robot.size());
    for (Index j = 0; j < robot.size(); ++j) {
      for (int harmonic = 1; harmonic <= 6; ++harmonic) {
        const double a = symmetric(random) / std::sqrt(harmonic);
        const double phase = 3.0 * symmetric(random);
        for (Index k = 0; k < samples_; ++k) {
          out.q(k, j) += a * std::sin(0.005 * harmonic * static_cast<double>(k) + phase);
        }
      }
    }
    out.tau = Matrix::Ones(samples_, robot.size());
    const BaseParameters base = base_parameters(robot);
    Vector chi_st = robot.chi_st();
    for (std::size_t i = 0; i < base.standard.size(); ++i) {
      const StandardParameter& p = base.standard[i];
      if (p.joint == (loaded_link < 0 ? static_cast<int>(robot.size()) - 1 : loaded_link) &&
          role(p.kind) == Role::inertial) {
        chi_st[static_cast<Index>(i)] += load[static_cast<Index>(p.kind)];
      }
    }
    const Vector chi = base.from_standard(chi_st);
    Normal noise(0.0, sigma);
    std::mt19937_64 errors(seed);
    const Rows made = rows(robot, base, out, signal());
    for (std::size_t j = 0; j < made.Y.size(); ++j) {
      const JointRows& joint = made.W.joints[j];
      const auto at = static_cast<Index>(j);
      Vector tau = joint.W * chi(joint.columns);
      if (Fl.size() > 0) {
        Vector rigid = Vector::Zero(tau.size());
        Vector sign = rigid;
        for (std::size_t c = 0; c < joint.columns.size(); ++c) {
          const StandardParameter& p = base.parameters[static_cast<std::size_t>(joint.columns[c])].leading;
          const auto column = joint.W.col(static_cast<Index>(c));
          if (!is_friction(p.kind)) {
            rigid += chi[joint.columns[c]] * column;
          } else if (p.kind == ParameterKind::Fc) {
            sign = column;
          }
        }
        tau += Fl[at] * sign.cwiseProduct(rigid.cwiseAbs());
      }
      for (Index k = 0; k < tau.size(); ++k) {
        out.tau(made.samples[j][static_cast<std::size_t>(k)], at) = (tau[k] + noise(errors)) * gain(at);
      }
    }
    return out;
  }

  // mass  of the box where it is known
  [[nodiscard]] PayloadReport identified(const Box& box, double sigma, std::uint64_t seed,
                                         const PayloadOptions& options = {},
                                         std::optional<double> mass = {}) const {
    const Log without = log(Inertial::Zero(), sigma, 2 * seed, 1);
    const Log with = log(box.inertial(), sigma, 2 * seed + 1, 2);
    const LoadedLogs loaded{.logs = std::span(&with, 1), .mass = mass};
    return identify_payloads(robot, std::span(&without, 1), std::span(&loaded, 1), {.signal = signal()},
                             options);
  }

  static SignalOptions signal() { return {.rows = RowScheme::paper, .velocity_threshold = {}}; }

  Robot robot;
  Vector gains = {};     // measured torque per torque
  Vector Fl = {};        // friction by load
  int loaded_link = -1;  // −1: the last one

 private:
  [[nodiscard]] double gain(Index j) const { return gains.size() > 0 ? gains[j] : 1.0; }
  Index samples_;
};

inline Robot six_axis() { return read_urdf(RIVID_DATA "/six_axis/six_axis.urdf"); }

/// A log with exact torques, in which some joints stand.
inline Log log_with_joints_at_rest(const Robot& robot, const Inertial& load, std::uint64_t seed,
                                   const std::vector<Index>& at_rest) {
  constexpr double f_m = 500.0;
  constexpr double seconds = 10.0;
  Motion motion = Wandering(robot.size(), seed, 0.8, 1.2).at(ticks(seconds, f_m));
  for (const Index j : at_rest) {
    motion.q.col(j).setConstant(0.3);
    motion.qd.col(j).setZero();
    motion.qdd.col(j).setZero();
  }
  Log out;
  out.source = "rest_" + std::to_string(seed) + ".csv";
  out.f_m = f_m;
  out.t = ticks(seconds, f_m);
  out.q = motion.q;
  out.tau = torques(DynamicModel(robot, loaded(robot, robot.chi_st(), load)), motion);
  return out;
}

}  // namespace rivid::test
