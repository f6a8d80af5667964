#include "identify/infer/scores.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/rows/whitened_rows.hpp"

namespace rivid::detail {

namespace {

// Leverage that is corrected for at most: a row that determines a parameter alone has no residual to speak
// of.
constexpr double most_leverage = 0.9;

// Rows of a joint, in a log, that the products of a block are summed over; of more every second, third …
// stands for all.
constexpr Index most_products = 4000;

// Takes the rows [V W Y] or [W Y] of a joint and keeps the sums over them.
class ScoreSink final : public BufferedSink {
 public:
  // What rows of the joint count.
  struct Loss {
    RobustLoss loss;
    double scale = 0.0;
  };
  // One estimator, the joint's own columns of it.
  struct Own {
    Vector chi;
    bool instrumental;
    Matrix bread;
  };

  // stride    samples from one row to the next where none is left out
  // log       whose rows come, among those of blocks and intervals
  ScoreSink(Index own, bool with_V, std::vector<Own> estimators, double weight, std::vector<Index> from_V,
            const TimeIntervals& intervals, const TimeBlocks& time_blocks, std::size_t log, Index samples,
            Index stride, std::optional<Loss> loss)
      : BufferedSink((with_V ? 2 : 1) * own + 1, LagSums::lead),
        own_(own),
        W_at_(with_V ? own : 0),
        estimators_(std::move(estimators)),
        weight_(weight),
        from_V_(std::move(from_V)),
        samples_per_interval_(intervals.samples(log)),
        time_blocks_(time_blocks),
        log_at_(log),
        stride_(stride),
        loss_(loss),
        rho_(Vector::Zero(LagSums::lead + RowSource::most_wanted)),
        lag_(own, stride, intervals.count(log), intervals.samples(log)),
        product_step_(std::max<Index>(samples / stride / most_products, 1)) {
    blocks_.assign(static_cast<std::size_t>(time_blocks.count(log)),
                   {Matrix::Zero(own, own), Vector::Zero(own)});
    sums_.assign(estimators_.size(), Matrix::Zero(intervals.count(log), own));
    curvatures_.assign(loss_ ? estimators_.size() : 0, Matrix::Zero(own, own));
  }

  void commit(std::span<const Index> samples) override {
    constexpr Index lead = LagSums::lead;
    const auto count = static_cast<Index>(samples.size());
    const auto all = rows_.topRows(lead + count);
    for (const Index c : from_V_) {
      rows_.col(W_at_ + c).segment(lead, count) = rows_.col(c).segment(lead, count);
    }
    const auto W = all.middleCols(W_at_, own_).bottomRows(count);
    const auto Y = all.col(W_at_ + own_).tail(count);
    for (std::size_t e = 0; e < estimators_.size(); ++e) {
      const Own& estimator = estimators_[e];
      const auto all_Z = all.middleCols(estimator.instrumental ? 0 : W_at_, own_);
      const auto Z = all_Z.bottomRows(count);
      Vector rho = Y - W * estimator.chi;
      if (e == 0) {
        see(rho, samples);
        rho_.segment(lead, count) = rho;
        lag_.add(all_Z, all.middleCols(W_at_, own_), all.col(W_at_ + own_), rho_.head(lead + count),
                 estimator.chi, samples);
      }
      Vector slope;
      if (loss_) {
        slope = psi(*loss_, rho);
        curvatures_[e].noalias() += weight_ * weight_ * (Z.transpose() * slope.asDiagonal() * W);
      }
      if (e == 0) {
        add_to_blocks(Z, W, rho, slope, samples);
      }
      if (estimator.bread.size() > 0) {
        Vector leverage = weight_ * weight_ * (W * estimator.bread).cwiseProduct(Z).rowwise().sum();
        if (loss_) {
          leverage.array() *= slope.array();
        }
        rho.array() /= 1.0 - leverage.array().cwiseMin(most_leverage);
      }
      for (Index c = 0; c < own_; ++c) {
        for (Index k = 0; k < count; ++k) {
          sums_[e](TimeIntervals::of(samples[static_cast<std::size_t>(k)], samples_per_interval_), c) +=
              Z(k, c) * rho[k];
        }
      }
    }
    // The neighbours of the next rows.
    rows_.topRows(lead) = rows_.middleRows(count, lead).eval();
    rho_.head(lead) = rho_.segment(count, lead).eval();
  }

