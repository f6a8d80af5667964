#include <algorithm>
#include <cmath>
#include <limits>

#include "accept.hpp"
#include "identify/choose/row_choice.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// of time; a choice: with 5 degrees of freedom Student's t is 2.6, with fewer it grows fast
constexpr int fewest_blocks = 6;

using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

// What the models leave of a log. Which rows a joint has depends on the motors that it turns, whose reversals
// leave rows out: only those count that all models have.
struct LogErrors {
  struct OfModel {
    Matrix residual;  // Y − W χ, (samples × n); 0 where the joint has no row
    Matrix measured;  // Y, alike
  };
  std::vector<OfModel> models;
  std::vector<Index> samples;  // at which some joint has a row
  Mask rows;                   // which of the joints have, (samples × n)
};

LogErrors errors_of(std::span<const ComparedModel> models, const Log& log, const SignalOptions& signal) {
  LogErrors out;
  const Matrix none = Matrix::Zero(log.q.rows(), log.q.cols());
  Mask rows = Mask::Constant(none.rows(), none.cols(), true);
  for (const ComparedModel& model : models) {
    Identification identification;
    const BaseParameters base = base_parameters(model.robot);
    identification.chi = base.from_standard(model.chi_st);
    identification.base = at_load(base, identification.chi);
    identification.estimation.signal = signal;
    const Prediction prediction = predict(model.robot, identification, log);
    LogErrors::OfModel& errors = out.models.emplace_back(none, none);
    Mask own = Mask::Constant(none.rows(), none.cols(), false);
    for (Index j = 0; j < none.cols(); ++j) {
      const JointPrediction& joint = prediction.joints[static_cast<std::size_t>(j)];
      errors.residual.col(j)(joint.rows) = joint.residual;
      errors.measured.col(j)(joint.rows) = joint.fitted.measured;
      own.col(j)(joint.rows) = true;
    }
    rows = rows && own;
  }
  out.samples = detail::places_where(rows.rows(), [&](Index k) { return rows.row(k).any(); });
  out.rows = rows(out.samples, Eigen::all);
  for (LogErrors::OfModel& errors : out.models) {
    for (Matrix* const x : {&errors.residual, &errors.measured}) {
      const Matrix some = (*x)(out.samples, Eigen::all);
      *x = out.rows.select(some, 0.0);
    }
  }
  return out;
}

Comparison::Error summed_up(std::span<const LogErrors> logs, std::size_t model) {
  Vector squares = Vector::Zero(logs.front().rows.cols());
  Vector measured = squares;
  for (const LogErrors& log : logs) {
    squares += log.models[model].residual.colwise().squaredNorm().transpose();
    measured += log.models[model].measured.colwise().squaredNorm().transpose();
  }
  const Vector joints = squares.cwiseQuotient(measured).cwiseSqrt();
  Comparison::Error out;
  out.joints.assign(joints.begin(), joints.end());
  out.relative_error = std::sqrt(squares.sum() / measured.sum());
  return out;
}

// With a gap where rows are farther apart than most.
Comparison::Trace trace_of(const LogErrors& errors, Index joint, const Log& log) {
  std::vector<Index> rows;  // −1 in a gap
  std::vector<double> times;
  Index stride = 0;
  Index last = 0;
  for (const Index k :
       detail::places_where(errors.rows.rows(), [&](Index i) { return errors.rows(i, joint); })) {
    const Index sample = errors.samples[static_cast<std::size_t>(k)];
    stride = rows.size() == 1 ? sample - last : stride;
    if (!rows.empty() && sample > last + 2 * stride) {
      rows.push_back(-1);
      times.push_back(static_cast<double>(last + 1) / log.f_m);
    }
    rows.push_back(k);
    times.push_back(static_cast<double>(sample) / log.f_m);
    last = sample;
  }
  Comparison::Trace out;
  out.log = log.source;
  out.time = Eigen::Map<const Vector>(times.data(), std::ssize(times));
  out.errors = Matrix::NullaryExpr(std::ssize(rows), std::ssize(errors.models), [&](Index k, Index m) {
    const Index row = rows[static_cast<std::size_t>(k)];
    return row < 0 ? std::numeric_limits<double>::quiet_NaN()
                   : errors.models[static_cast<std::size_t>(m)].residual(row, joint);
  });
  return out;
}

