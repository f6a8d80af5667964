#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "report/documents.hpp"

namespace rivid::detail {

namespace {

using Json = nlohmann::ordered_json;

// Values as single precision in base64, low byte first.
std::string encoded(const Vector& values, Index stride) {
  std::string bytes;
  for (Index k = 0; k < values.size(); k += stride) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(values[k]));
    for (const int shift : {0, 8, 16, 24}) {
      bytes += static_cast<char>((bits >> shift) & 0xffU);
    }
  }
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t i) {
      return i < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) : 0U;
    };
    const std::uint32_t group = (byte(k) << 16U) | (byte(k + 1) << 8U) | byte(k + 2);
    out += digits[group >> 18U];
    out += digits[(group >> 12U) & 63U];
    out += k + 1 < bytes.size() ? digits[(group >> 6U) & 63U] : '=';
    out += k + 2 < bytes.size() ? digits[group & 63U] : '=';
  }
  return out;
}

// Stretches that are left out: first sample and number, alternating.
std::vector<Index> left_out(const std::vector<std::uint8_t>& kept, Index stride) {
  std::vector<Index> out;
  bool open = false;
  const auto size = static_cast<Index>(kept.size());
  for (Index k = 0, at = 0; k < size; k += stride, ++at) {
    const bool missing = kept[static_cast<std::size_t>(k)] == 0;
    if (missing && !open) {
      out.insert(out.end(), {at, 0});
    }
    if (missing) {
      ++out.back();
    }
    open = missing;
  }
  return out;
}

// Runs of rows that lie evenly: first sample and number, alternating. Of rows that are thinned every few are left.
std::vector<Index> runs_of(const std::vector<Index>& rows, Index thin, Index step) {
  std::vector<Index> out;
  Index expected = -1;
  for (std::size_t k = 0; k < rows.size(); k += static_cast<std::size_t>(thin)) {
    if (rows[k] != expected) {
      out.insert(out.end(), {rows[k], 0});
    }
    ++out.back();
    expected = rows[k] + step;
  }
  return out;
}

// Torques of all samples; the residual of the rows of the fit, which may be fewer.
Json joint_data(const Prediction& log, const JointPrediction& joint, Index stride, bool with_predicted) {
  Json out = {{"measured", encoded(joint.measured, stride)},
              {"predicted", nullptr},
              {"left_out", left_out(joint.kept, stride)}};
  if (with_predicted) {
    // Rows that are as dense as the samples are thinned like these.
    const Index thin = (stride + log.row_stride - 1) / log.row_stride;
    const Index step = thin * log.row_stride;
    out["predicted"] = encoded(joint.predicted, stride);
    out["rows"] = {{"step", static_cast<double>(step) / log.f_m},
                   {"per_sample", 1.0 / log.f_m},
                   {"runs", runs_of(joint.rows, thin, step)},
                   {"residual", encoded(joint.residual, thin)}};
  }
  return out;
}

Json log_data(const Prediction& log, Index stride, bool with_predicted) {
  Json joints = Json::array();
  for (const JointPrediction& joint : log.joints) {
    joints.push_back(joint_data(log, joint, stride, with_predicted));
  }
  return {{"start", log.start},
          {"step", static_cast<double>(stride) / log.f_m},
          {"samples", (log.samples() + stride - 1) / stride},
          {"joints", std::move(joints)}};
}

// Rows in each bin if the residual were normal.
std::vector<double> normal_counts(const ResidualShape& shape) {
  std::vector<double> out;
  for (std::size_t k = 0; k < shape.counts.size(); ++k) {
    const double z =
        (shape.first_edge + (static_cast<double>(k) + 0.5) * shape.bin - shape.mean) / shape.sigma;
    out.push_back(static_cast<double>(shape.rows) * shape.bin /
                  (shape.sigma * std::sqrt(2.0 * std::numbers::pi)) * std::exp(-0.5 * z * z));
  }
  return out;
}

Json residual_data(const ResidualShape& shape) {
  constexpr double quantile_975 = 1.96;
  return {{"first_edge", shape.first_edge},
          {"bin", shape.bin},
          {"counts", shape.counts},
          {"normal", normal_counts(shape)},
          {"autocorrelation", shape.autocorrelation},
          {"white_noise", shape.rows > 0 ? quantile_975 / std::sqrt(static_cast<double>(shape.rows)) : 0.0}};
}

// A quantity of each iterate in per cent, one list a joint.
template <typename Of>
Json by_joint(const std::vector<IvIteration>& iterations, Index n, const Of& of) {
  Json out = Json::array();
  for (Index j = 0; j < n; ++j) {
    Json series = Json::array();
    for (const IvIteration& i : iterations) {
      const Vector values = of(i);
      series.push_back(j < values.size() ? Json(100.0 * values[j]) : Json());
    }
    out.push_back(std::move(series));
  }
  return out;
}

Json motion_data(const std::vector<IvIteration>& iterations, Index n, MotionError IvIteration::* what) {
  constexpr std::array<Vector MotionError::*, 3> orders = {&MotionError::q, &MotionError::qd,
                                                           &MotionError::qdd};
  Json out = Json::array();
  for (Vector MotionError::* const order : orders) {
    out.push_back(
        by_joint(iterations, n, [&](const IvIteration& i) -> const Vector& { return (i.*what).*order; }));
  }
  return out;
}