  [[nodiscard]] const ResidualMoments& moments() const { return moments_; }
  // Adds what LagSums has found to the sums of all joints; `at` is the joint, and the last sums by time are
  // those of this log.
  void add_rates_to(RateSums& all, const std::vector<Index>& columns, Index at) const {
    const double w = weight_ * weight_;
    all.WP(columns, at) += w * lag_.WP;
    all.ZD(columns, at) += w * lag_.ZD.colwise().sum().transpose();
    all.P_rho.back().col(at) = w * lag_.P_rho;
    all.PD.back().col(at) = w * lag_.PD;
    all.ZD_by_time.back()(Eigen::all, columns) += w * lag_.ZD;
  }
  // Adds the scores of estimator e to those of all joints, (intervals × b).
  void add_to(Matrix& all, const std::vector<Index>& columns, std::size_t e) const {
    for (Index c = 0; c < own_; ++c) {
      all.col(columns[static_cast<std::size_t>(c)]) += weight_ * weight_ * sums_[e].col(c);
    }
  }
  // Adds the sums of block g to those of all joints.
  void add_block_to(BlockSums& all, const std::vector<Index>& columns, std::size_t g) const {
    all.ZW(columns, columns) += weight_ * weight_ * blocks_[g].ZW;
    all.Z_rho(columns) += weight_ * weight_ * blocks_[g].Z_rho;
  }
  void add_curvature_to(Matrix& all, const std::vector<Index>& columns, std::size_t e) const {
    all(columns, columns) += curvatures_[e];
  }

 private:
  // Makes s ψ(ρ/s) of residuals; their ψ'.
  [[nodiscard]] static Vector psi(const Loss& loss, Vector& rho) {
    Vector slope(rho.size());
    for (Index k = 0; k < rho.size(); ++k) {
      const double u = rho[k] / loss.scale;
      slope[k] = loss.loss.slope(u);
      rho[k] *= loss.loss.weight(u);
    }
    return slope;
  }

  // slope  ψ' of the residuals, of which rho then is s ψ(ρ/s); empty without a loss
  void add_to_blocks(const Eigen::Ref<const Matrix>& Z, const Eigen::Ref<const Matrix>& W, const Vector& rho,
                     const Vector& slope, std::span<const Index> samples) {
    time_blocks_.divide(log_at_, samples, [&](Index at, Index begin, Index rows) {
      BlockSums& block = blocks_[static_cast<std::size_t>(at - time_blocks_.first(log_at_))];
      block.Z_rho.noalias() += Z.middleRows(begin, rows).transpose() * rho.segment(begin, rows);
      const Index first = begin + (product_step_ - seen_ % product_step_) % product_step_;
      seen_ += rows;
      if (first < begin + rows) {
        const auto some = Eigen::seq(first, begin + rows - 1, product_step_);
        Matrix some_Z = Z(some, Eigen::all);
        if (slope.size() > 0) {
          some_Z.array().colwise() *= slope(some).array();
        }
        const Matrix some_W = W(some, Eigen::all);
        block.ZW.noalias() += static_cast<double>(product_step_) * (some_Z.transpose() * some_W);
      }
    });
  }

  void see(const Vector& rho, std::span<const Index> samples) {
    for (Index k = 0; k < rho.size(); ++k) {
      const Index sample = samples[static_cast<std::size_t>(k)];
      if (sample - last_ != stride_) {
        run_ = 0;
      }
      last_ = sample;
      const auto reach = std::min<std::size_t>(run_, ResidualMoments::lags);
      for (std::size_t l = 1; l <= reach; ++l) {
        moments_.products[l - 1] += rho[k] * before_[(run_ - l) % before_.size()];
        moments_.pair_counts[l - 1] += 1.0;
      }
      before_[run_ % before_.size()] = rho[k];
      ++run_;
      double power = 1.0;
      for (double& sum : moments_.powers) {
        power *= rho[k];
        sum += power;
      }
      ++moments_.rows;
    }
  }

