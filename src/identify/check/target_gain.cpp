#include "identify/check/target_gain.hpp"

#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "ranges.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr Index fewest_samples = 50;  // while the joint moves: 5 on average for each of blocks_of_log
// Blocks of time of each log, between which errors count as independent.
constexpr Index blocks_of_log = 10;
// Currents that the torques explain no better than that are of something else.
constexpr double most_left = 0.2;
// Part of the squared torque that friction may explain before nothing is left but rounding.
constexpr double least_part = 1e-9;
// Wider intervals, in parts of the gain, say nothing.
constexpr double widest_interval = 0.1;

}  // namespace

void TargetSums::add(const Eigen::Ref<const Vector>& current, const Eigen::Ref<const Vector>& torque,
                     const Eigen::Ref<const Vector>& velocity, double slowest) {
  const std::vector<Index> moving =
      places_where(velocity.size(), [&](Index k) { return std::abs(velocity[k]) > slowest; });
  if (static_cast<Index>(moving.size()) < fewest_samples) {
    return;
  }
  const Vector speed = velocity(moving);
  const Vector direction = speed.cwiseSign();
  Matrix friction(speed.size(), 4);
  friction << speed, speed.cwiseAbs().cwiseSqrt().cwiseProduct(direction), direction,
      Vector::Ones(speed.size());
  // A motion in one direction alone has no sign beside the constant.
  const auto beside_friction = [&](const Vector& x) {
    return Vector(x - friction * minimum_norm_solution(friction, x, 1e-9));
  };
  const Vector i = current(moving);
  const Vector tau = torque(moving);
  const Vector i_left = beside_friction(i);
  const Vector tau_left = beside_friction(tau);
  const std::size_t first = blocks.size();
  blocks.resize(first + blocks_of_log);
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const auto at = static_cast<Index>(k);
    Block& block = blocks[first + static_cast<std::size_t>(moving[k] * blocks_of_log / velocity.size())];
    block.torque += tau_left[at] * tau_left[at];
    block.both += tau_left[at] * i_left[at];
  }
  samples += i.size();
  all_torque += tau.squaredNorm();
  all_current += i.squaredNorm();
  current_beside += i_left.squaredNorm();
}

TargetGain TargetSums::gain() const {
  TargetGain out;
  Block sum;
  for (const Block& block : blocks) {
    sum.torque += block.torque;
    sum.both += block.both;
  }
  if (samples == 0) {
    out.missing = "it hardly moves";
    return out;
  }
  if (!(sum.torque > least_part * all_torque)) {
    out.missing = "its target torque hardly changes";
    return out;
  }
  // i = g τ: least squares, and the scores of the blocks, which sum up to zero.
  const double g = sum.both / sum.torque;
  const double left = std::sqrt(std::max(current_beside - g * sum.both, 0.0) / all_current);
  if (!(left < most_left)) {
    out.missing =
        "its target torque and friction leave " + number(100.0 * left, 2) + " % of its target current";
    return out;
  }
  const double scores =
      sum_of(blocks, [&](const Block& block) { return std::pow(block.both - g * block.torque, 2.0); });
  const auto count = static_cast<double>(blocks.size());
  const double sigma = std::sqrt(scores * count / (count - 1.0)) / sum.torque;
  const double part = student_quantile_975(count - 1.0) * sigma / std::abs(g);
  if (!(part < widest_interval)) {
    out.missing =
        "its target torque changes too little, the interval would be ± " + number(100.0 * part, 2) + " %";
    return out;
  }
  out.value = 1.0 / g;
  out.half_width = part * std::abs(out.value);
  return out;
}

}  // namespace rivid::detail
