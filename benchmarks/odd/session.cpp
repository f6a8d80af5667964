#include "odd/session.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "odd/simulation.hpp"

namespace rivid::odd {

namespace {

constexpr double longest_step = 1e-3;
constexpr double longest_elastic_step = 2.5e-4;
constexpr double least_step = 0.05;  // between jittering instants, in periods
constexpr double far_away = 30.0;    // no joint goes there [rad | m]

double rounded(double x, double quantum) { return quantum > 0.0 ? quantum * std::round(x / quantum) : x; }

// The part of a control law that goes on from sample to sample.
class Loop {
 public:
  Loop(const Controller& controller, const Plant& plant, const RandomMotion& motion)
      : controller_(controller), plant_(plant), motion_(motion) {
    const Index n = plant.joints();
    integral_ = Numbers::Zero(n);
    rate_ = motion.at(0.0).qd;
    error_rate_ = Numbers::Zero(n);
  }

  // Takes the readings y of an instant at which the motors are at q.
  void sample(double t, const Numbers& y, const Numbers& q) {
    const Index n = plant_.joints();
    const ReferencePoint reference = motion_.at(t);
    if (y_.size() > 0 && t > t_) {
      const double dt = t - t_;
      const double share = 1.0 - std::exp(-dt * controller_.velocity_cutoff);
      rate_ += share * ((y - y_) / dt - rate_);
      error_rate_ += share * ((y - q - error_) / dt - error_rate_);
      integral_ += dt * (reference.q - y);
    }
    t_ = t;
    y_ = y;
    error_ = y - q;
    constant_ = controller_.k_i.cwiseProduct(integral_);
    constant_ += controller_.gravity_share *
                 plant_.dynamics(0.0).torques(reference.q, Numbers::Zero(n), Numbers::Zero(n));
    if (!controller_.continuous) {
      queue_.push_back(limited(constant_ + feedback(reference, y, rate_)));
      while (queue_.size() > static_cast<std::size_t>(controller_.delay) + 1) {
        queue_.pop_front();
      }
    }
  }

  [[nodiscard]] Numbers torque(double t, const Numbers& q, const Numbers& qd) const {
    if (!controller_.continuous) {
      return queue_.front();
    }
    return limited(constant_ + feedback(motion_.at(t), q + error_, qd + error_rate_));
  }

 private:
  [[nodiscard]] Numbers feedback(const ReferencePoint& reference, const Numbers& q, const Numbers& qd) const {
    return controller_.k_p.cwiseProduct(reference.q - q) + controller_.k_v.cwiseProduct(reference.qd - qd);
  }
  [[nodiscard]] Numbers limited(Numbers tau) const {
    return controller_.limit.size() > 0 ? tau.cwiseMin(controller_.limit).cwiseMax(-controller_.limit) : tau;
  }

  const Controller& controller_;
  const Plant& plant_;
  const RandomMotion& motion_;
  double t_ = 0.0;
  Numbers y_, error_, rate_, error_rate_, integral_, constant_;
  std::deque<Numbers> queue_;  // of torques, the front one is applied
};

// Torques that nobody records, AR(1) from sample to sample.
class Disturbance {
 public:
  Disturbance(const Recipe& recipe, const Numbers& rms)
      : memory_(recipe.disturbance_memory),
        size_(recipe.disturbance * rms),
        now_(Numbers::Zero(rms.size())) {}
  const Numbers& next(Random& random) {
    if (memory_ > 0.0) {
      for (Index j = 0; j < now_.size(); ++j) {
        now_[j] = memory_ * now_[j] + std::sqrt(1.0 - memory_ * memory_) * size_[j] * random.normal();
      }
    }
    return now_;
  }

 private:
  double memory_;
  Numbers size_, now_;
};

// What encoders and torque sensors make of the truth.
class Sensors {
 public:
  Sensors(const Recipe& recipe, const Load& load, Random& random)
      : recipe_(recipe), load_(load), random_(random) {}

