#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "../robots.hpp"
#include "bodies.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/online/model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/online.hpp"

// Three arms that are known exactly, and what estimators would be given of them.
namespace rivid::benchmarks {

inline constexpr double f_m = 1000.0;             // ticks a second
inline constexpr double encoder_noise = 1e-5;     // rad
inline constexpr double identified_seconds = 30;  // of the log that an arm was identified from
inline constexpr double asked_delay = 0.3;        // of a pick-up that is seen in time [s]

struct Arm {
  std::string name;
  Robot robot;
  Vector chi_st;        // the truth
  Vector torque_noise;  // of each tick, (n) [N·m]
  OnlineModel model;    // identified from a noisy log
};

inline Vector noise_of(Index joints) {
  return Vector::LinSpaced(joints, 2.0, 0.4);  // of the torques at 1 kHz
}

inline Matrix noisy(const Matrix& x, const Vector& sigma, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Matrix out = x;
  for (Index k = 0; k < x.rows(); ++k) {
    for (Index j = 0; j < x.cols(); ++j) {
      out(k, j) += sigma[j] * normal(random);
    }
  }
  return out;
}

// Torques of a motion, one row a sample.
inline Matrix torques_of(const Robot& robot, const Vector& chi_st, const Motion& motion) {
  InverseDynamics dynamics{DynamicModel(robot, chi_st)};
  Matrix out(motion.joints(), motion.samples());
  const Matrix q = motion.q.transpose();
  const Matrix qd = motion.qd.transpose();
  const Matrix qdd = motion.qdd.transpose();
  for (Index k = 0; k < motion.samples(); ++k) {
    dynamics.torque(q.col(k), qd.col(k), qdd.col(k), out.col(k));
  }
  return out.transpose();
}

inline Arm identified(std::string name, Robot robot, std::uint64_t seed) {
  Arm out{std::move(name), std::move(robot), {}, {}, {}};
  out.chi_st = out.robot.chi_st();
  out.torque_noise = noise_of(out.robot.size());
  std::mt19937_64 random(seed);
  Log log;
  log.source = out.name;
  log.f_m = f_m;
  log.t = test::ticks(identified_seconds, f_m);
  const Motion motion = test::Wandering(out.robot.size(), seed + 1000, 0.6, 1.0).at(log.t);
  log.q = noisy(motion.q, Vector::Constant(out.robot.size(), encoder_noise), random);
  log.tau = noisy(torques_of(out.robot, out.chi_st, motion), out.torque_noise, random);
  Estimation estimation;
  estimation.method = Wls{};
  estimation.signal.decimation = {25};
  estimation.signal.torque_held = false;
  out.model = online_model(out.robot, identify(out.robot, log, estimation));
  return out;
}

// only  the name of one; empty: all
inline std::vector<Arm> arms(const std::string& data, const std::string& only = "") {
  Robot tx = tx40();
  Robot seven = panda();
  Robot six = read_urdf(data + "/six_axis/six_axis.urdf");
  give_bodies(tx, 1);
  give_bodies(seven, 2);
  give_bodies(six, 3);
  std::vector<Arm> out;
  const auto add = [&](const std::string& name, Robot& robot, std::uint64_t seed) {
    if (only.empty() || only == name) {
      out.push_back(identified(name, std::move(robot), seed));
    }
  };
  add("six_axis", six, 13);
  add("tx40", tx, 11);
  add("panda", seven, 12);
  return out;
}

/// Deviation of friction coefficients from the identified ones, as a part of these.
inline constexpr double friction_error = 0.2;

// The truth with friction that has changed since: every coefficient by a normal part of itself.
inline Vector with_friction_error(const Robot& robot, Vector chi_st, double part, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const std::vector<StandardParameter> all = robot.standard_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (role(all[i].kind) == Role::dry || role(all[i].kind) == Role::viscous) {
      chi_st[static_cast<Index>(i)] *= std::max(1.0 + part * normal(random), 0.2);
    }
  }
  return chi_st;
}

// A compact body of 0.5 to 10 kg, up to 15 cm from the flange.
inline Inertial random_payload(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double mass = 0.5 * std::pow(20.0, unit(random));
  const Eigen::Vector3d com(0.2 * unit(random) - 0.1, 0.2 * unit(random) - 0.1, 0.15 * unit(random));
  const double a = 0.03 + 0.07 * unit(random);
  const double b = 0.03 + 0.07 * unit(random);
  const double c = 0.03 + 0.07 * unit(random);
  const Eigen::Vector3d moments(b * b + c * c, a * a + c * c, a * a + b * b);
  return inertial_from_com(mass, com, Eigen::Matrix3d((mass / 3.0 * moments).asDiagonal()));
}

// An arm in motion picks up a body.
struct PickUp {
  static constexpr double before = 15.0;  // s
  static constexpr double after = 10.0;

  Inertial body;  // frame of the last link
  Motion motion;
  Matrix empty, loaded;  // torques with and without it, (n_m × n)
  Matrix q, tau;         // measured, (n × n_m)
  Index change = static_cast<Index>(before * f_m);

  PickUp(const Arm& arm, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const Vector chi_st = with_friction_error(arm.robot, arm.chi_st, friction_error, random);
    body = random_payload(random);
    motion = test::Wandering(arm.robot.size(), seed + 5000, 0.6, 0.9).at(test::ticks(before + after, f_m));
    empty = torques_of(arm.robot, chi_st, motion);
    loaded = torques_of(arm.robot, test::loaded(arm.robot, chi_st, body), motion);
    tau = empty;
    tau.bottomRows(tau.rows() - change) = loaded.bottomRows(tau.rows() - change);
    tau = noisy(tau, arm.torque_noise, random).transpose().eval();
    q = noisy(motion.q, Vector::Constant(arm.robot.size(), encoder_noise), random).transpose();
  }
};

}  // namespace rivid::benchmarks
