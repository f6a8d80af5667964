#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../robots.hpp"
#include "bodies.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_stream.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/online.hpp"

// An arm outside the library's models, for long shifts: links by inverse dynamics, and friction that no law
// of rivid has, with ripple, Stribeck, stiction that is anything at rest, load and drift; quantised encoders.
// Eigen alone is linked.
namespace rivid::benchmarks {

struct PlantFriction {
  Vector Fc, Fv;
  double load = 0.03;      // part of |M q̈ + N|
  double stribeck = 0.15;  // of Fc, more at rest …
  double speed = 0.05;     // … fading with this speed [rad/s]
  double ripple = 0.02;    // of Fc, 20 waves a turn
  double stiction = 1.0;   // of Fc, uniform at rest
  bool holds = false;  // at rest friction takes what pushes a joint, as far as it can, before the drive does
};

class Plant {
 public:
  Robot robot;    // friction laws are those that the model will have
  Vector chi_st;  // links alone
  PlantFriction friction;
  Vector torque_noise;
  double encoder_bits = 20.0;
  double encoder_noise = 2e-6;

  Plant(Robot arm, std::uint64_t seed) : robot(std::move(arm)) {
    give_bodies(robot, seed);
    const Index n = robot.size();
    friction.Fc = friction.Fv = Vector::Zero(n);
    for (Index j = 0; j < n; ++j) {
      Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      friction.Fv[j] = std::exchange(joint.Fv, 0.0);
      friction.Fc[j] = std::exchange(joint.Fc, 0.0);
      joint.friction = Friction::none;
      joint.rotor_inertia = true;
    }
    chi_st = robot.chi_st();
    torque_noise = Vector::LinSpaced(n, 1.5, 0.3);
  }

  // The arm as its identification describes it.
  [[nodiscard]] Robot described(Friction law) const {
    Robot out = robot;
    for (Joint& joint : out.joints) {
      joint.friction = law;
    }
    return out;
  }
};

// Its torques, tick by tick.
class PlantTorques {
 public:
  Vector external;  // torques of what pushes the arm

  PlantTorques(const Plant& plant, const Inertial& body, std::uint64_t seed)
      : external(Vector::Zero(plant.robot.size())),
        plant_(plant),
        random_(seed),
        stops_(seed + 1000),
        held_(Vector::Zero(plant.robot.size())),
        drive_(held_),
        resting_(plant.robot.joints.size(), false) {
    set_body(body);
  }
  void set_body(const Inertial& body) {
    dynamics_.emplace_back(DynamicModel(plant_.robot, test::loaded(plant_.robot, plant_.chi_st, body)));
    if (dynamics_.size() > 1) {
      dynamics_.erase(dynamics_.begin());
    }
  }
  // warm  factor of dry and viscous friction
  Vector operator()(const Vector& q, const Vector& qd, const Vector& qdd, double warm) {
    Vector tau(q.size());
    dynamics_.back().rigid_body(q, qd, qdd, tau);
    tau -= external;
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    const PlantFriction& f = plant_.friction;
    for (Index j = 0; j < q.size(); ++j) {
      const auto at = static_cast<std::size_t>(j);
      const double v = qd[j];
      const double u = tau[j] + external[j];
      if (std::abs(v) < 1e-4) {
        if (!resting_[at]) {
          resting_[at] = true;
          held_[j] = f.stiction * f.Fc[j] * symmetric(stops_);
        } else if (f.holds) {
          const double most = f.stiction * f.Fc[j];
          held_[j] = std::clamp((drive_[j] - tau[j]) / warm, -most, most);
        }
        tau[j] += warm * held_[j];
        drive_[j] = tau[j];
        continue;
      }
      resting_[at] = false;
      const double s = v > 0.0 ? 1.0 : -1.0;
      const double dry = f.Fc[j] * (1.0 + f.stribeck * std::exp(-v * v / (f.speed * f.speed)) +
                                    f.ripple * std::sin(20.0 * q[j]));
      tau[j] += warm * (s * dry + f.Fv[j] * v) + f.load * s * std::abs(u);
    }
    return tau;
  }
  Vector measured(const Vector& tau) {
    Vector out = tau;
    for (Index j = 0; j < tau.size(); ++j) {
      out[j] += plant_.torque_noise[j] * normal_(random_);
    }
    return out;
  }
  Vector encoder(const Vector& q) {
    Vector out = q;
    const double quantum = 2.0 * std::numbers::pi / std::exp2(plant_.encoder_bits);
    for (Index j = 0; j < q.size(); ++j) {
      out[j] = quantum * std::round((q[j] + plant_.encoder_noise * normal_(random_)) / quantum);
    }
    return out;
  }
  std::mt19937_64& random() { return random_; }

