#include "rivid/identify/rows.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>

#include "accept.hpp"
#include "dense.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/row_source.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Higher Butterworth orders ring at their cut-off and are of no use here.
constexpr int highest_order = 20;

std::vector<RowGroup> groups_of(const detail::RowSource& source) {
  std::vector<RowGroup> out;
  out.reserve(source.joints());
  for (std::size_t j = 0; j < source.joints(); ++j) {
    const std::vector<Index>& own = source.columns(j);
    out.push_back({own, StreamingQr(static_cast<Index>(own.size()))});
  }
  return out;
}

// Threads that meet for every piece wait for each other at each of them, and on a busy machine for the
// processor as well. So each takes a stretch, then another one; their factors are merged in the order of the
// stretches, whoever had them, as soon as it is their turn.
std::vector<RowGroup> factored_in_stretches(const detail::RowSource& source, detail::ThreadTeam& team,
                                            const std::function<void(double)>& progress) {
  const Index stretches = source.stretches();
  std::vector<RowGroup> out = groups_of(source);
  std::mutex merging;
  std::map<Index, std::vector<RowGroup>> early;
  Index merged = 0;
  const auto hand_in = [&](Index stretch, std::vector<RowGroup> part) {
    const std::scoped_lock lock(merging);
    early.emplace(stretch, std::move(part));
    for (auto at = early.begin(); at != early.end() && at->first == merged; at = early.erase(at), ++merged) {
      for (std::size_t j = 0; j < out.size(); ++j) {
        out[j].qr.merge(at->second[j].qr);
      }
    }
  };
  std::atomic<Index> next = 0;
  std::atomic<Index> sent = 0;
  team.run([&](int member) {
    const auto tell = [&](Index samples) {
      const Index so_far = sent += samples;
      if (progress && member == 0) {
        progress(static_cast<double>(so_far) / static_cast<double>(source.samples()));
      }
    };
    for (Index s = next++; s < stretches; s = next++) {
      std::vector<RowGroup> part = groups_of(source);
      source.send_stretch(s, detail::factor_sinks(part).sinks(), tell);
      for (const RowGroup& group : part) {
        static_cast<void>(group.qr.R());  // gives back the memory of rows that wait
      }
      hand_in(s, std::move(part));
    }
  });
  if (progress) {
    progress(1.0);
  }
  return out;
}

// Sums of squares of a joint's rows, from which follows whether they can be used.
struct Seen {
  Index rows = 0;
  bool finite = true;
  double y_norm = 0.0;
};

// Velocity below which rows of each joint are left out, (n).
std::vector<double> thresholds_of(const detail::RowSource& source, const SignalOptions& options) {
  if (source.masks().empty()) {
    return options.velocity_threshold.empty() ? std::vector<double>(source.joints(), 0.0)
                                              : options.velocity_threshold;
  }
  return detail::made_of(source.masks(), &detail::MotionMask::threshold);
}

// A position that is nowhere near the others, as a corrupt line leaves it, for a message; empty where there
// is none.
std::string stray_position(const Robot& robot, const Log& log) {
  // times the size that 90 % of the samples keep; a choice: no motion does it, shifted digits do
  constexpr double far = 1e3;
  constexpr double least = 1e-3;  // [rad | m] stands for the size of a joint at rest; a choice
  for (Index j = 0; j < log.q.cols(); ++j) {
    Vector sizes = log.q.col(j).cwiseAbs();
    Index at = 0;
    const double most = sizes.maxCoeff(&at);
    const auto tenth = sizes.end() - 1 - sizes.size() / 10;
    std::nth_element(sizes.begin(), tenth, sizes.end());
    if (most > far * std::max(*tenth, least)) {
      return "; " + log.place(at) + " has joint \"" + robot.joints[static_cast<std::size_t>(j)].name +
             "\" at " + number(log.q(at, j)) + ", far from all others: repair or cut the log";
    }
  }
  return {};
}