// Errors of torques and motions in per cent; of a joint's torques the share in the norm of all.
Json iteration_data(const std::vector<IvIteration>& iterations, Index n) {
  Json total = Json::array();
  for (const IvIteration& i : iterations) {
    total.push_back(100.0 * i.relative_error);
  }
  return {{"error", std::move(total)},
          {"joint_error", by_joint(iterations, n,
                                   [](const IvIteration& i) -> Vector {
                                     return i.joint_error_norm * (i.relative_error / i.error_norm);
                                   })},
          {"to_measured", motion_data(iterations, n, &IvIteration::to_measured)},
          {"to_reference", motion_data(iterations, n, &IvIteration::to_reference)}};
}

using Logs = std::vector<const Prediction*>;

// Over five deviations to either side, or as far as the residual goes.
void fill_histogram(const Logs& logs, std::size_t joint, ResidualShape& out) {
  constexpr int bins = 40;
  constexpr double reach = 5.0;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const Prediction* const log : logs) {
    const Vector& residual = log->joints[joint].residual;
    if (residual.size() > 0) {
      least = std::min(least, residual.minCoeff());
      most = std::max(most, residual.maxCoeff());
    }
  }
  least = std::max(least, out.mean - reach * out.sigma);
  most = std::min(most, out.mean + reach * out.sigma);
  out.first_edge = least;
  out.bin = (most - least) / bins;
  out.counts.assign(bins, 0.0);
  for (const Prediction* const log : logs) {
    for (const double r : log->joints[joint].residual) {
      if (r < least || r > most) {
        ++out.outside;
      } else {
        ++out.counts[std::min<std::size_t>(static_cast<std::size_t>((r - least) / out.bin), bins - 1)];
      }
    }
  }
}

// Of rows that lie whole strides apart; pairs with a gap between them count for the lag that they have.
void add_products(const Prediction& log, const JointPrediction& joint, double mean, Index lags,
                  std::vector<double>& products) {
  const std::vector<Index>& rows = joint.rows;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (std::size_t other = k + 1; other < rows.size(); ++other) {
      const Index apart = rows[other] - rows[k];
      if (apart > lags * log.row_stride) {
        break;
      }
      if (apart % log.row_stride == 0) {
        products[static_cast<std::size_t>(apart / log.row_stride) - 1] +=
            (joint.residual[static_cast<Index>(k)] - mean) *
            (joint.residual[static_cast<Index>(other)] - mean);
      }
    }
  }
}

}  // namespace

Index thinning(std::span<const Prediction> predictions) {
  constexpr Index most_samples = 2'000'000;
  Index samples = 0;
  for (const Prediction& log : predictions) {
    samples += log.samples() * static_cast<Index>(log.joints.size());
  }
  return std::max<Index>((samples + most_samples - 1) / most_samples, 1);
}

ResidualShape residual_shape(std::span<const Prediction> predictions, std::size_t joint) {
  constexpr Index fewest_rows = 8;
  constexpr Index most_lags = 60;
  Logs logs;
  ResidualShape out;
  double sum = 0.0;
  for (const Prediction& log : predictions) {
    if (!log.validation) {
      logs.push_back(&log);
      out.rows += log.joints[joint].residual.size();
      sum += log.joints[joint].residual.sum();
    }
  }
  if (out.rows < fewest_rows) {
    return out;
  }
  out.mean = sum / static_cast<double>(out.rows);
  double squares = 0.0;
  for (const Prediction* const log : logs) {
    squares += (log->joints[joint].residual.array() - out.mean).square().sum();
  }
  out.sigma = std::sqrt(squares / static_cast<double>(out.rows));
  if (!(out.sigma > 0.0)) {
    return out;
  }
  fill_histogram(logs, joint, out);
  const Index lags = std::min(most_lags, out.rows / 4);
  out.autocorrelation.assign(static_cast<std::size_t>(lags), 0.0);
  for (const Prediction* const log : logs) {
    add_products(*log, log->joints[joint], out.mean, lags, out.autocorrelation);
  }
  for (double& product : out.autocorrelation) {
    product /= squares;
  }
  return out;
}

std::string plot_data(const Identification& result, std::span<const Prediction> predictions) {
  const Index stride = thinning(predictions);
  const bool with_predicted = predicted(result);
  const std::size_t n = result.fit.joints.size();
  Json joints = Json::array();
  for (const JointFit& joint : result.fit.joints) {
    joints.push_back({{"name", joint.name}, {"unit", joint.unit}});
  }
  Json logs = Json::array();
  for (const Prediction& log : predictions) {
    logs.push_back(log_data(log, stride, with_predicted));
  }
  Json residuals = Json::array();
  for (std::size_t j = 0; with_predicted && j < n; ++j) {
    residuals.push_back(residual_data(residual_shape(predictions, j)));
  }
  Json out = {{"joints", std::move(joints)}, {"logs", std::move(logs)}, {"residuals", std::move(residuals)}};
  if (result.iv) {
    out["iterations"] = iteration_data(result.iv->iterations, static_cast<Index>(n));
  }
  // Nothing in it may end the <script>.
  std::string text = out.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

}  // namespace rivid::detail
