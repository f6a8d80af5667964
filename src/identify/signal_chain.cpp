#include "rivid/identify/signal_chain.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rivid/error.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/differentiate.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/signal/zero_phase.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Two central differences in a row reach over two samples at each border.
constexpr Index difference_border = 2;
// Higher Butterworth orders ring at their cut-off and are of no use here.
constexpr int highest_order = 20;
// Filters run over at least so many samples.
constexpr Index shortest_series = 25;

void require_joints(const char* what, const Matrix& x, const Robot& robot, const Log& log) {
  if (x.cols() != robot.size() || x.rows() != log.q.rows()) {
    throw InputError(log.source + ": " + what + " has " + std::to_string(x.cols()) + " columns of " +
                     std::to_string(x.rows()) + " samples, must have one for each of the " +
                     std::to_string(robot.size()) + " joints of robot \"" + robot.name + "\" and " +
                     std::to_string(log.q.rows()) + " samples");
  }
}

void require_cutoff(const char* key, double cutoff_hz, const Log& log) {
  if (cutoff_hz >= 0.5 * log.f_m) {
    throw InputError(log.source + ": " + key + " is " + number(cutoff_hz) +
                     " Hz, must lie below f_m / 2 = " + number(0.5 * log.f_m) + " Hz");
  }
}

void require_decimation(int n_d, Index samples, const Log& log) {
  if (n_d > 1 && samples < std::max<Index>(n_d, shortest_series)) {
    throw InputError(log.source + ": decimation by " + std::to_string(n_d) + " meets " +
                     counted(samples, "sample") + ", needs at least " +
                     std::to_string(std::max<Index>(n_d, shortest_series)));
  }
}

// Finite cells may overflow once they are multiplied.
void require_finite(const Rows& rows, const Robot& robot, const Log& log) {
  double total = 0.0;
  for (std::size_t j = 0; j < rows.Y.size(); ++j) {
    const double norm = rows.Y[j].squaredNorm();
    if (!rows.W.joints[j].W.allFinite() || !std::isfinite(norm)) {
      throw InputError(log.source + ": joint \"" + robot.joints[j].name +
                       "\": positions or torques are so large that they overflow; check columns and units");
    }
    total += norm;
  }
  if (total == 0.0) {
    throw InputError(log.source + ": the torques are zero in every row; check the columns");
  }
}

struct Range {
  Index first = 0;
  Index count = 0;
};

// Samples that give rows: borders trimmed, inside the time window.
Range kept_range(const Log& log, const SignalOptions& options) {
  std::array<Index, 2> trim = {difference_border, difference_border};
  if (options.trim) {
    trim = *options.trim;
  } else if (options.cutoff_hz > 0.0) {
    const Index spoiled = settling_samples(butterworth(options.order, options.cutoff_hz, log.f_m));
    trim = {trim[0] + spoiled, trim[1] + spoiled};
  }
  Index first = trim[0];
  Index last = log.q.rows() - trim[1];
  if (options.window) {
    const double* begin = log.t.data();
    const double* end = begin + log.t.size();
    first = std::max(first, static_cast<Index>(std::lower_bound(begin, end, (*options.window)[0]) - begin));
    last = std::min(last, static_cast<Index>(std::upper_bound(begin, end, (*options.window)[1]) - begin));
  }
  if (last <= first) {
    std::string message = log.source + ": no row is left of " + std::to_string(log.q.rows()) +
                          " samples after trimming " + std::to_string(trim[0]) + " at the beginning and " +
                          std::to_string(trim[1]) + " at the end";
    if (options.window) {
      message += " and the time window " + number((*options.window)[0]) + " to " +
                 number((*options.window)[1]) + " s (the log spans " + number(log.t[0]) + " to " +
                 number(log.t[log.t.size() - 1]) + " s)";
    }
    throw InputError(message);
  }
  return {first, last - first};
}

std::vector<RowGroup> factored(const Observation& W, const std::vector<Vector>& Y) {
  std::vector<RowGroup> out;
  for (std::size_t j = 0; j < W.joints.size(); ++j) {
    const JointRows& joint = W.joints[j];
    out.push_back({joint.columns, StreamingQr(joint.W.cols())});
    out.back().qr.add(joint.W, Y[j]);
  }
  return out;
}

}  // namespace

std::optional<std::string> SignalOptions::complaint(Index n) const {
  if (!(cutoff_hz >= 0.0) || !std::isfinite(cutoff_hz)) {
    return "cutoff_hz is " + number(cutoff_hz) + ", must be positive, or 0 for no filter";
  }
  if (!(torque_cutoff_hz >= 0.0) || !std::isfinite(torque_cutoff_hz)) {
    return "torque_cutoff_hz is " + number(torque_cutoff_hz) + ", must be positive, or 0 for no filter";
  }
  for (const auto& [key, value] : {std::pair("order", order), std::pair("torque_order", torque_order)}) {
    if (value < 1 || value > highest_order) {
      return std::string(key) + " is " + std::to_string(value) + ", must lie between 1 and " +
             std::to_string(highest_order);
    }
  }
  for (const int n_d : decimation) {
    if (n_d < 1) {
      return "decimation is " + std::to_string(n_d) + ", must be at least 1";
    }
  }
  if (trim && ((*trim)[0] < 0 || (*trim)[1] < 0)) {
    return "trim is [" + std::to_string((*trim)[0]) + ", " + std::to_string((*trim)[1]) +
           "], must not be negative";
  }
  if (window && !((*window)[0] < (*window)[1])) {
    return "window is [" + number((*window)[0]) + ", " + number((*window)[1]) + "], must be [begin, end]";
  }
  if (!velocity_threshold.empty() && static_cast<Index>(velocity_threshold.size()) != n) {
    return "velocity_threshold has " + std::to_string(velocity_threshold.size()) +
           " entries, must have one for each of the " + std::to_string(n) + " joints";
  }
  for (const double v : velocity_threshold) {
    if (!(v >= 0.0) || !std::isfinite(v)) {
      return "velocity_threshold is " + number(v) + ", must not be negative";
    }
  }
  return std::nullopt;
}

