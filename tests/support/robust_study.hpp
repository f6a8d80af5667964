#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "rivid/identify/identification.hpp"
#include "support/normal.hpp"
#include "support/scara_study.hpp"

namespace rivid::test {

inline SignalOptions plain_rows() { return {.rows = RowScheme::paper}; }

inline Robust robust(RobustKind kind) { return {.kind = kind}; }

/// Motions of sines, and torques that the model explains but for `error`, (n_m × n).
struct SineExperiment {
  static constexpr Index samples = 404;

  Robot robot;
  BaseParameters base;
  Log log;
  Vector truth;

  explicit SineExperiment(Robot its_robot) : robot(std::move(its_robot)), base(base_parameters(robot)) {
    const Index n = robot.size();
    log.source = "sines";
    log.f_m = 100.0;
    log.t = Vector::NullaryExpr(samples, [&](Index k) { return static_cast<double>(k) / log.f_m; });
    log.q = Matrix::NullaryExpr(samples, n, [](Index k, Index j) {
      const auto t = static_cast<double>(k);
      const auto joint = static_cast<double>(j);
      return 0.6 * std::sin((0.047 + 0.011 * joint) * t) +
             0.2 * std::sin((0.19 - 0.03 * joint) * t + 0.4 + joint);
    });
    log.tau = Matrix::Ones(samples, n);
    truth = Vector::LinSpaced(base.size(), 1.0, 2.0);
    const Rows rows = rivid::rows(robot, base, log, plain_rows());
    for (Index j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const JointRows& joint = rows.W.joints[at];
      log.tau.col(j)(rows.samples[at]) = joint.W * truth(joint.columns);
    }
    clean_ = log.tau;
  }

  void disturb(const Matrix& error) { log.tau = clean_ + error; }

 private:
  Matrix clean_;
};

/// Normal errors with `sigma` of each joint, of which a part is so many times larger.
inline Matrix errors(std::uint64_t seed, const Vector& sigma, double part, double factor) {
  std::mt19937_64 random(seed);
  Normal normal;
  std::bernoulli_distribution outlier(part);
  return Matrix::NullaryExpr(SineExperiment::samples, sigma.size(), [&](Index, Index j) {
    const double size = outlier(random) ? factor : 1.0;
    return size * sigma[j] * normal(random);
  });
}

/// IDIM-IV with the SCARA of [RIV], whose torques are logged with spikes that its controller knew nothing of.
struct RobustScara : public ScaraStudy {
  RobustScara() { encoder_noise = 2e-5; }

  [[nodiscard]] Estimation method(std::optional<Robust> options) const {
    Estimation out = iv();
    out.signal = {.rows = RowScheme::exact, .torque_held = true, .decimation = {4}};
    out.robust = options;
    return out;
  }
};

}  // namespace rivid::test
