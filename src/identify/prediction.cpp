#include "rivid/identify/prediction.hpp"

#include <functional>
#include <numeric>

#include "identify/row_source.hpp"

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

std::vector<PredictionSink> predictions(detail::RowSource& source, const Vector& chi) {
  std::vector<PredictionSink> out;
  out.reserve(source.joints());
  std::vector<detail::RowSink*> sinks;
  sinks.reserve(source.joints());
  for (std::size_t j = 0; j < source.joints(); ++j) {
    sinks.push_back(&out.emplace_back(source.columns(j), chi));
  }
  source.send(sinks);
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
  out.row_stride =
      std::accumulate(fitted.decimation.begin(), fitted.decimation.end(), Index{1}, std::multiplies<>());
  const std::vector<PredictionSink> series = predictions(every, identification.chi);
  const std::vector<PredictionSink> fit = predictions(rows, identification.chi);
  for (std::size_t j = 0; j < series.size(); ++j) {
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

}  // namespace rivid
