#include "identify/rows/row_source.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <variant>

#include "accept.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"
#include "signal/window_decimator.hpp"

namespace rivid::detail {

namespace {

// Two central differences in a row reach over two samples at each border.
constexpr Index difference_border = 2;
// Filters run over at least so many samples.
constexpr Index shortest_series = 25;
// Samples that a decimation gets at a time for each thread of several: enough that waiting for each other
// costs little.
constexpr Index decimated_share = 320;
// Samples of a stretch at least: so many that the merging of their factors costs little.
constexpr Index least_stretch = 16384;
// Rows that a thread fills at a time begin at multiples of this one: whole cache lines and packs.
constexpr Index granule = 16;

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

// throws InputError where they are not of this robot
std::vector<StandardParameter> own_columns(const Robot& robot, const BaseParameters& base) {
  accept("rows", base.complaint(robot));
  return base.columns();
}

// First sample within the window, and the one after the last.
std::array<Index, 2> samples_within(const Vector& t, const std::array<double, 2>& window) {
  const double* const begin = t.data();
  const double* const end = begin + t.size();
  return {static_cast<Index>(std::lower_bound(begin, end, window[0]) - begin),
          static_cast<Index>(std::upper_bound(begin, end, window[1]) - begin)};
}

// Keeps the rows of a series that are listed, ascending.
void keep(const RowsRoom& room, Index columns, const std::vector<Index>& rows) {
  for (Index c = 0; c < columns; ++c) {
    double* const column = room.target.data + c * room.target.ld;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      column[k] = column[rows[k]];
    }
  }
}

}  // namespace

Index stride_of(const SignalOptions& signal) {
  return std::accumulate(signal.decimation.begin(), signal.decimation.end(), Index{1}, std::multiplies<>());
}

std::span<const Log> within_window(std::span<const Log> logs, const SignalOptions& signal,
                                   std::vector<Log>& room) {
  if (!signal.window) {
    return logs;
  }
  for (const Log& log : logs) {
    const auto [begin, end] = samples_within(log.t, *signal.window);
    room.push_back(end > begin ? excerpt(log, begin, end - begin) : log);
  }
  return room;
}

namespace {

void require_reach(const Robot& robot, const Log& log) {
  for (const Chain::Dependent& dependent : robot.chain.dependents) {
    for (const auto& [joint, least, most] : dependent.reach()) {
      for (Index k = 0; k < log.q.rows(); ++k) {
        if (const double q = log.q(k, joint); q < least || q > most) {
          throw InputError(log.place(k) + ": position of joint \"" +
                           robot.joints[static_cast<std::size_t>(joint)].name + "\" is " + number(q, 4) +
                           ", but the linkage or table of \"" + dependent.joint + "\" reaches from " +
                           number(least, 4) + " to " + number(most, 4));
        }
      }
    }
  }
}

}  // namespace

void require_joints(const char* what, const Matrix& x, const Robot& robot, const Log& log) {
  if (x.cols() != robot.size() || x.rows() != log.q.rows()) {
    throw InputError(log.source + ": " + what + " has " + std::to_string(x.cols()) + " columns of " +
                     std::to_string(x.rows()) + " samples, must have one for each of the " +
                     std::to_string(robot.size()) + " joints of robot \"" + robot.name + "\" and " +
                     std::to_string(log.q.rows()) + " samples");
  }
  if (&x == &log.q) {
    require_reach(robot, log);
  }
}

// A decimation of either kind.
class Stage {
 public:
  explicit Stage(StreamingDecimator by_filter) : kind_(std::move(by_filter)) {}
  explicit Stage(WindowDecimator by_window) : kind_(std::move(by_window)) {}

  [[nodiscard]] RowsRoom room() {
    return std::visit([](auto& d) { return d.room(); }, kind_);
  }
  void commit(Index samples) {
    std::visit([&](auto& d) { d.commit(samples); }, kind_);
  }
  void end() {
    if (auto* const by_filter = std::get_if<StreamingDecimator>(&kind_)) {
      by_filter->end();
    }
  }
  [[nodiscard]] Index finished() const {
    return std::visit([](const auto& d) { return d.finished(); }, kind_);
  }
  void take(Index count, const RowsTarget& to) {
    std::visit([&](auto& d) { d.take(count, to); }, kind_);
  }