PairedTest tested(std::span<const LogErrors> logs, std::size_t a, std::size_t b, int blocks) {
  Vector sums = Vector::Zero(logs.front().rows.cols());
  Vector counts = sums;
  for (const LogErrors& log : logs) {
    for (const std::size_t model : {a, b}) {
      sums += log.models[model].residual.colwise().squaredNorm().transpose();
      counts += log.rows.cast<double>().colwise().sum().matrix().transpose();
    }
  }
  // Mean squared error of both models on each joint.
  const Vector scales = (sums.array() > 0.0).select(sums.cwiseQuotient(counts), 1.0);
  std::vector<Vector> series;
  Eigen::Vector2d losses = Eigen::Vector2d::Zero();
  for (const LogErrors& log : logs) {
    // Σ_j e_j² / s_j², sample by sample.
    const auto loss = [&](std::size_t model) -> Vector {
      return (log.models[model].residual.array().square().rowwise() / scales.transpose().array())
          .rowwise()
          .sum();
    };
    const Vector of_a = loss(a);
    const Vector of_b = loss(b);
    losses += Eigen::Vector2d(of_a.sum(), of_b.sum());
    series.push_back(of_a - of_b);
  }
  PairedTest out = paired_test(series, blocks);
  out.a = a;
  out.b = b;
  out.ratio = losses[0] / losses[1];
  return out;
}

void expect_comparable(std::span<const ComparedModel> models) {
  for (const ComparedModel& model : models) {
    const auto& first = models.front().robot.joints;
    const auto& joints = model.robot.joints;
    if (!std::ranges::equal(first, joints, {}, &Joint::name, &Joint::name)) {
      throw InputError("compare: " + model.name + " has other joints than " + models.front().name);
    }
    const auto size = std::ssize(model.robot.standard_parameters());
    if (model.chi_st.size() != size || !model.chi_st.allFinite()) {
      throw InputError("compare: " + model.name + " has " + counted(model.chi_st.size(), "value") +
                       ", must have one, finite, for each of " + counted(size, "standard parameter"));
    }
  }
}

// Sums of `length` consecutive entries; what is left at the end belongs to the last block.
void add_blocks(const Vector& series, Index count, std::vector<double>& to) {
  for (Index k = 0; k < count; ++k) {
    const Index from = series.size() * k / count;
    to.push_back(series.segment(from, series.size() * (k + 1) / count - from).sum());
  }
}

}  // namespace

std::optional<std::string> ComparisonOptions::complaint() const {
  if (blocks < fewest_blocks) {
    return "blocks is " + std::to_string(blocks) + ", must be at least " + std::to_string(fewest_blocks);
  }
  if (!(level > 0.0 && level < 1.0)) {
    return "level is " + number(level) + ", must be between 0 and 1";
  }
  if (threads < 1) {
    return "threads is " + std::to_string(threads) + ", must be at least 1";
  }
  return std::nullopt;
}

PairedTest paired_test(std::span<const Vector> series, int blocks) {
  detail::accept("paired_test", ComparisonOptions{.blocks = blocks}.complaint());
  PairedTest out;
  Index samples = 0;
  std::vector<Matrix> centred;
  double mean = 0.0;
  for (const Vector& each : series) {
    samples += each.size();
    mean += each.sum();
  }
  if (!std::isfinite(mean)) {
    throw InputError("paired_test: a difference is not finite, or so large that their sum overflows");
  }
  if (samples == 0) {
    return out;
  }
  mean /= static_cast<double>(samples);
  for (const Vector& each : series) {
    centred.emplace_back((each.array() - mean).matrix());
  }
  const Index shortest = bartlett_lag(centred) + 1;  // longer than the errors are correlated
  const Index wanted = std::min<Index>(blocks, samples / std::max<Index>(shortest, 1));
  std::vector<double> sums;
  for (const Vector& each : series) {
    const Index share = (wanted * each.size() + samples / 2) / samples;
    add_blocks(each, std::max<Index>(share, each.size() >= shortest ? 1 : 0), sums);
  }
  out.blocks = static_cast<int>(sums.size());
  if (out.blocks < fewest_blocks) {
    return out;
  }
  const Eigen::Map<const Vector> d(sums.data(), static_cast<Index>(sums.size()));
  const double count = static_cast<double>(d.size());
  const double variance = (d.array() - d.mean()).square().sum() / (count - 1.0);
  out.t = variance > 0.0 ? d.mean() / std::sqrt(variance / count) : 0.0;
  out.p = f_tail(out.t * out.t, 1.0, count - 1.0);
  return out;
}