void require_usable(const std::vector<Seen>& joints, const std::vector<double>& thresholds,
                    const Robot& robot, const Log& log, const SignalOptions& options) {
  double total = 0.0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string joint = log.source + ": joint \"" + robot.joints[j].name + "\"";
    if (joints[j].rows == 0 && !options.exact_rows()) {
      throw InputError(joint + " never moves faster than velocity_threshold " + number(thresholds[j]) +
                       "; no row is left");
    }
    // Finite cells may overflow once they are multiplied.
    if (!joints[j].finite) {
      throw InputError(joint +
                       ": positions or torques are so large that they overflow; check columns and units" +
                       stray_position(robot, log));
    }
    total += joints[j].y_norm;
  }
  // Joints that stand still have no exact rows, nor have those without torque; the others may have.
  if (std::ranges::all_of(joints, [](const Seen& joint) { return joint.rows == 0; }) &&
      !effort(robot, log).isZero(0.0)) {
    throw InputError(
        log.source +
        ": no joint moves for long enough in one direction, fast enough to stand out of the noise "
        "of its positions; no row is left (rows = \"paper\" keeps all, a lower cutoff_hz lets less "
        "noise through)" +
        stray_position(robot, log));
  }
  if (total == 0.0 && robot.base_joints > 0) {
    throw InputError(log.source +
                     ": all torques are zero; the motion of a floating base alone gives its inertias but for "
                     "one scale: log torques of joints or wrenches of contacts");
  }
  if (total == 0.0) {
    throw InputError(
        log.source +
        ": the torques are zero in every row; check the columns. A log without torque needs the "
        "law and gains of its controller in [control] and a [log] reference instead (docs/control.md)");
  }
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
  if (rows == RowScheme::exact && convention == Convention::matlab) {
    return "rows is \"exact\", which has no convention \"matlab\"; that one goes with rows = \"paper\"";
  }
  return std::nullopt;
}

Log joint_side(const Robot& robot, Log log) {
  detail::accept("joint_side", robot.complaint());
  // One row a sample: everything is multiplied from the right.
  const Matrix R = robot.gears();
  const Matrix from_motor = detail::inverse(R).transpose();
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
    detail::require_joints("torque", log.tau, robot, log);
    return log.tau;
  }
  if (log.v_tau.size() == 0) {
    throw InputError(log.source + ": neither torque nor control signal; name the columns of one of them");
  }
  detail::require_joints("control signal", log.v_tau, robot, log);
  return log.v_tau * robot.drive_matrix().transpose();
}

Observation decimate(Observation W, int n_d, Convention convention) {
  for (JointRows& joint : W.joints) {
    joint.W = decimate(joint.W, n_d, convention);
  }
  return W;
}

Rows rows(const Robot& robot, const BaseParameters& base, const Log& log, const SignalOptions& options) {
  detail::ThreadTeam alone(1);
  detail::RowSource source(robot, base, log, options, alone);
  detail::JointSinks<detail::HeldRows> held(source.joints(), [&](std::size_t j) {
    return detail::HeldRows(source.rows(), std::ssize(source.columns(j)) + 1);
  });
  source.send(held.sinks());

  Rows out;
  out.thresholds = thresholds_of(source, options);
  out.W.columns = base.size();
  std::vector<Seen> seen;
  for (std::size_t j = 0; j < source.joints(); ++j) {
    const auto own = static_cast<Index>(source.columns(j).size());
    out.W.joints.push_back({source.columns(j), held[j].rows().leftCols(own)});
    out.Y.emplace_back(held[j].rows().col(own));
    out.samples.push_back(std::move(held[j].samples()));
    out.left_out.push_back(source.rows() - out.Y[j].size());
    const double y_norm = out.Y[j].norm();
    seen.push_back({out.Y[j].size(), out.W.joints[j].W.allFinite() && std::isfinite(y_norm), y_norm});
    held[j] = detail::HeldRows(0, 0);
  }
  require_usable(seen, out.thresholds, robot, log, options);
  return out;
}

