#pragma once

#include <functional>
#include <span>
#include <vector>

#include "identify/rows/exact_rows.hpp"
#include "identify/rows/thread_team.hpp"
#include "ranges.hpp"
#include "rivid/data/log.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Samples from one row to the next, where none is left out.
[[nodiscard]] Index stride_of(const SignalOptions& signal);

/// Logs cut to SignalOptions::window, as if nothing else had been recorded. A log without a sample in the
/// window stays whole.
///
/// @param room  holds them where there is a window
[[nodiscard]] std::span<const Log> within_window(std::span<const Log> logs, const SignalOptions& signal,
                                                 std::vector<Log>& room);

/// Takes the rows of one joint.
class RowSink {
 public:
  virtual ~RowSink() = default;

  /// Room for the next rows, column after column, at least `wanted` rows.
  virtual RowsRoom room(Index wanted) = 0;
  /// Takes the first samples.size() rows of the room; `samples`: the samples of the log that they stand for.
  virtual void commit(std::span<const Index> samples) = 0;
};

/// Sinks of one kind, one a joint.
template <typename Sink>
class JointSinks {
 public:
  /// @param make  gives that of joint j
  template <typename Make>
  JointSinks(std::size_t joints, const Make& make)
      : own_(made_of(joints, make)),
        sinks_(made_of(joints, [&](std::size_t j) -> RowSink* { return &own_[j]; })) {}
  JointSinks(const JointSinks&) = delete;
  JointSinks& operator=(const JointSinks&) = delete;
  JointSinks(JointSinks&&) = default;
  JointSinks& operator=(JointSinks&&) = default;
  ~JointSinks() = default;

  [[nodiscard]] std::span<RowSink* const> sinks() const { return sinks_; }
  [[nodiscard]] Sink& operator[](std::size_t j) { return own_[j]; }
  [[nodiscard]] const Sink& operator[](std::size_t j) const { return own_[j]; }

 private:
  std::vector<Sink> own_;
  std::vector<RowSink*> sinks_;
};

/// Holds the rows of a joint.
class HeldRows final : public RowSink {
 public:
  /// @param rows  that may come at most
  HeldRows(Index rows, Index columns) : rows_(rows, columns) {}

  RowsRoom room(Index /*wanted*/) override {
    return {{rows_.data() + size(), rows_.rows()}, rows_.rows() - size()};
  }
  void commit(std::span<const Index> samples) override {
    samples_.insert(samples_.end(), samples.begin(), samples.end());
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(samples_.size()); }
  [[nodiscard]] Index columns() const { return rows_.cols(); }
  [[nodiscard]] auto rows() const { return rows_.topRows(size()); }
  [[nodiscard]] std::vector<Index>& samples() { return samples_; }
  [[nodiscard]] const std::vector<Index>& samples() const { return samples_; }

 private:
  Matrix rows_;
  std::vector<Index> samples_;
};

/// The rows of a log, Eqs. (10–14): the one way from samples to rows, for whoever holds them and for whoever
/// factors them. They come joint by joint in pieces that stay in the cache, and memory does not grow with the
/// log: positions are filtered as a whole, derivatives and regressor are made for a piece at a time,
/// decimated in a stream, and rows of slow samples left out.
///
/// W comes from the motion of the log. Other motions of the same samples may go along, such as the simulated
/// one of the instruments: their columns are decimated alike, and the log decides which rows are left out. So
/// the rows of a joint are [V_1 … V_k W Y].
///
/// Convention `matlab` decimates whole series, as MATLAB's function does, and holds all rows meanwhile.
class RowSource {
 public:
  /// Rows that room() of a sink is asked for at most.
  static constexpr Index most_wanted = 512;

  /// Log and options are referred to, not copied.
  ///
  /// @throws InputError  where log, robot and options do not fit together or no sample is left
  RowSource(const Robot& robot, const BaseParameters& base, const Log& log, const SignalOptions& options,
            ThreadTeam& team);

  [[nodiscard]] std::size_t joints() const { return batch_.joints(); }
  /// Samples that rows are made of.
  [[nodiscard]] Index samples() const { return range_.count; }
  /// Columns of W that the rows of joint j touch.
  [[nodiscard]] const std::vector<Index>& columns(std::size_t j) const { return batch_.of_joint(j); }
  /// Rows of each joint before any are left out for low velocity.
  [[nodiscard]] Index rows() const { return rows_; }
  /// Numbers that are held as long as this lives: motion and torques where they are filtered.
  [[nodiscard]] Index numbers() const { return q_.size() + made_tau_.size(); }
  /// First of the samples that rows are made of.
  [[nodiscard]] Index first_sample() const { return range_.first; }
  /// The motion of the log that W is made of, filtered, (n_m × n).
  [[nodiscard]] Motion motion() const { return motion_of(q_); }
  /// Whether the row of joint j at a sample is kept: it moves fast enough, and far from reversals.
  [[nodiscard]] bool kept(Index j, Index sample) const;
  /// From now on the rows that kept() leaves out are sent as well.
  void leave_nothing_out() { all_kept_ = true; }
  /// What RowScheme::exact leaves out, (n); empty otherwise.
  [[nodiscard]] const std::vector<MotionMask>& masks() const { return masks_; }

