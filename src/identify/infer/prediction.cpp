#include "rivid/identify/prediction.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "accept.hpp"
#include "identify/infer/parameter_set.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

// Makes torques and predictions of the rows that it is given, and forgets the rows.
class PredictionSink final : public detail::BufferedSink {
 public:
  PredictionSink(const std::vector<Index>& columns, const Vector& chi)
      : BufferedSink(std::ssize(columns) + 1), chi_(chi(columns)) {}

  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    const Vector predicted = rows_.topLeftCorner(count, chi_.size()) * chi_;
    const auto measured = rows_.col(chi_.size()).head(count);
    samples_.insert(samples_.end(), samples.begin(), samples.end());
    predicted_.insert(predicted_.end(), predicted.begin(), predicted.end());
    measured_.insert(measured_.end(), measured.begin(), measured.end());
  }

  [[nodiscard]] const std::vector<Index>& samples() const { return samples_; }
  [[nodiscard]] Vector predicted() const { return vector(predicted_); }
  [[nodiscard]] Vector measured() const { return vector(measured_); }

 private:
  [[nodiscard]] static Vector vector(const std::vector<double>& values) {
    return Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
  }

  Vector chi_;
  std::vector<Index> samples_;
  std::vector<double> predicted_;
  std::vector<double> measured_;
};

// Splits torques of rows [V_static V_still W Y], where V_static are the columns of a robot that rests at the
// positions of the log, and V_still those of one that begins to move there.
class FittedRowsSink final : public detail::BufferedSink {
 public:
  struct Parameters {
    Vector rigid;     // (b), zero where there is friction
    Vector friction;  // (b), zero elsewhere
    Vector all;       // (b)
    Vector a_priori;  // (b)
  };

  FittedRowsSink(const std::vector<Index>& columns, const Parameters& chi)
      : BufferedSink(3 * std::ssize(columns) + 1),
        rigid_(chi.rigid(columns)),
        friction_(chi.friction(columns)),
        all_(chi.all(columns)),
        a_priori_(chi.a_priori(columns)),
        squares_(Vector::Zero(all_.size())) {}

  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    const Index b = all_.size();
    const auto block = [&](Index k) { return rows_.block(0, k * b, count, b); };
    const auto W = block(2);
    Matrix series(count, parts);
    series.col(measured) = rows_.col(3 * b).head(count);
    series.col(predicted) = W * all_;
    series.col(a_priori) = W * a_priori_;
    series.col(gravity) = block(0) * rigid_;
    series.col(inertia) = block(1) * rigid_ - series.col(gravity);
    series.col(coriolis) = W * rigid_ - series.col(gravity) - series.col(inertia);
    series.col(friction) = W * friction_;
    squares_ += W.colwise().squaredNorm().transpose();
    samples_.insert(samples_.end(), samples.begin(), samples.end());
    for (int part = 0; part < parts; ++part) {
      const auto values = series.col(part);
      series_[static_cast<std::size_t>(part)].insert(series_[static_cast<std::size_t>(part)].end(),
                                                     values.begin(), values.end());
    }
  }

  [[nodiscard]] const std::vector<Index>& samples() const { return samples_; }
  [[nodiscard]] Vector residual() const { return series(measured) - series(predicted); }
  [[nodiscard]] FittedRows rows(const std::vector<Index>& columns, Index b) const {
    FittedRows out{.measured = series(measured),
                   .a_priori = series(a_priori),
                   .gravity = series(gravity),
                   .inertia = series(inertia),
                   .coriolis = series(coriolis),
                   .friction = series(friction),
                   .column_rms = Vector::Zero(b)};
    if (!samples_.empty()) {
      out.column_rms(columns) = (squares_ / static_cast<double>(samples_.size())).cwiseSqrt();
    }
    return out;
  }

 private:
  enum Part { measured, predicted, a_priori, gravity, inertia, coriolis, friction, parts };

  [[nodiscard]] Vector series(Part part) const {
    const std::vector<double>& values = series_[part];
    return Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
  }

  Vector rigid_;
  Vector friction_;
  Vector all_;
  Vector a_priori_;
  Vector squares_;
  std::vector<Index> samples_;
  std::array<std::vector<double>, parts> series_;
};

FittedRowsSink::Parameters split_parameters(const Robot& robot, const Identification& identification) {
  const Vector& chi = identification.answer();
  FittedRowsSink::Parameters out{chi, chi, chi, identification.base.from_standard(robot.chi_st())};
  for (Index i = 0; i < chi.size(); ++i) {
    const BaseParameter& parameter = identification.base.parameters[static_cast<std::size_t>(i)];
    (is_friction(parameter.leading.kind) ? out.rigid : out.friction)[i] = 0.0;
  }
  return out;
}