namespace {

// What is known of the rows beside their factors.
//
// throws InputError where they can not be used
RowFactors checked_factors(std::vector<RowGroup> groups, const detail::RowSource& source, const Robot& robot,
                           const Log& log, const SignalOptions& options) {
  RowFactors out;
  out.groups = std::move(groups);
  out.left_out =
      detail::made_of(out.groups, [&](const RowGroup& group) { return source.rows() - group.qr.rows(); });
  out.thresholds = thresholds_of(source, options);
  std::vector<Seen> seen;
  for (const RowGroup& group : out.groups) {
    const bool finite = group.qr.finite();
    seen.push_back({group.qr.rows(), finite, finite ? group.qr.y_norm() : 0.0});
  }
  require_usable(seen, out.thresholds, robot, log, options);
  return out;
}

// Sends the rows as they are made, one stretch of a long log beside others.
RowFactors made_factors(const Robot& robot, const BaseParameters& base, const Log& log,
                        const SignalOptions& options, detail::ThreadTeam& team,
                        const std::function<void(double)>& progress) {
  detail::RowSource source(robot, base, log, options, team);
  std::vector<RowGroup> groups;
  if (source.stretches() > 1) {
    groups = factored_in_stretches(source, team, progress);
  } else {
    groups = groups_of(source);
    source.send(detail::factor_sinks(groups).sinks(), {}, progress);
  }
  return checked_factors(std::move(groups), source, robot, log, options);
}

RowFactors kept_factors(const Robot& robot, const Log& log, const SignalOptions& options,
                        detail::KeptRows& kept, const std::function<void(double)>& progress) {
  std::vector<RowGroup> groups = groups_of(kept.source());
  kept.send(detail::factor_sinks(groups).sinks(), {}, progress);
  return checked_factors(std::move(groups), kept.source(), robot, log, options);
}

// kept  that the rows come by way of, or nullptr
RowFactors log_factors(const Robot& robot, const BaseParameters& base, const Log& log,
                       const SignalOptions& options, detail::ThreadTeam& team,
                       const std::function<void(double)>& progress, detail::KeptRows* kept) {
  RowFactors out = kept == nullptr ? made_factors(robot, base, log, options, team, progress)
                                   : kept_factors(robot, log, options, *kept, progress);
  if (options.convention == Convention::matlab && !options.decimation.empty()) {
    SignalOptions plain = options;
    plain.decimation.clear();
    plain.velocity_threshold.clear();
    out.undecimated = made_factors(robot, base, log, plain, team, {}).groups;
  }
  return out;
}

}  // namespace

RowFactors factors(const Robot& robot, const BaseParameters& base, const Log& log,
                   const SignalOptions& options, int threads, const std::function<void(double)>& progress) {
  if (threads < 1) {
    throw InputError("factors: threads is " + std::to_string(threads) + ", must be at least 1");
  }
  detail::ThreadTeam team(threads);
  return log_factors(robot, base, log, options, team, progress, nullptr);
}

namespace detail {

void add_factors(RowFactors& into, RowFactors part) {
  merge_groups(into.groups, std::move(part.groups));
  merge_groups(into.undecimated, std::move(part.undecimated));
  into.left_out.resize(part.left_out.size(), 0);
  into.thresholds.resize(part.thresholds.size(), 0.0);
  for (std::size_t j = 0; j < part.left_out.size(); ++j) {
    into.left_out[j] += part.left_out[j];
    into.thresholds[j] = std::max(into.thresholds[j], part.thresholds[j]);
  }
}

JointSinks<FactorSink> factor_sinks(std::span<RowGroup> groups) {
  return {groups.size(), [&](std::size_t j) { return FactorSink(groups[j].qr); }};
}

std::vector<RowGroup> empty_groups(std::span<const RowGroup> like) {
  return made_of(like, [&](const RowGroup& group) {
    return RowGroup{group.columns, StreamingQr(static_cast<Index>(group.columns.size()))};
  });
}

Index rows_of(std::span<const RowGroup> groups) {
  return sum_of(groups, [&](const RowGroup& group) { return group.qr.rows(); });
}

RowFactors all_factors(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                       std::span<const SignalOptions> signals, ThreadTeam& team, const Progress& progress,
                       std::vector<std::unique_ptr<KeptRows>>* kept) {
  RowFactors out;
  std::size_t left = KeptRows::budget;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    std::unique_ptr<KeptRows> rows;
    if (kept != nullptr && KeptRows::worthwhile(signals[k])) {
      rows = std::make_unique<KeptRows>(robot, base, logs[k], signals[k], team);
      if (rows->bytes() > left) {
        rows.reset();
      }
    }
    left -= rows ? rows->bytes() : 0;
    const auto tell = [&](double fraction) {
      progress(logs[k].source, (static_cast<double>(k) + fraction) / static_cast<double>(logs.size()));
    };
    add_factors(out, log_factors(robot, base, logs[k], signals[k], team,
                                 progress ? std::function<void(double)>(tell) : std::function<void(double)>(),
                                 rows.get()));
    if (kept != nullptr) {
      kept->push_back(std::move(rows));
    }
  }
  return out;
}

}  // namespace detail

}  // namespace rivid