  [[nodiscard]] Numbers positions(Numbers q) {
    for (double& value : q) {
      value += recipe_.eccentricity * std::sin(value + 1.0);
      value = rounded(value + recipe_.noise * random_.normal(), recipe_.quantum);
    }
    return q;
  }
  [[nodiscard]] Numbers torques(Numbers tau) {
    for (Index j = 0; j < tau.size(); ++j) {
      tau[j] = rounded(tau[j] + recipe_.torque_noise * load_.rms[j] * random_.normal(),
                       recipe_.torque_quantum * load_.largest[j]);
    }
    return tau;
  }

 private:
  const Recipe& recipe_;
  const Load& load_;
  Random& random_;
};

// A causal low-pass of first order.
void low_pass(Matrix& columns, double cutoff_hz, double rate_hz) {
  const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * cutoff_hz / rate_hz);
  for (Index k = 1; k < columns.rows(); ++k) {
    columns.row(k) = columns.row(k - 1) + share * (columns.row(k) - columns.row(k - 1));
  }
}

void keep_rows(const std::vector<Index>& rows, Recording& log) {
  log.q = Matrix(log.q(rows, Eigen::all));
  log.tau = Matrix(log.tau(rows, Eigen::all));
  log.q_r = Matrix(log.q_r(rows, Eigen::all));
  log.t = Vector(log.t(rows));
}

}  // namespace

Controller drawn_controller(const Recipe& recipe, const Machine& machine, const RandomMotion& motion,
                            Random& random) {
  const Load load = load_of(machine.arm, machine.Ia, motion);
  Controller out;
  const Index n = machine.size();
  out.continuous = recipe.continuous;
  out.delay = recipe.delay;
  out.k_p.resize(n);
  out.k_v.resize(n);
  out.k_i = Numbers::Zero(n);
  for (Index j = 0; j < n; ++j) {
    const double omega = recipe.omega_n * random.uniform(0.8, 1.25);
    const double zeta = random.uniform(0.7, 1.1);
    out.k_p[j] = load.inertia[j] * omega * omega;
    out.k_v[j] = 2.0 * zeta * load.inertia[j] * omega;
    out.k_i[j] = recipe.integral ? 0.1 * omega * out.k_p[j] : 0.0;
  }
  out.velocity_cutoff = random.uniform(8.0, 20.0) * recipe.omega_n;
  out.gravity_share = recipe.integral ? random.uniform(0.6, 1.0) : random.uniform(0.9, 1.05);
  if (recipe.saturation > 0.0) {
    out.limit.resize(n);
    for (Index j = 0; j < n; ++j) {
      const JointFriction& friction = machine.friction[static_cast<std::size_t>(j)];
      out.limit[j] = recipe.saturation * (load.largest[j] + friction.Fc_plus);
    }
  }
  return out;
}

