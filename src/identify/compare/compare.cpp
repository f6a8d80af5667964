#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "accept.hpp"
#include "identify/choose/row_choice.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr int fewest_blocks = 6;

struct JudgedRow {
  double residual = 0.0;  // Y − W χ
  double measured = 0.0;  // Y
};
// Rows of one model on one log: of each joint, by the sample that they stand for.
using LogErrors = std::vector<std::map<Index, JudgedRow>>;

LogErrors errors_of(const ComparedModel& model, const Log& log, const SignalOptions& signal) {
  Identification identification;
  const BaseParameters base = base_parameters(model.robot);
  identification.chi = base.from_standard(model.chi_st);
  identification.base = at_load(base, identification.chi);
  identification.estimation.signal = signal;
  const Prediction prediction = predict(model.robot, identification, log);
  LogErrors out(prediction.joints.size());
  for (std::size_t j = 0; j < out.size(); ++j) {
    const JointPrediction& joint = prediction.joints[j];
    for (std::size_t i = 0; i < joint.rows.size(); ++i) {
      const auto at = static_cast<Index>(i);
      out[j].emplace(joint.rows[i], JudgedRow{joint.residual[at], joint.fitted.measured[at]});
    }
  }
  return out;
}

// Which rows a joint has depends on the motors that it turns, whose reversals leave rows out: only those
// count that all models have.
void keep_common(std::vector<LogErrors>& models) {
  for (std::size_t j = 0; j < models.front().size(); ++j) {
    for (LogErrors& model : models) {
      std::erase_if(model[j], [&](const auto& row) {
        return std::ranges::any_of(models,
                                   [&](const LogErrors& other) { return !other[j].contains(row.first); });
      });
    }
  }
}

// errors[log][model][joint]
using AllErrors = std::vector<std::vector<LogErrors>>;

Comparison::Error summed_up(const AllErrors& errors, std::size_t model, std::size_t joints) {
  Comparison::Error out;
  double squares = 0.0;
  double measured = 0.0;
  for (std::size_t j = 0; j < joints; ++j) {
    double joint_squares = 0.0;
    double joint_measured = 0.0;
    for (const std::vector<LogErrors>& log : errors) {
      for (const auto& [sample, row] : log[model][j]) {
        joint_squares += row.residual * row.residual;
        joint_measured += row.measured * row.measured;
      }
    }
    out.joints.push_back(std::sqrt(joint_squares / joint_measured));
    squares += joint_squares;
    measured += joint_measured;
  }
  out.relative_error = std::sqrt(squares / measured);
  return out;
}

// With a gap where rows are farther apart than most.
Comparison::Trace trace_of(const std::vector<LogErrors>& models, std::size_t joint, const Log& log) {
  const std::map<Index, JudgedRow>& rows = models.front()[joint];
  const Index stride = rows.size() > 1 ? std::next(rows.begin())->first - rows.begin()->first : 1;
  std::vector<Index> samples;
  for (const auto& [sample, row] : rows) {
    if (!samples.empty() && sample > samples.back() + 2 * stride) {
      samples.push_back(samples.back() + 1);
    }
    samples.push_back(sample);
  }
  Comparison::Trace out;
  out.log = log.source;
  out.time = Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>>(samples.data(), std::ssize(samples))
                 .cast<double>() /
             log.f_m;
  out.errors.resize(out.time.size(), std::ssize(models));
  for (Index k = 0; k < out.errors.size(); ++k) {
    const auto& found = models[static_cast<std::size_t>(k / out.time.size())][joint];
    const auto row = found.find(samples[static_cast<std::size_t>(k % out.time.size())]);
    out.errors.data()[k] =
        row == found.end() ? std::numeric_limits<double>::quiet_NaN() : row->second.residual;
  }
  return out;
}

// Mean squared error of two models on each joint.
Vector joint_scales(const AllErrors& errors, std::size_t a, std::size_t b) {
  const std::size_t joints = errors.front()[a].size();
  Vector out = Vector::Zero(static_cast<Index>(joints));
  for (std::size_t j = 0; j < joints; ++j) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const std::vector<LogErrors>& log : errors) {
      for (const std::size_t model : {a, b}) {
        for (const auto& [sample, row] : log[model][j]) {
          sum += row.residual * row.residual;
        }
        count += log[model][j].size();
      }
    }
    out[static_cast<Index>(j)] = sum > 0.0 ? sum / static_cast<double>(count) : 1.0;
  }
  return out;
}

// Σ_j e_j² / s_j² of one model, sample by sample.
std::map<Index, double> loss(const LogErrors& errors, const Vector& scales) {
  std::map<Index, double> out;
  for (std::size_t j = 0; j < errors.size(); ++j) {
    for (const auto& [sample, row] : errors[j]) {
      out[sample] += row.residual * row.residual / scales[static_cast<Index>(j)];
    }
  }
  return out;
}

PairedTest tested(const AllErrors& errors, std::size_t a, std::size_t b, int blocks) {
  const Vector scales = joint_scales(errors, a, b);
  std::vector<Vector> series;
  double loss_a = 0.0;
  double loss_b = 0.0;
  for (const std::vector<LogErrors>& log : errors) {
    const std::map<Index, double> of_a = loss(log[a], scales);
    const std::map<Index, double> of_b = loss(log[b], scales);
    Vector& differences = series.emplace_back(static_cast<Index>(of_a.size()));
    Index t = 0;
    for (const auto& [sample, value] : of_a) {
      const double other = of_b.at(sample);
      loss_a += value;
      loss_b += other;
      differences[t++] = value - other;
    }
  }
  PairedTest out = paired_test(series, blocks);
  out.a = a;
  out.b = b;
  out.ratio = loss_a / loss_b;
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
  const std::size_t joints = models.front().robot.joints.size();
  Estimation estimation{.method = Wls{}, .signal = options.signal};
  estimation.threads = options.threads;
  if (options.signal.automatic()) {
    static_cast<void>(detail::choose_rows(without_load(models.front().robot), logs, estimation));
  }
  Comparison out;
  out.signal = estimation.signal;
  for (const Joint& joint : models.front().robot.joints) {
    out.joints.push_back(joint.name);
  }
  AllErrors errors;
  for (const Log& log : logs) {
    out.logs.push_back(log.source);
    std::vector<LogErrors>& of_log = errors.emplace_back();
    for (const ComparedModel& model : models) {
      of_log.push_back(errors_of(model, log, estimation.signal));
    }
    keep_common(of_log);
    for (std::size_t j = 0; j < joints; ++j) {
      out.rows += static_cast<Index>(of_log.front()[j].size());
    }
  }
  if (out.rows == 0) {
    throw InputError(
        "compare: " + listed(out.logs) +
        ": no joint moves for long enough in one direction by a torque that changes: there is no row to "
        "judge a model by");
  }
  for (std::size_t m = 0; m < models.size(); ++m) {
    out.models.push_back(summed_up(errors, m, joints));
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
    out.traces.push_back(trace_of(errors[l], static_cast<std::size_t>(worst), logs[l]));
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
