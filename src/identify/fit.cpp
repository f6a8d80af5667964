#include "identify/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

void merge(std::vector<RowGroup>& into, std::vector<RowGroup> groups) {
  if (into.empty()) {
    into = std::move(groups);
    return;
  }
  for (std::size_t g = 0; g < into.size(); ++g) {
    into[g].qr.merge(groups[g].qr);
  }
}

double relative(double part, double whole) {
  return whole > 0.0 ? part / whole : std::numeric_limits<double>::quiet_NaN();
}

std::string joined(const BaseParameters& base, const std::vector<Index>& set) {
  std::string out;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 == set.size() ? " and " : ", ";
    out += separator + base.parameters[static_cast<std::size_t>(set[i])].name;
  }
  return out;
}

}  // namespace

void add_factors(RowFactors& into, RowFactors part) {
  merge(into.groups, std::move(part.groups));
  merge(into.undecimated, std::move(part.undecimated));
  into.left_out.resize(part.left_out.size(), 0);
  for (std::size_t j = 0; j < part.left_out.size(); ++j) {
    into.left_out[j] += part.left_out[j];
  }
  into.thresholds.resize(part.thresholds.size(), 0.0);
  std::ranges::transform(into.thresholds, part.thresholds, into.thresholds.begin(),
                         [](double a, double b) { return std::max(a, b); });
}

RowFactors all_factors(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                       const SignalOptions& signal, int threads, const Progress& progress) {
  RowFactors out;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const auto tell = [&](double fraction) {
      progress(logs[k].source, (static_cast<double>(k) + fraction) / static_cast<double>(logs.size()));
    };
    RowFactors part = factors(robot, base, logs[k], signal, threads,
                              progress ? std::function<void(double)>(tell) : std::function<void(double)>());
    add_factors(out, std::move(part));
  }
  return out;
}

double deviation(const Residual& r, double freedom, Convention convention) {
  const auto rows = static_cast<double>(r.rows);
  if (convention == Convention::matlab) {
    return std::sqrt(std::max(r.norm * r.norm - r.sum * r.sum / rows, 0.0) / std::max(rows - 1.0, 1.0));
  }
  return r.norm / std::sqrt(std::max(freedom, 1.0));
}

Fit judged(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
           Convention convention) {
  Fit fit;
  const std::vector<double> ones(data.groups.size(), 1.0);
  const Residual all = residual(data.groups, chi, ones);
  fit.rows = all.rows;
  fit.error_norm = all.norm;
  fit.relative_error = relative(all.norm, all.y_norm);
  const double freedom_share = 1.0 - static_cast<double>(estimated) / static_cast<double>(all.rows);
  fit.sigma_rho = deviation(all, static_cast<double>(all.rows) * freedom_share, convention);
  double centred = 0.0;
  for (std::size_t j = 0; j < data.groups.size(); ++j) {
    const StreamingQr& qr = data.groups[j].qr;
    const Residual r = residual(std::span(&data.groups[j], 1), chi, std::span(ones.data(), 1));
    const auto rows = static_cast<double>(r.rows);
    // A joint that stands still has no row.
    const double mean_square = r.rows > 0 ? qr.y_sum() * qr.y_sum() / rows : 0.0;
    const double y_centred = std::sqrt(std::max(r.y_norm * r.y_norm - mean_square, 0.0));
    centred = std::hypot(centred, y_centred);
    fit.joints.push_back({.name = robot.joints[j].name,
                          .unit = robot.joints[j].type == JointType::revolute ? "N·m" : "N",
                          .rows = r.rows,
                          .left_out = data.left_out[j],
                          .velocity_threshold = data.thresholds[j],
                          .relative_error = relative(r.norm, r.y_norm),
                          .centred_relative_error = relative(r.norm, y_centred),
                          .sigma_rho = deviation(r, rows * freedom_share, convention)});
  }
  fit.centred_relative_error = relative(all.norm, centred);
  return fit;
}

void describe_parameters(const Robot& robot, Identification& out) {
  const Vector a_priori = out.base.from_standard(robot.chi_st());
  const double t = out.covariance.quantile_975;
  for (Index i = 0; i < out.base.size(); ++i) {
    const BaseParameter& p = out.base.parameters[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(out.C_chi(i, i));
    const double value = std::isfinite(sigma) ? out.chi[i] : std::numeric_limits<double>::quiet_NaN();
    out.parameters.push_back({.name = p.name,
                              .unit = p.unit,
                              .regrouped = p.regrouped,
                              .value = value,
                              .sigma = sigma,
                              .relative_sigma_percent = 100.0 * sigma / std::abs(value),
                              .interval_95 = {value - t * sigma, value + t * sigma},
                              .a_priori = a_priori[i],
                              .verdict = {},
                              .advice = {}});
  }
}

std::vector<double> joint_weights(const char* who, const Robot& robot, const RowFactors& data) {
  for (std::size_t j = 0; j < data.groups.size(); ++j) {
    if (data.groups[j].qr.rows() > 0 && data.groups[j].qr.y_norm() == 0.0) {
      throw InputError(std::string(who) + ": joint \"" + robot.joints[j].name +
                       "\": its torque is zero in every row, so its rows have no weight; check its column");
    }
  }
  std::vector<double> out = group_sigmas(data.groups);
  std::ranges::transform(out, out.begin(), [](double sigma) { return 1.0 / sigma; });
  return out;
}

void explain_rank(Index rank, const std::vector<std::vector<Index>>& undetermined, const std::string& what,
                  Identification& out) {
  out.status = Status::rank_deficient;
  for (const std::vector<Index>& set : undetermined) {
    out.reasons.push_back("rank " + std::to_string(rank) + " of " + std::to_string(out.base.size()) + ": " +
                          joined(out.base, set) +
                          (set.size() == 1 ? " is not excited by " : " can not be told apart by ") + what);
  }
}

}  // namespace rivid::detail
