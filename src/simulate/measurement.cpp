#include "rivid/simulate/measurement.hpp"

#include <cmath>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Streams of one seed; the numbers are part of what a seed means.
enum Purpose : std::uint64_t { position_noise = 0, disturbance_torque = 1, torque_noise = 2 };

// More is a mistake of units, and would not fit into the memory.
constexpr double most_periods = 1e8;

std::optional<std::string> wrong_deviation(const char* what, const Vector& sigma, Index n) {
  if (sigma.size() != 0 && sigma.size() != n) {
    return std::string(what) + " has " + counted(sigma.size(), "entry") + ", must have one for each of " +
           counted(n, "joint");
  }
  for (Index j = 0; j < sigma.size(); ++j) {
    if (!std::isfinite(sigma[j]) || sigma[j] < 0.0) {
      return std::string(what) + " of joint " + std::to_string(j + 1) + " is " + number(sigma[j]) +
             ", a standard deviation must be zero or positive";
    }
  }
  return std::nullopt;
}

bool any(const Vector& values) { return values.size() > 0 && values.cwiseAbs().maxCoeff() > 0.0; }

void round_to(const Vector& quantum, Matrix& q) {
  for (Index j = 0; j < quantum.size(); ++j) {
    if (quantum[j] > 0.0) {
      q.col(j) = quantum[j] * (q.col(j) / quantum[j]).array().round();
    }
  }
}

// Rows before the first one that is not finite.
Index finite_rows(const Log& log) {
  for (Index k = 0; k < log.samples(); ++k) {
    for (const Matrix* const m : {&log.q, &log.tau, &log.v_tau, &log.q_r, &log.qd_r}) {
      if (!m->row(k).allFinite()) {
        return k;
      }
    }
  }
  return log.samples();
}

}  // namespace

std::optional<std::string> NoiseOptions::complaint(Index n) const {
  for (const auto& fault :
       {wrong_deviation("position_noise", position, n), wrong_deviation("torque_noise", torque, n),
        wrong_deviation("disturbance", disturbance, n)}) {
    if (fault) {
      return fault;
    }
  }
  return std::nullopt;
}

SimulationOptions with_noise(SimulationOptions options, const NoiseOptions& noise, Index n) {
  if (const auto fault = noise.complaint(n)) {
    throw InputError("with_noise: " + *fault);
  }
  Sampling& sampling = options.sampling;
  const bool sampled = sampling.period > 0.0;
  const double period = sampled ? sampling.period : 1.0 / options.f_m;
  const auto drawn = [&](Purpose purpose, const Vector& sigma) {
    const double periods = std::ceil(static_cast<double>(options.samples) / (options.f_m * period)) + 1.0;
    if (!(periods <= most_periods)) {
      throw InputError("with_noise: the motion has " + number(periods) + " control periods of " +
                       number(period) + " s; noise is drawn for " + number(most_periods) + " at most");
    }
    return white_noise(noise.seed, purpose, static_cast<Index>(periods), sigma);
  };
  if (!noise.feedback) {
    sampling.quantum = {};
  } else if (any(noise.position) || any(sampling.quantum)) {
    if (!sampled) {
      throw InputError(
          "with_noise: errors of the measurement go through a sampled law only; sample it, or switch the "
          "feedback off and they are in the log alone");
    }
    constexpr double clock_error = 1e-9;
    const double ratio = 1.0 / (sampling.period * options.f_m);
    if (std::abs(ratio - std::round(ratio)) > clock_error * ratio) {
      throw InputError("with_noise: the controller measures at " + number(1.0 / sampling.period) +
                       " Hz and the log is taken at " + number(options.f_m) +
                       " Hz; the first must be a multiple of the second, so that every row is measured");
    }
    if (any(noise.position)) {
      sampling.position_noise = drawn(position_noise, noise.position);
    }
  }
  if (any(noise.disturbance)) {
    options.disturbance = drawn(disturbance_torque, noise.disturbance);
  }
  return options;
}

Log measured_log(const Simulation& simulation, const SimulationOptions& options, const NoiseOptions& noise) {
  Log out;
  out.t = simulation.t;
  out.f_m = options.f_m;
  out.q = simulation.q_measured;
  out.tau = simulation.tau;
  out.v_tau = simulation.v_tau;
  out.q_r = simulation.q_r;
  out.qd_r = simulation.qd_r;
  const Index rows = out.samples();
  if (!noise.feedback) {
    out.q = simulation.motion.q;
    if (any(noise.position)) {
      out.q += white_noise(noise.seed, position_noise, rows, noise.position);
    }
    round_to(options.sampling.quantum, out.q);
  }
  if (any(noise.torque)) {
    out.tau += white_noise(noise.seed, torque_noise, rows, noise.torque);
  }
  const Index kept = finite_rows(out);
  out.t.conservativeResize(kept);
  for (Matrix* m : {&out.q, &out.tau, &out.v_tau, &out.q_r, &out.qd_r}) {
    m->conservativeResize(kept, Eigen::NoChange);
  }
  return out;
}

}  // namespace rivid