  /// Stretches of samples whose rows may be sent apart from each other, on several threads: 1 where rows are
  /// decimated, since these know of their neighbours. They do not depend on the size of the team.
  [[nodiscard]] Index stretches() const;
  /// Sends the rows of one stretch to the sinks, (n), by the calling thread alone. Other threads may send
  /// other stretches to other sinks meanwhile.
  ///
  /// @param progress  called with the number of samples that were sent since the last call
  void send_stretch(Index stretch, std::span<RowSink* const> sinks,
                    const std::function<void(Index)>& progress) const;

  /// Sends all rows to the sinks, (n). A sink is only called by one thread at a time. The rows are the same,
  /// bit by bit, whatever the size of the team.
  ///
  /// @param others    motions V_1 … V_k, each (n_m × n) at the samples of the log
  /// @param progress  called with the fraction done, by the calling thread
  void send(std::span<RowSink* const> sinks, std::span<const Motion> others = {},
            const std::function<void(double)>& progress = {});
  /// The same without the rows of the log itself, [V_1 … V_k], with the bits that these columns have beside W
  /// and Y.
  void send_others(std::span<RowSink* const> sinks, std::span<const Motion> others);

 private:
  // What the rows of a joint consist of.
  struct Parts {
    std::size_t others = 0;
    bool log = true;  // [W Y] behind them
  };

  struct Range {
    Index first = 0;
    Index count = 0;
  };
  struct StreamedJoint;
  struct Stream;
  // A column of W, within a joint's own, that is the sign of its velocity.
  struct SignColumn {
    Index column = 0;
    Basis basis = Basis::sign;
    Direction direction = Direction::both;
  };

  [[nodiscard]] static Range kept_range(const Log& log, const SignalOptions& options);
  [[nodiscard]] Matrix filtered(const Matrix& x, double cutoff_hz, int order);
  [[nodiscard]] double velocity(Index sample, Index joint) const;
  [[nodiscard]] Motion motion_of(const Eigen::Ref<const Matrix>& q) const;
  void send_parts(std::span<RowSink* const> sinks, std::span<const Motion> others, bool log,
                  const std::function<void(double)>& progress);
  [[nodiscard]] Index row_width(std::size_t j, const Parts& parts) const;
  [[nodiscard]] Stream planned(std::span<RowSink* const> sinks, const Parts& parts, int workspaces) const;
  void decimate(Stream& stream) const;
  void run(Stream& stream, std::span<const Motion> others, const std::function<void(double)>& progress);
  [[nodiscard]] Index plan_piece(Stream& stream, Index left) const;
  void fill_share(Stream& stream, std::span<const Motion> others, Index first, Index count, int member) const;
  void fill(Stream& stream, std::span<const Motion> others, Index first, Index begin, Index end,
            BatchWorkspace& workspace) const;
  [[nodiscard]] std::vector<RowsTarget> targets_of(const Stream& stream, std::size_t motion) const;
  void fill_log(Stream& stream, Index sample, Index at, Index count, BatchWorkspace& workspace) const;
  void find_sign_columns(const Robot& robot, const BaseParameters& base);
  void find_known_mass(const Robot& robot, const BaseParameters& base);
  // The columns of friction that follows the load, of the rows [V … W Y] in a room.
  void fill_loads(std::size_t j, const RowsRoom& room, const Parts& parts, Index first, Index count) const;
  void fill_signs(std::size_t j, Index sample, Index count, double* W, Index ld) const;
  void advance(Stream& stream, std::size_t j, Index count) const;
  void pump(Stream& stream, std::size_t j, std::size_t stage) const;
  void finish(Stream& stream, std::size_t j) const;
  void deliver(Stream& stream, std::size_t j, const RowsRoom& room, Index count) const;
  void drop_rows(StreamedJoint& joint, Index j, const RowsRoom& room) const;

  const Log& log_;
  const SignalOptions& options_;
  ThreadTeam& team_;
  RegressorBatch batch_;
  LoadColumns load_;
  Range range_;
  Index rows_ = 0;
  Matrix q_;
  Matrix made_tau_;  // empty where the log's torques are used as they are
  const Matrix* tau_ = nullptr;
  std::vector<MotionMask> masks_;
  std::vector<std::vector<SignColumn>> sign_columns_;  // of each joint, where the mask smoothed its velocity
  std::vector<Index> known_mass_;  // its column among those of each joint, −1 where there is none
  double mass_ = 0.0;
  bool all_kept_ = false;
  bool load_by_row_ = false;  // the load is computed from decimated rows
};

/// A sink with a room of its own, behind `lead` rows that belong to its commit(), zero at first.
class BufferedSink : public RowSink {
 public:
  RowsRoom room(Index /*wanted*/) final {
    return {{rows_.data() + lead_, rows_.rows()}, RowSource::most_wanted};
  }

 protected:
  explicit BufferedSink(Index columns, Index lead = 0)
      : rows_(Matrix::Zero(lead + RowSource::most_wanted, columns)), lead_(lead) {}

  Matrix rows_;

 private:
  Index lead_;
};

/// @throws InputError  where a series of the log has other sizes than robot and log ask for
void require_joints(const char* what, const Matrix& x, const Robot& robot, const Log& log);

}  // namespace rivid::detail