 private:
  std::variant<StreamingDecimator, WindowDecimator> kind_;
};

// The rows of a joint on their way.
struct RowSource::StreamedJoint {
  RowSink* sink = nullptr;
  Index columns = 0;  // of [V … W Y]
  std::vector<Stage> stages;
  std::vector<Index>
      centres;           // samples that the rows of a window stand for, counted from the first of the stream
  RowsRoom room;         // of the piece that is being made
  Index delivered = 0;   // rows that came out of the last stage
  bool all_kept = true;  // no row is left out on delivery
  std::vector<Index> samples;  // of the rows that are being delivered
  std::vector<Index> kept;     // of these rows
};

struct RowSource::Stream {
  Parts parts;
  std::vector<StreamedJoint> joints;
  std::vector<BatchWorkspace> workspaces;  // one a thread
  Index first = 0;                         // sample of row 0 …
  Index stride = 1;                        // … and from one row to the next
};

RowSource::Range RowSource::kept_range(const Log& log, const SignalOptions& options) {
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
    const auto [begin, end] = samples_within(log.t, *options.window);
    // As of a log that ends there, so that both have the same rows; filters have settled before a window.
    const Index border = options.cutoff_hz > 0.0 ? 0 : difference_border;
    first = std::max(first, begin + border);
    last = std::min(last, end - border);
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

RowSource::RowSource(const Robot& robot, const BaseParameters& base, const Log& log,
                     const SignalOptions& options, ThreadTeam& team)
    : log_(log),
      options_(options),
      team_(team),
      batch_(robot, own_columns(robot, base)),
      load_("rows", robot, base, batch_) {
  accept("rows", options.complaint(robot.size()));
  require_joints("position", log.q, robot, log);
  accept("rows", log.complaint());
  require_cutoff("cutoff_hz", options.cutoff_hz, log);
  require_cutoff("torque_cutoff_hz", options.torque_cutoff_hz, log);
  range_ = kept_range(log, options);
  rows_ = range_.count;
  for (const int n_d : options.decimation) {
    require_decimation(n_d, rows_, log);
    rows_ = (rows_ + n_d - 1) / n_d;
  }

  if (options.cutoff_hz > 0.0) {
    q_ = filtered(log.q, options.cutoff_hz, options.order);
  } else {
    q_ = log.q;
  }
  const bool exact = options.exact_rows();
  // The absolute value of a noisy torque is too large: unfiltered rows are averaged before.
  load_by_row_ = stride_of(options) > 1 && (exact || options.cutoff_hz == 0.0);
  if (log.tau.size() > 0 && options.torque_cutoff_hz == 0.0 && !options.held() && !exact) {
    require_joints("torque", log.tau, robot, log);
    tau_ = &log.tau;
  } else {
    made_tau_ = effort(robot, log);
    if (exact) {
      average_torque(made_tau_, options.held());
      if (options.cutoff_hz > 0.0) {
        made_tau_ = filtered(made_tau_, options.cutoff_hz, options.order);
      }
    } else if (options.held()) {
      // It is centred half a sample behind its own.
      made_tau_.bottomRows(made_tau_.rows() - 1) =
          (0.5 * (made_tau_.topRows(made_tau_.rows() - 1) + made_tau_.bottomRows(made_tau_.rows() - 1)))
              .eval();
    }
    if (options.torque_cutoff_hz > 0.0) {
      made_tau_ = filtered(made_tau_, options.torque_cutoff_hz, options.torque_order);
    }
    tau_ = &made_tau_;
  }
  if (exact) {
    masks_ = motion_masks(robot, log.q, q_, log.f_m, options);
    // A torque that never changes was not measured: the rows of the other joints are the data.
    for (Index j = robot.base_joints; j < tau_->cols(); ++j) {
      if ((tau_->col(j).array() == (*tau_)(0, j)).all()) {
        std::ranges::fill(masks_[static_cast<std::size_t>(j)].direction, std::int8_t{0});
      }
    }
    find_sign_columns(robot, base);
  } else if (robot.base_joints > 0 && tau_->rightCols(tau_->cols() - robot.base_joints).isZero(0.0)) {
    throw InputError(log.source + ": a floating base without torques needs exact rows ([signal] rows)");
  }
  find_known_mass(robot, base);
}

void RowSource::find_known_mass(const Robot& robot, const BaseParameters& base) {
  known_mass_.resize(joints(), -1);
  mass_ = robot.total_mass.value_or(0.0);
  for (std::size_t j = 0; j < joints(); ++j) {
    const auto at = std::ranges::find_if(columns(j), [&](Index c) {
      return robot.known_mass(base.parameters[static_cast<std::size_t>(c)].leading);
    });
    if (at != columns(j).end()) {
      known_mass_[j] = at - columns(j).begin();
    }
  }
}

void RowSource::find_sign_columns(const Robot& robot, const BaseParameters& base) {
  sign_columns_.resize(joints());
  const std::vector<StandardParameter> parameters = base.columns();
  for (std::size_t j = 0; j < joints(); ++j) {
    if (!masks_[j].smoothed || robot.joints[j].sign_speed > 0.0) {
      continue;
    }
    for (std::size_t c = 0; c < columns(j).size(); ++c) {
      const StandardParameter& parameter = parameters[static_cast<std::size_t>(columns(j)[c])];
      const KindRow& row = about(parameter.kind);
      if ((row.basis == Basis::sign || row.basis == Basis::load) && !row.coupled) {
        sign_columns_[j].push_back({static_cast<Index>(c), row.basis, row.direction});
      }
    }
  }
}

// Columns are filtered independently, so they may be shared out.
Matrix RowSource::filtered(const Matrix& x, double cutoff_hz, int order) {
  const Filter filter = butterworth(order, cutoff_hz, log_.f_m);
  if (team_.size() == 1) {
    return zero_phase(x, filter, options_.convention);
  }
  Matrix out(x.rows(), x.cols());
  team_.run([&](int member) {
    const Index first = x.cols() * member / team_.size();
    const Index last = x.cols() * (member + 1) / team_.size();
    if (last > first) {
      out.middleCols(first, last - first) =
          zero_phase(x.middleCols(first, last - first), filter, options_.convention);
    }
  });
  return out;
}

// The same as central_difference() gives.
double RowSource::velocity(Index sample, Index joint) const {
  const auto q = q_.col(joint);
  if (sample == 0) {
    return (q[1] - q[0]) * log_.f_m;
  }
  if (sample == q.size() - 1) {
    return (q[sample] - q[sample - 1]) * log_.f_m;
  }
  return (q[sample + 1] - q[sample - 1]) * (0.5 * log_.f_m);
}

Motion RowSource::motion_of(const Eigen::Ref<const Matrix>& q) const {
  return masks_.empty() ? differentiate(q, log_.f_m) : averaged_motion(q, log_.f_m);
}

void RowSource::send(std::span<RowSink* const> sinks, std::span<const Motion> others,
                     const std::function<void(double)>& progress) {
  send_parts(sinks, others, true, progress);
}

void RowSource::send_others(std::span<RowSink* const> sinks, std::span<const Motion> others) {
  send_parts(sinks, others, false, {});
}

void RowSource::send_parts(std::span<RowSink* const> sinks, std::span<const Motion> others, bool log,
                           const std::function<void(double)>& progress) {
  const Parts parts{others.size(), log};
  for (const Motion& motion : others) {
    batch_.require("rows", motion, 0, log_.samples());
  }
  if (stride_of(options_) == 1 || options_.convention == Convention::standard) {
    Stream stream = planned(sinks, parts, team_.size());
    decimate(stream);
    run(stream, others, progress);
    return;
  }
  const JointSinks<HeldRows> series(
      joints(), [&](std::size_t j) { return HeldRows(range_.count, row_width(j, parts)); });
  Stream all = planned(series.sinks(), parts, team_.size());
  for (StreamedJoint& joint : all.joints) {
    joint.all_kept = true;
  }
  run(all, others, progress);
  Stream kept = planned(sinks, parts, 0);
  kept.first += kept_samples(range_.count, options_.decimation, options_.convention).front();
  kept.stride = stride_of(options_);
  for (std::size_t j = 0; j < joints(); ++j) {
    const Matrix rows = rivid::decimate(series[j].rows(), options_.decimation, options_.convention);
    for (Index first = 0; first < rows.rows(); first += most_wanted) {
      const Index count = std::min(most_wanted, rows.rows() - first);
      const RowsRoom room = kept.joints[j].sink->room(count);
      for (Index c = 0; c < rows.cols(); ++c) {
        std::copy_n(rows.col(c).data() + first, count, room.target.data + c * room.target.ld);
      }
      deliver(kept, j, room, count);
    }
  }
}

Index RowSource::row_width(std::size_t j, const Parts& parts) const {
  const std::size_t own = columns(j).size();
  return static_cast<Index>(own * parts.others + (parts.log ? own + 1 : 0));
}

RowSource::Stream RowSource::planned(std::span<RowSink* const> sinks, const Parts& parts,
                                     int workspaces) const {
  Stream out;
  out.parts = parts;
  out.first = range_.first;
  for (std::size_t j = 0; j < joints(); ++j) {
    StreamedJoint& joint = out.joints.emplace_back();
    joint.sink = sinks[j];
    joint.columns = row_width(j, parts);
    joint.all_kept =
        all_kept_ ||
        (masks_.empty() && (options_.velocity_threshold.empty() || options_.velocity_threshold[j] == 0.0));
  }
  for (int k = 0; k < workspaces; ++k) {
    out.workspaces.emplace_back(batch_);
  }
  return out;
}

void RowSource::decimate(Stream& stream) const {
  stream.stride = stride_of(options_);
  for (std::size_t j = 0; j < joints(); ++j) {
    StreamedJoint& joint = stream.joints[j];
    if (!masks_.empty() && stream.stride > 1) {
      joint.centres = window_centres(masks_[j], range_.first, range_.count, stream.stride);
      joint.stages.emplace_back(WindowDecimator(joint.columns, stream.stride, joint.centres));
      joint.all_kept = true;  // windows lie within the mask
      continue;
    }
    for (const int n_d : options_.decimation) {
      if (n_d > 1) {
        const bool first_stage = joint.stages.empty();
        joint.stages.emplace_back(StreamingDecimator(
            joint.columns, n_d, first_stage && team_.size() > 1 ? decimated_share * team_.size() : 0));
      }
    }
  }
}

void RowSource::run(Stream& stream, std::span<const Motion> others,
                    const std::function<void(double)>& progress) {
  Index first = 0;
  Index count = 0;
  std::atomic<std::size_t> next = 0;
  const ThreadTeam::Work fill_shares = [&](int member) { fill_share(stream, others, first, count, member); };
  const ThreadTeam::Work advance_joints = [&](int /*member*/) {
    for (std::size_t j = next++; j < joints(); j = next++) {
      advance(stream, j, count);
    }
  };
  const ThreadTeam::Work finish_joints = [&](int /*member*/) {
    for (std::size_t j = next++; j < joints(); j = next++) {
      finish(stream, j);
    }
  };
  for (; first < range_.count; first += count) {
    count = plan_piece(stream, range_.count - first);
    team_.run(fill_shares);
    next = 0;
    team_.run(advance_joints);
    if (progress) {
      progress(static_cast<double>(first + count) / static_cast<double>(range_.count));
    }
  }
  next = 0;
  team_.run(finish_joints);
}

Index RowSource::stretches() const {
  return stride_of(options_) == 1 ? std::max<Index>(range_.count / least_stretch, 1) : 1;
}

void RowSource::send_stretch(Index stretch, std::span<RowSink* const> sinks,
                             const std::function<void(Index)>& progress) const {
  // Whole blocks of the factorisation.
  const Index blocks = (range_.count + most_wanted - 1) / most_wanted;
  const auto begin_of = [&](Index s) {
    return std::min(blocks * s / stretches() * most_wanted, range_.count);
  };
  const Index end = begin_of(stretch + 1);
  Stream stream = planned(sinks, {}, 1);
  Index first = begin_of(stretch);
  stream.first += first;
  for (Index count = 0; first < end; first += count) {
    count = plan_piece(stream, end - first);
    fill(stream, {}, first, 0, count, stream.workspaces.front());
    for (std::size_t j = 0; j < joints(); ++j) {
      advance(stream, j, count);
    }
    progress(count);
  }
}

// Room for the next rows of all joints, of which there are as many as it returns.
Index RowSource::plan_piece(Stream& stream, Index left) const {
  Index count = left;
  for (StreamedJoint& joint : stream.joints) {
    const bool decimated = !joint.stages.empty();
    joint.room = decimated ? joint.stages.front().room() : joint.sink->room(std::min(count, most_wanted));
    count = std::min(count, decimated ? joint.room.rows : most_wanted);
  }
  return count;
}

// One thread's share of the rows `first` … `first` + `count` − 1 of all joints.
void RowSource::fill_share(Stream& stream, std::span<const Motion> others, Index first, Index count,
                           int member) const {
  const Index granules = (count + granule - 1) / granule;
  const Index begin = std::min(granules * member / team_.size() * granule, count);
  const Index end = std::min(granules * (member + 1) / team_.size() * granule, count);
  if (begin < end) {
    fill(stream, others, first, begin, end, stream.workspaces[static_cast<std::size_t>(member)]);
  }
}

// The rows `begin` … `end` − 1 of the piece that begins at row `first`.
void RowSource::fill(Stream& stream, std::span<const Motion> others, Index first, Index begin, Index end,
                     BatchWorkspace& workspace) const {
  const Index sample = range_.first + first + begin;
  for (std::size_t v = 0; v < others.size(); ++v) {
    batch_.fill(others[v], sample, end - begin, targets_of(stream, v), begin, workspace);
  }
  if (stream.parts.log) {
    fill_log(stream, sample, begin, end - begin, workspace);
  }
  for (std::size_t j = 0; j < joints() && !load_by_row_; ++j) {
    fill_loads(j, stream.joints[j].room, stream.parts, begin, end - begin);
  }
}

// Where the columns of each joint begin that are made of a motion: the others first, then that of the log.
std::vector<RowsTarget> RowSource::targets_of(const Stream& stream, std::size_t motion) const {
  std::vector<RowsTarget> out(joints());
  for (std::size_t j = 0; j < joints(); ++j) {
    const RowsTarget& target = stream.joints[j].room.target;
    out[j] = {target.data + static_cast<Index>(columns(j).size() * motion) * target.ld, target.ld};
  }
  return out;
}

// [W Y] of `count` samples, from row `at` of the rooms on.
void RowSource::fill_log(Stream& stream, Index sample, Index at, Index count,
                         BatchWorkspace& workspace) const {
  const Index from = std::max<Index>(sample - difference_border, 0);
  const Index to = std::min(sample + count + difference_border, q_.rows());
  const auto q = q_.middleRows(from, to - from);
  const std::vector<RowsTarget> targets = targets_of(stream, stream.parts.others);
  batch_.fill(motion_of(q), sample - from, count, targets, at, workspace);
  for (std::size_t j = 0; j < joints(); ++j) {
    const RowsTarget& W = targets[j];
    fill_signs(j, sample, count, W.data + at, W.ld);
    double* const y = W.data + static_cast<Index>(columns(j).size()) * W.ld + at;
    std::copy_n(tau_->col(static_cast<Index>(j)).data() + sample, count, y);
    if (known_mass_[j] >= 0) {  // what it needs stands on the other side
      double* const column = W.data + known_mass_[j] * W.ld + at;
      for (Index k = 0; k < count; ++k) {
        y[k] -= mass_ * std::exchange(column[k], 0.0);
      }
    }
  }
}

void RowSource::fill_loads(std::size_t j, const RowsRoom& room, const Parts& parts, Index first,
                           Index count) const {
  const auto own = static_cast<Index>(columns(j).size());
  const RowsTarget& target = room.target;
  double* next = target.data + first;
  for (std::size_t v = 0; v < parts.others; ++v, next += own * target.ld) {
    load_.complete(j, {next, target.ld}, count, nullptr);
  }
  if (parts.log) {
    load_.complete(j, {next, target.ld}, count, next + own * target.ld);
  }
}

// The sign of a noisy velocity is no linear function of the noise, and no average mends it: where the mask
// had to smooth the velocity, the columns of W that are signs take their direction from it.
void RowSource::fill_signs(std::size_t j, Index sample, Index count, double* W, Index ld) const {
  if (masks_.empty()) {
    return;
  }
  for (const SignColumn& column : sign_columns_[j]) {
    for (Index k = 0; k < count; ++k) {
      const double direction = masks_[j].direction[static_cast<std::size_t>(sample + k)];
      if (direction != 0.0) {
        W[column.column * ld + k] = friction_entry(column.basis, column.direction, direction, 0.0);
      }
    }
  }
}

// Rows of joint j that were made go on.
void RowSource::advance(Stream& stream, std::size_t j, Index count) const {
  StreamedJoint& joint = stream.joints[j];
  if (joint.stages.empty()) {
    deliver(stream, j, joint.room, count);
    return;
  }
  joint.stages.front().commit(count);
  pump(stream, j, 0);
}

// What a stage has finished goes into the next one, or out.
void RowSource::pump(Stream& stream, std::size_t j, std::size_t stage) const {
  StreamedJoint& joint = stream.joints[j];
  Stage& decimator = joint.stages[stage];
  const bool last = stage + 1 == joint.stages.size();
  for (Index finished = decimator.finished(); finished > 0; finished = decimator.finished()) {
    const RowsRoom room =
        last ? joint.sink->room(std::min(finished, most_wanted)) : joint.stages[stage + 1].room();
    const Index count = std::min(finished, room.rows);
    decimator.take(count, room.target);
    if (last) {
      deliver(stream, j, room, count);
    } else {
      joint.stages[stage + 1].commit(count);
      pump(stream, j, stage + 1);
    }
  }
}

void RowSource::finish(Stream& stream, std::size_t j) const {
  StreamedJoint& joint = stream.joints[j];
  for (std::size_t stage = 0; stage < joint.stages.size(); ++stage) {
    joint.stages[stage].end();
    pump(stream, j, stage);
  }
}

bool RowSource::kept(Index j, Index sample) const {
  const auto at = static_cast<std::size_t>(j);
  if (!masks_.empty()) {
    return masks_[at].direction[static_cast<std::size_t>(sample)] != 0;
  }
  return options_.velocity_threshold.empty() ||
         std::abs(velocity(sample, j)) >= options_.velocity_threshold[at];
}

// Closes the gaps of rows that are left out.
void RowSource::drop_rows(StreamedJoint& joint, Index j, const RowsRoom& room) const {
  joint.kept.clear();
  for (std::size_t k = 0; k < joint.samples.size(); ++k) {
    if (kept(j, joint.samples[k])) {
      joint.samples[joint.kept.size()] = joint.samples[k];
      joint.kept.push_back(static_cast<Index>(k));
    }
  }
  if (joint.kept.size() < joint.samples.size()) {
    joint.samples.resize(joint.kept.size());
    keep(room, joint.columns, joint.kept);
  }
}

// Rows in the room of a sink are its own now, but for those of slow samples.
void RowSource::deliver(Stream& stream, std::size_t j, const RowsRoom& room, Index count) const {
  StreamedJoint& joint = stream.joints[j];
  joint.samples.resize(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < joint.samples.size(); ++k) {
    const auto row = joint.delivered + static_cast<Index>(k);
    joint.samples[k] = stream.first + (masks_.empty() || joint.stages.empty()
                                           ? row * stream.stride
                                           : joint.centres[static_cast<std::size_t>(row)]);
  }
  joint.delivered += count;
  if (load_by_row_ && stream.stride > 1) {
    fill_loads(j, room, stream.parts, 0, count);
  }
  if (!joint.all_kept) {
    drop_rows(joint, static_cast<Index>(j), room);
  }
  joint.sink->commit(joint.samples);
}

}  // namespace rivid::detail