  Index own_;
  Index W_at_;
  std::vector<Own> estimators_;
  double weight_;
  std::vector<Index> from_V_;
  double samples_per_interval_;
  const TimeBlocks& time_blocks_;
  std::size_t log_at_;
  Index stride_;
  std::optional<Loss> loss_;
  Vector rho_;  // of the first estimator
  LagSums lag_;
  Index product_step_;  // from one row to the next whose products are summed
  Index seen_ = 0;      // rows
  std::vector<BlockSums> blocks_;
  std::vector<Matrix> sums_;
  std::vector<Matrix> curvatures_;
  ResidualMoments moments_;
  std::array<double, ResidualMoments::lags> before_{};  // the last residuals, in a ring
  std::size_t run_ = 0;                                 // residuals since the last gap
  Index last_ = -1;
};

std::optional<ScoreSink::Loss> loss_of(const RowLoss* loss, std::size_t j) {
  return loss == nullptr ? std::nullopt : std::optional(ScoreSink::Loss{loss->loss, loss->scales[j]});
}

// No finer than rows.
double shortest_interval(std::span<const Log> logs, std::span<const SignalOptions> signals) {
  double out = 0.0;
  for (std::size_t l = 0; l < logs.size(); ++l) {
    out = std::max(out, static_cast<double>(stride_of(signals[l])) / logs[l].f_m);
  }
  return out;
}

}  // namespace

void ResidualMoments::merge(const ResidualMoments& other) {
  const auto add = [](auto& to, const auto& from) {
    std::ranges::transform(to, from, to.begin(), [](double a, double b) { return a + b; });
  };
  rows += other.rows;
  add(powers, other.powers);
  add(products, other.products);
  add(pair_counts, other.pair_counts);
}

Scores scores(const EstimationProblem& problem, std::span<const SignalOptions> signals,
              std::span<const Motion> instruments, std::span<const Estimator> estimators,
              std::span<const double> weights, const std::vector<std::vector<Index>>& from_V,
              std::span<const Vector> whitening, const RowLoss* loss) {
  const std::span<const Log> logs = problem.logs;
  const std::vector<RowGroup>& joints = problem.data.groups;
  const Index b = problem.base.size();
  Scores out;
  const TimeIntervals intervals(durations(logs), shortest_interval(logs, signals));
  const TimeBlocks blocks(durations(logs, problem.estimation.signal.window), blocks_of_time);
  out.interval = intervals.seconds();
  out.series.resize(estimators.size());
  out.residuals.resize(joints.size());
  out.rates.WP = out.rates.ZD = Matrix::Zero(b, problem.joints());
  if (loss != nullptr) {
    out.curvature.assign(estimators.size(), Matrix::Zero(b, b));
  }
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const Log& log = logs[l];
    std::vector<Index> widths;
    JointSinks<ScoreSink> sinks(joints.size(), [&](std::size_t j) {
      const std::vector<Index>& columns = joints[j].columns;
      widths.push_back(static_cast<Index>(columns.size()) * (instruments.empty() ? 1 : 2) + 1);
      std::vector<ScoreSink::Own> own;
      for (const Estimator& estimator : estimators) {
        own.push_back({estimator.chi(columns), estimator.instrumental,
                       estimator.bread.size() > 0 ? Matrix(estimator.bread(columns, columns)) : Matrix()});
      }
      return ScoreSink(static_cast<Index>(columns.size()), !instruments.empty(), std::move(own), weights[j],
                       from_V.empty() ? std::vector<Index>{} : from_V[j], intervals, blocks, l, log.samples(),
                       stride_of(signals[l]), loss_of(loss, j));
    });
    const WhitenedSinks whitened(sinks.sinks(), whitening, widths);
    problem.send_rows(l, signals[l], whitened.sinks(),
                      instruments.empty() ? instruments : instruments.subspan(l, 1));
    for (std::size_t e = 0; e < estimators.size(); ++e) {
      Matrix all = Matrix::Zero(intervals.count(l), b);
      for (std::size_t j = 0; j < joints.size(); ++j) {
        sinks[j].add_to(all, joints[j].columns, e);
        if (loss != nullptr) {
          sinks[j].add_curvature_to(out.curvature[e], joints[j].columns, e);
        }
      }
      out.series[e].push_back(std::move(all));
    }
    for (std::size_t g = 0; g < static_cast<std::size_t>(blocks.count(l)); ++g) {
      BlockSums& all = out.blocks.emplace_back(Matrix::Zero(b, b), Vector::Zero(b));
      for (std::size_t j = 0; j < joints.size(); ++j) {
        sinks[j].add_block_to(all, joints[j].columns, g);
      }
    }
    out.rates.P_rho.emplace_back(intervals.count(l), problem.joints());
    out.rates.PD.emplace_back(intervals.count(l), problem.joints());
    out.rates.ZD_by_time.emplace_back(Matrix::Zero(intervals.count(l), b));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      out.residuals[j].merge(sinks[j].moments());
      sinks[j].add_rates_to(out.rates, joints[j].columns, static_cast<Index>(j));
    }
  }
  return out;
}

}  // namespace rivid::detail