Log joint_side(const Robot& robot, Log log) {
  if (const auto complaint = robot.complaint()) {
    throw InputError("joint_side: " + *complaint);
  }
  // One row a sample: everything is multiplied from the right.
  const Matrix R = robot.gears();
  const Matrix from_motor = R.inverse().transpose();
  const auto turn = [&](const char* what, Matrix& x, const Matrix& by) {
    if (x.size() == 0) {
      return;
    }
    if (x.cols() != robot.size()) {
      throw InputError(log.source + ": " + what + " has " + std::to_string(x.cols()) +
                       " columns, must have one for each of the " + std::to_string(robot.size()) +
                       " motors of robot \"" + robot.name + "\"");
    }
    x = x * by;
  };
  turn("position", log.q, from_motor);
  turn("velocity", log.qd, from_motor);
  turn("reference", log.q_r, from_motor);
  turn("reference velocity", log.qd_r, from_motor);
  turn("torque", log.tau, R);
  return log;
}

Matrix effort(const Robot& robot, const Log& log) {
  if (log.tau.size() > 0) {
    require_joints("torque", log.tau, robot, log);
    return log.tau;
  }
  if (log.v_tau.size() == 0) {
    throw InputError(log.source + ": neither torque nor control signal; name the columns of one of them");
  }
  require_joints("control signal", log.v_tau, robot, log);
  return log.v_tau * robot.drive_matrix().transpose();
}

Observation decimate(Observation W, int n_d, Convention convention) {
  for (JointRows& joint : W.joints) {
    joint.W = decimate(joint.W, n_d, convention);
  }
  return W;
}

Rows rows(const Robot& robot, const BaseParameters& base, const Log& log, const SignalOptions& options) {
  if (const auto complaint = options.complaint(robot.size())) {
    throw InputError("rows: " + *complaint);
  }
  require_joints("position", log.q, robot, log);
  if (const auto complaint = log.complaint()) {
    throw InputError("rows: " + *complaint);
  }
  require_cutoff("cutoff_hz", options.cutoff_hz, log);
  require_cutoff("torque_cutoff_hz", options.torque_cutoff_hz, log);
  const Range range = kept_range(log, options);

  const auto filtered = [&](const Matrix& x, double cutoff_hz, int order) {
    return cutoff_hz > 0.0 ? zero_phase(x, butterworth(order, cutoff_hz, log.f_m), options.convention) : x;
  };
  const Motion whole = differentiate(filtered(log.q, options.cutoff_hz, options.order), log.f_m);
  const auto cut = [&](const Matrix& x) { return x.middleRows(range.first, range.count); };
  const Motion motion{cut(whole.q), cut(whole.qd), cut(whole.qdd)};
  Matrix Y = cut(filtered(effort(robot, log), options.torque_cutoff_hz, options.torque_order));

  Rows out;
  out.W = observation(robot, base, motion);
  if (options.convention == Convention::matlab && !options.decimation.empty()) {
    const std::vector<Vector> columns(Y.colwise().begin(), Y.colwise().end());
    out.undecimated = factored(out.W, columns);
  }
  for (const int n_d : options.decimation) {
    require_decimation(n_d, Y.rows(), log);
    Y = decimate(Y, n_d, options.convention);
    out.W = decimate(std::move(out.W), n_d, options.convention);
  }
  const std::vector<Index> survivors = kept_samples(range.count, options.decimation, options.convention);

  for (std::size_t j = 0; j < out.W.joints.size(); ++j) {
    const double threshold = options.velocity_threshold.empty() ? 0.0 : options.velocity_threshold[j];
    const auto column = static_cast<Index>(j);
    std::vector<Index> fast;
    std::vector<Index> samples;
    for (std::size_t k = 0; k < survivors.size(); ++k) {
      if (std::abs(motion.qd(survivors[k], column)) >= threshold) {
        fast.push_back(static_cast<Index>(k));
        samples.push_back(range.first + survivors[k]);
      }
    }
    out.left_out.push_back(static_cast<Index>(survivors.size() - fast.size()));
    if (fast.empty()) {
      throw InputError(log.source + ": joint \"" + robot.joints[j].name +
                       "\" never moves faster than velocity_threshold " + number(threshold) +
                       "; no row is left");
    }
    out.Y.emplace_back(Y.col(column)(fast));
    if (out.left_out.back() > 0) {
      out.W.joints[j].W = Matrix(out.W.joints[j].W(fast, Eigen::all));
    }
    out.samples.push_back(std::move(samples));
  }
  require_finite(out, robot, log);
  return out;
}

std::vector<RowGroup> factors(const Rows& rows) { return factored(rows.W, rows.Y); }

}  // namespace rivid