Recording recorded(const Recipe& recipe, const Plant& plant, const Controller& controller,
                   const RandomMotion& motion, Random& random) {
  const Index n = plant.joints();
  const Load load = load_of(plant.machine().arm, plant.machine().Ia, motion);
  const double period = 1.0 / (recipe.rate_hz * recipe.control_every);
  const auto instants = static_cast<Index>(std::floor(recipe.duration / period)) + 1;
  const Index samples = (instants + recipe.control_every - 1) / recipe.control_every;
  Recording log{
      .t = Vector(samples), .q = Matrix(samples, n), .tau = Matrix(samples, n), .q_r = Matrix(samples, n)};

  Simulation simulation(plant, recipe.elastic_hz > 0.0 ? longest_elastic_step : longest_step);
  const ReferencePoint begin = motion.at(0.0);
  simulation.start(0.0, begin.q, begin.qd);
  Loop loop(controller, plant, motion);
  Disturbance disturbance(recipe, load.rms);
  Sensors sensors(recipe, load, random);
  const Simulation::Torque torque = [&](double t, const Numbers& q, const Numbers& qd) {
    return loop.torque(t, q, qd);
  };
  for (Index k = 0; k < instants; ++k) {
    const double nominal = period * static_cast<double>(k);
    if (k > 0) {
      const double late = recipe.jitter * period * std::clamp(random.normal(), -3.0, 3.0);
      const double next = std::max(nominal + late, simulation.time() + least_step * period);
      simulation.advance(next, torque, disturbance.next(random));
    }
    const double t = simulation.time();
    const Numbers q = simulation.positions();
    const Numbers qd = simulation.velocities();
    if (!q.allFinite() || q.cwiseAbs().maxCoeff() > far_away) {
      throw Diverged{};
    }
    const Numbers y = sensors.positions(q);
    const Numbers before = k > 0 && controller.continuous ? loop.torque(t, q, qd) : Numbers();
    loop.sample(t, y, q);
    Numbers tau = loop.torque(t, q, qd);
    if (before.size() > 0) {
      // The readings that a continuous law feeds back jump with each sample: its torque there is the mean of
      // both sides.
      tau = 0.5 * (before + tau);
    }
    if (k % recipe.control_every == 0) {
      const Index row = k / recipe.control_every;
      log.t[row] = recipe.stamped ? t : nominal;
      log.q.row(row) = (recipe.at_links ? sensors.positions(simulation.links()) : y).transpose();
      log.q_r.row(row) = motion.at(t).q.transpose();
      log.tau.row(row) = sensors.torques(tau).transpose();
    }
  }
  return log;
}

void spoil(const Recipe& recipe, Recording& log, Random& random) {
  const double rate_hz = recipe.rate_hz;
  if (recipe.gain_drift != 0.0) {
    log.tau.array().colwise() *= 1.0 + recipe.gain_drift * (log.t.array() / recipe.duration - 0.5);
  }
  if (recipe.misaligned != 0) {
    std::vector<Index> later(static_cast<std::size_t>(log.t.size()));
    for (Index k = 0; k < log.t.size(); ++k) {
      later[static_cast<std::size_t>(k)] = std::max<Index>(0, k - recipe.misaligned);
    }
    log.tau = Matrix(log.tau(later, Eigen::all));
  }
  if (recipe.torque_filter_hz > 0.0) {
    low_pass(log.tau, recipe.torque_filter_hz, rate_hz);
  }
  if (recipe.position_filter_hz > 0.0) {
    low_pass(log.q, recipe.position_filter_hz, rate_hz);
  }
  if (recipe.spikes > 0.0) {
    const Numbers size =
        (log.tau.colwise().norm() / std::sqrt(static_cast<double>(log.t.size()))).transpose();
    for (Index k = 0; k < log.t.size(); ++k) {
      for (Index j = 0; j < log.tau.cols(); ++j) {
        if (random.chance(recipe.spikes)) {
          log.tau(k, j) += random.sign() * random.uniform(2.0, 10.0) * size[j];
        }
      }
    }
  }
  if (recipe.dropped > 0.0) {
    std::vector<Index> kept = {0};
    for (Index k = 1; k < log.t.size(); ++k) {
      if (!random.chance(recipe.dropped)) {
        kept.push_back(k);
      }
    }
    const Vector before = log.t;
    keep_rows(kept, log);
    if (!recipe.stamped) {
      log.t = before.head(log.t.size());
    }
  }
  if (recipe.bursts > 0.0) {
    constexpr double longest = 0.04;  // [s]
    double late = 0.0;
    for (Index k = 1; k < log.t.size(); ++k) {
      late = random.chance(recipe.bursts) ? log.t[k] + random.uniform(0.1, 1.0) * longest : late;
      // What waits in the buffer is stamped with the moment at which it is read, one after the other.
      log.t[k] = std::max({log.t[k], log.t[k - 1] + 1e-6, std::min(late, log.t[k] + longest)});
    }
  }
  log.t *= recipe.clock;
}

}  // namespace rivid::odd
