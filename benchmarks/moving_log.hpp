#pragma once

#include <algorithm>
#include <cstdint>
#include <random>

#include "rivid/data/log.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid::benchmarks {

/// Smooth motion of all joints, torques of a model with all parameters one, and noise.
inline Log moving_log(const Robot& robot, Index n_m, std::uint64_t seed = 20261121) {
  Log log;
  log.source = "moving";
  log.f_m = 1000.0;
  log.t = Vector::LinSpaced(n_m, 0.0, static_cast<double>(n_m - 1) / log.f_m);
  log.q.resize(n_m, robot.size());
  log.tau.resize(n_m, robot.size());
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  for (Index j = 0; j < robot.size(); ++j) {
    log.q.col(j).setZero();
    for (int harmonic = 0; harmonic < 4; ++harmonic) {
      const double omega = 1.0 + 4.0 * uniform(random);
      const double phase = 6.0 * uniform(random);
      log.q.col(j).array() += 0.5 * (omega * log.t.array() + phase).sin();
    }
  }
  const BaseParameters base = base_parameters(robot);
  const RegressorBatch batch(robot, base.columns());
  RegressorBlock block(batch);
  const Motion motion = differentiate(log.q, log.f_m);
  for (Index first = 0; first < n_m; first += block.capacity()) {
    const Index count = std::min(block.capacity(), n_m - first);
    batch.fill(motion, first, count, block);
    for (Index j = 0; j < robot.size(); ++j) {
      const auto W = block.W(static_cast<std::size_t>(j));
      log.tau.col(j).segment(first, count) =
          W.rowwise().sum() + 0.1 * Vector::NullaryExpr(count, [&] { return normal(random); });
    }
  }
  return log;
}

}  // namespace rivid::benchmarks
