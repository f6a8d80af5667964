#include "rivid/identify/prediction.hpp"

#include <algorithm>
#include <string>

#include "identify/infer/parameter_set.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

// Makes torques and predictions of the rows that it is given, and forgets the rows.
class PredictionSink final : public detail::RowSink {
 public:
  PredictionSink(const std::vector<Index>& columns, const Vector& chi)
      : chi_(chi(columns)), rows_(detail::RowSource::most_wanted, chi_.size() + 1) {}

  RowsRoom room(Index /*wanted*/) override { return {{rows_.data(), rows_.rows()}, rows_.rows()}; }
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
  Matrix rows_;
  std::vector<Index> samples_;
  std::vector<double> predicted_;
  std::vector<double> measured_;
};

detail::JointSinks<PredictionSink> predictions(detail::RowSource& source, const Vector& chi) {
  detail::JointSinks<PredictionSink> out(source.joints());
  for (std::size_t j = 0; j < source.joints(); ++j) {
    out.add(source.columns(j), chi);
  }
  source.send(out.sinks());
  return out;
}

}  // namespace

Prediction predict(const Robot& robot, const Identification& identification, const Log& log) {
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
  const detail::JointSinks<PredictionSink> series = predictions(every, identification.chi);
  const detail::JointSinks<PredictionSink> fit = predictions(rows, identification.chi);
  for (std::size_t j = 0; j < every.joints(); ++j) {
    JointPrediction& joint = out.joints.emplace_back();
    joint.measured = series[j].measured();
    joint.predicted = series[j].predicted();
    for (const Index sample : series[j].samples()) {
      joint.kept.push_back(every.kept(static_cast<Index>(j), sample) ? 1 : 0);
    }
    for (const Index sample : fit[j].samples()) {
      joint.rows.push_back(sample - every.first_sample());
    }
    joint.residual = fit[j].measured() - fit[j].predicted();
  }
  return out;
}

namespace detail {

void expect_identified(std::string_view who, std::string_view status, std::span<const std::string> reasons,
                       const IdentifiedModelOptions& options) {
  if (status != name(Status::identified) && !options.force) {
    throw InputError(
        std::string(who) + ": the result is " + std::string(status) + ", not identified" +
        (reasons.empty() ? "" : " (" + reasons.front() + ")") +
        "; a controller should not have it. IdentifiedModelOptions::force takes it nevertheless");
  }
}

ParameterSet chosen_set(std::string_view who, bool has_physical, const IdentifiedModelOptions& options) {
  const ParameterSet chosen =
      options.parameters.value_or(has_physical ? ParameterSet::physical : ParameterSet::estimate);
  if (chosen == ParameterSet::physical && !has_physical) {
    throw InputError(
        std::string(who) +
        ": the result has no physically consistent parameters; identify with --physical, or with "
        "physical = true in [method]");
  }
  return chosen;
}

}  // namespace detail

DynamicModel identified_model(const Robot& robot, const Identification& result,
                              const IdentifiedModelOptions& options) {
  constexpr std::string_view who = "identified_model";
  detail::expect_identified(who, name(result.status), result.reasons, options);
  if (detail::chosen_set(who, result.physical.has_value(), options) == ParameterSet::estimate) {
    return {robot, result.base, result.chi};
  }
  const auto same = [](const StandardParameter& a, const StandardParameter& b) {
    return a.kind == b.kind && a.joint == b.joint;
  };
  if (!std::ranges::equal(result.base.standard, robot.standard_parameters(), same)) {
    throw InputError("identified_model: the result is that of another robot than \"" + robot.name +
                     "\", or of other friction laws");
  }
  return {robot, result.physical->parameters.chi_st};
}

}  // namespace rivid