Comparison compare(std::span<const ComparedModel> models, std::span<const Log> logs,
                   const ComparisonOptions& options) {
  if (models.empty() || logs.empty()) {
    throw InputError("compare: there is no model, or no log to judge it by");
  }
  detail::accept("compare", options.complaint());
  expect_comparable(models);
  Estimation estimation{.method = Wls{}, .signal = options.signal};
  estimation.threads = options.threads;
  if (options.signal.automatic()) {
    static_cast<void>(detail::choose_rows(without_load(models.front().robot), logs, estimation));
  }
  Comparison out;
  out.signal = estimation.signal;
  out.joints = detail::made_of(models.front().robot.joints, &Joint::name);
  out.logs = detail::made_of(logs, &Log::source);
  const std::vector<LogErrors> errors =
      detail::made_of(logs, [&](const Log& log) { return errors_of(models, log, estimation.signal); });
  out.rows = detail::sum_of(errors, [](const LogErrors& log) { return log.rows.count(); });
  if (out.rows == 0) {
    throw InputError(
        "compare: " + listed(out.logs) +
        ": no joint moves for long enough in one direction by a torque that changes: there is no row to "
        "judge a model by");
  }
  for (std::size_t m = 0; m < models.size(); ++m) {
    out.models.push_back(summed_up(errors, m));
    out.models.back().name = models[m].name;
    if (!std::isfinite(out.models.back().relative_error)) {
      throw InputError(
          "compare: " + listed(out.logs) +
          ": the torques are zero in every row: no error is relative to them; check the columns");
    }
  }
  const std::vector<double>& of_first = out.models.front().joints;
  const std::ptrdiff_t worst = std::ranges::max_element(of_first) - of_first.begin();
  for (std::size_t l = 0; l < logs.size(); ++l) {
    out.traces.push_back(trace_of(errors[l], worst, logs[l]));
    out.traces.back().joint = out.joints[static_cast<std::size_t>(worst)];
  }
  const double pairs = 0.5 * static_cast<double>(models.size() * (models.size() - 1));
  for (std::size_t a = 0; a < models.size(); ++a) {
    for (std::size_t b = a + 1; b < models.size(); ++b) {
      PairedTest& test = out.tests.emplace_back(tested(errors, a, b, options.blocks));
      test.p = std::isfinite(test.p) ? std::min(1.0, test.p * pairs) : test.p;
      if (test.p < options.level) {
        test.better = test.t < 0.0 ? a : b;
      }
    }
  }
  return out;
}

std::vector<ParameterChange> parameter_changes(std::span<const ParameterValue> a,
                                               std::span<const ParameterValue> b) {
  std::vector<ParameterChange> out;
  for (const ParameterValue& before : a) {
    const auto after = std::ranges::find(b, before.name, &ParameterValue::name);
    const double sigma = after == b.end() ? 0.0 : std::hypot(before.sigma, after->sigma);
    if (sigma > 0.0) {
      out.push_back({.name = before.name,
                     .unit = before.unit,
                     .a = before.value,
                     .b = after->value,
                     .sigma = sigma,
                     .z = (after->value - before.value) / sigma});
    }
  }
  for (ParameterChange& change : out) {
    change.p = std::min(1.0, chi_square_tail(change.z * change.z, 1.0) * static_cast<double>(out.size()));
  }
  std::ranges::stable_sort(
      out, [](const ParameterChange& x, const ParameterChange& y) { return std::abs(x.z) > std::abs(y.z); });
  return out;
}

}  // namespace rivid