// Mean position and velocity over `reach` samples to either side, as far as the log goes.
void add_motion(const Vector& q, double f_m, const std::vector<Index>& samples, Index reach,
                FittedRows& out) {
  out.position.resize(std::ssize(samples));
  out.velocity.resize(std::ssize(samples));
  for (Index k = 0; k < out.position.size(); ++k) {
    const Index sample = samples[static_cast<std::size_t>(k)];
    const Index first = std::max<Index>(sample - reach, 0);
    const Index last = std::min(sample + reach, q.size() - 1);
    out.position[k] = q.segment(first, last - first + 1).mean();
    out.velocity[k] = (q[last] - q[first]) * f_m / static_cast<double>(last - first);
  }
}

// The rows of the fit with their parts, joint by joint.
void add_fitted_rows(const Robot& robot, const Identification& identification, const Log& log,
                     detail::RowSource& rows, Index first_sample, Prediction& out) {
  const FittedRowsSink::Parameters chi = split_parameters(robot, identification);
  const detail::JointSinks<FittedRowsSink> sinks(
      rows.joints(), [&](std::size_t j) { return FittedRowsSink(rows.columns(j), chi); });
  const Motion motion = rows.motion();
  std::array<Motion, 2> still = {motion, motion};
  still[0].qd.setZero();
  still[0].qdd.setZero();
  still[1].qd.setZero();
  rows.send(sinks.sinks(), still);
  const Index reach = std::max<Index>(out.row_stride / 2, 1);
  for (std::size_t j = 0; j < rows.joints(); ++j) {
    JointPrediction& joint = out.joints[j];
    joint.residual = sinks[j].residual();
    joint.fitted = sinks[j].rows(rows.columns(j), identification.base.size());
    add_motion(motion.q.col(static_cast<Index>(j)), log.f_m, sinks[j].samples(), reach, joint.fitted);
    for (const Index sample : sinks[j].samples()) {
      joint.rows.push_back(sample - first_sample);
    }
  }
}

detail::JointSinks<PredictionSink> predictions(detail::RowSource& source, const Vector& chi) {
  detail::JointSinks<PredictionSink> out(
      source.joints(), [&](std::size_t j) { return PredictionSink(source.columns(j), chi); });
  source.send(out.sinks());
  return out;
}

}  // namespace

void detail::expect_values(std::string_view who, const Identification& result) {
  const Index b = result.base.size();
  const auto refuse = [&](std::string_view what, Index values) {
    throw InputError(std::string(who) + ": the identification has " + std::to_string(values) + " values " +
                     std::string(what) + "for " + std::to_string(b) +
                     " base parameters; give what identify() returned");
  };
  if (result.chi.size() == 0 || result.chi.size() != b) {
    refuse("", result.chi.size());
  }
  if (result.physical && result.physical->parameters.chi.size() != b) {
    refuse("of physical parameters ", result.physical->parameters.chi.size());
  }
  if (result.essential && result.essential->parameters.chi.size() != b) {
    refuse("of essential parameters ", result.essential->parameters.chi.size());
  }
}

Prediction predict(const Robot& robot, const Identification& identification, const Log& log) {
  detail::expect_values("predict", identification);
  const SignalOptions& fitted = identification.estimation.signal;
  SignalOptions plain = fitted;
  plain.decimation.clear();
  detail::ThreadTeam alone(1);
  detail::RowSource every(robot, identification.base, log, plain, alone);
  every.leave_nothing_out();
  detail::RowSource rows(robot, identification.base, log, fitted, alone);

  Prediction out;
  out.source = log.source;
  out.f_m = log.f_m;
  out.start = log.t[every.first_sample()];
  out.row_stride = detail::stride_of(fitted);
  const detail::JointSinks<PredictionSink> series = predictions(every, identification.answer());
  for (std::size_t j = 0; j < every.joints(); ++j) {
    JointPrediction& joint = out.joints.emplace_back();
    joint.measured = series[j].measured();
    joint.predicted = series[j].predicted();
    for (const Index sample : series[j].samples()) {
      joint.kept.push_back(every.kept(static_cast<Index>(j), sample) ? 1 : 0);
    }
  }
  add_fitted_rows(robot, identification, log, rows, every.first_sample(), out);
  return out;
}

DynamicModel identified_model(const Robot& robot, const Identification& result,
                              const IdentifiedModelOptions& options) {
  constexpr std::string_view who = "identified_model";
  detail::expect_identified(who, name(result.status), result.reasons, options);
  if (detail::chosen_set(who, result.physical.has_value(), options) == ParameterSet::estimate) {
    return {robot, result.base, result.chi};
  }
  detail::accept("identified_model", result.base.complaint(robot));
  return {robot, result.physical->parameters.chi_st};
}

}  // namespace rivid