 private:
  const Plant& plant_;
  std::mt19937_64 random_, stops_;
  std::normal_distribution<double> normal_;
  std::vector<InverseDynamics> dynamics_;
  Vector held_;
  Vector drive_;  // torque of the drive at rest
  std::vector<bool> resting_;
};

// Moves from point to point with rests, minimum jerk; some joints may stay where they are.
class PickAndPlace {
 public:
  PickAndPlace(Index n, std::uint64_t seed)
      : still(static_cast<std::size_t>(n), false), random_(seed), from_(Vector::Zero(n)), to_(from_) {}
  std::vector<bool> still;
  double shortest_rest = 0.2;
  double longest_rest = 0.8;
  Vector q, qd, qdd;
  [[nodiscard]] bool moving() const { return moving_; }
  // Next tick; true where a rest begins.
  bool step(double dt) {
    t_ += dt;
    bool stopped = false;
    if (moving_ && t_ >= duration_) {
      moving_ = false;
      t_ = 0.0;
      from_ = to_;
      std::uniform_real_distribution<double> unit(0.0, 1.0);
      rest_ = shortest_rest + (longest_rest - shortest_rest) * unit(random_);
      stopped = true;
    } else if (!moving_ && t_ >= rest_) {
      begin();
    }
    const double x = moving_ ? t_ / duration_ : 0.0;
    const double s = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    const double sd = 30.0 * x * x * (1.0 - 2.0 * x + x * x) / duration_;
    const double sdd = (60.0 * x - 180.0 * x * x + 120.0 * x * x * x) / (duration_ * duration_);
    const Vector way = to_ - from_;
    q = from_ + s * way;
    qd = sd * way;
    qdd = sdd * way;
    return stopped;
  }

 private:
  void begin() {
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    for (Index j = 0; j < to_.size(); ++j) {
      if (!still[static_cast<std::size_t>(j)]) {
        to_[j] = 1.2 * symmetric(random_);
      }
    }
    moving_ = true;
    t_ = 0.0;
    duration_ = std::max(1.875 * (to_ - from_).cwiseAbs().maxCoeff() / 1.5, 0.4);  // at most 1.5 rad/s
  }

  std::mt19937_64 random_;
  Vector from_, to_;
  double t_ = 0.0;
  double duration_ = 1.0;
  double rest_ = 0.5;
  bool moving_ = false;
};

// What an identification of a log without a payload finds: weighted least squares of its rows, with the
// covariance of blocks of a second.
inline OnlineModel identified_plant(const Plant& plant, Friction law, std::uint64_t seed, double f_m,
                                    double seconds = 60.0) {
  OnlineModel out;
  out.robot = plant.described(law);
  const Index n = out.robot.size();
  out.base = base_parameters(out.robot);
  out.velocity_threshold = Vector::Constant(n, 0.02);
  const Index b = out.base.size();
  PlantTorques torques(plant, Inertial::Zero(), seed);
  const Motion motion = test::Wandering(n, seed + 77, 0.6, 0.8).at(test::ticks(seconds, f_m));
  RowStreamOptions rows;
  rows.f_m = f_m;
  rows.torque_held = false;
  rows.stride = static_cast<Index>(0.1 * f_m);
  rows.velocity_threshold = out.velocity_threshold;
  Matrix q(n, motion.samples());
  Matrix tau(n, motion.samples());
  for (Index k = 0; k < motion.samples(); ++k) {
    tau.col(k) = torques.measured(torques(motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                          motion.qdd.row(k).transpose(), 1.0));
    q.col(k) = torques.encoder(motion.q.row(k).transpose());
  }
  out.sigma_rho = Vector::Constant(n, 1.0);
  std::vector<Index> load(static_cast<std::size_t>(n), -1);
  std::vector<bool> rigid;
  for (Index i = 0; i < b; ++i) {
    const StandardParameter& p = out.base.parameters[static_cast<std::size_t>(i)].leading;
    rigid.push_back(!is_friction(p.kind));
    if (about(p.kind).basis == Basis::load) {
      load[static_cast<std::size_t>(p.joint)] = i;
    }
  }
  out.chi = Vector::Zero(b);
  const Index per_block = static_cast<Index>(f_m);
  for (int pass = 0; pass < 3; ++pass) {
    RowStream<double> stream(out.robot, out.base.columns(), rows);
    Matrix A = 1e-9 * Matrix::Identity(b, b);  // the first pass knows no load
    Matrix meat = Matrix::Zero(b, b);
    Vector a = Vector::Zero(b);
    Vector score = Vector::Zero(b);
    Vector squares = Vector::Zero(n);
    Vector count = Vector::Zero(n);
    for (Index k = 0; k < q.cols(); ++k) {
      stream.update(q.col(k), tau.col(k));
      stream.for_each_row([&](const RowStream<double>::Row& row) {
        const auto j = static_cast<Index>(row.joint);
        const std::vector<Index>& own = stream.columns().of_joint(row.joint);
        Vector w = Vector::Zero(b);
        for (std::size_t c = 0; c < own.size(); ++c) {
          w[own[c]] = row.values[c];
        }
        if (const Index at = load[row.joint]; at >= 0) {
          double u = 0.0;
          for (Index i = 0; i < b; ++i) {
            u += rigid[static_cast<std::size_t>(i)] ? w[i] * out.chi[i] : 0.0;
          }
          w[at] *= std::abs(u);
        }
        w /= out.sigma_rho[j];
        const double e = row.y / out.sigma_rho[j] - w.dot(out.chi);
        A += w * w.transpose();
        a += w * row.y / out.sigma_rho[j];
        score += w * e;
        squares[j] += e * e * out.sigma_rho[j] * out.sigma_rho[j];
        count[j] += 1.0;
      });
      if (k % per_block == per_block - 1) {
        meat += score * score.transpose();
        score.setZero();
      }
    }
    const Matrix inverse = A.inverse();
    if (pass == 2) {  // of the chi of the pass before, with its weights
      out.C_chi = inverse * meat * inverse;
      out.C_chi += 0.1 * inverse;
    }
    out.chi = inverse * a;
    if (pass < 2) {
      if (pass == 1) {
        out.sigma_rho = squares.cwiseQuotient(count).cwiseSqrt();
      }
    }
  }
  return out;
}

}  // namespace rivid::benchmarks
