#include "experiment/target_gains.hpp"

#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "experiment/recognised_columns.hpp"
#include "experiment/sections.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Slower samples say little of the sign of the friction [rad/s | m/s].
constexpr double slow = 0.05;
constexpr Index fewest_samples = 50;
// Blocks of time of each log, between which errors count as independent.
constexpr Index blocks_of_log = 10;
// Currents that the torques explain no better than that are of something else.
constexpr double most_left = 0.2;
// Part of the squared torque that friction may explain before nothing is left but rounding.
constexpr double least_part = 1e-9;
// Wider intervals, in parts of the gain, say nothing.
constexpr double widest_interval = 0.1;

std::vector<Column> columns_named(const std::vector<std::string>& names, double scale) {
  std::vector<Column> out;
  for (const std::string& name : names) {
    out.push_back({name, scale});
  }
  return out;
}

// The same file with targets in place of torques and control signals; nothing where it has none.
std::optional<LogSource> with_targets(const LogSource& source, const std::filesystem::path& file,
                                      const Robot& robot) {
  const std::vector<std::string> names = column_names(file, source.columns.table);
  const RecognisedLog found = recognised_log(names, joint_names(robot));
  if (found.target_current.columns.empty() || found.target_torque.columns.empty()) {
    return std::nullopt;
  }
  LogSource out;
  out.files = {file};
  out.side = source.side;
  out.irregular = source.irregular;
  out.resample = source.resample;
  out.columns = source.columns;
  out.columns.velocity.clear();
  out.columns.reference.clear();
  out.columns.reference_velocity.clear();
  out.columns.torque =
      columns_named(found.target_torque.columns, unit_scale(found.target_torque.unit.value_or("1")));
  out.columns.control = columns_named(found.target_current.columns, 1.0);
  for (std::size_t j = 0; j < source.columns.control.size(); ++j) {
    out.columns.control[j].scale = std::abs(source.columns.control[j].scale);
  }
  out.columns.default_names = source.columns.position.empty();
  return out;
}

// Current and torque of one motor without what friction explains of them, and their sums by blocks of time.
struct TargetSums {
  struct Block {
    double torque = 0.0;  // Σ τ²
    double both = 0.0;    // Σ τ i
  };
  std::vector<Block> blocks;
  Index samples = 0;
  double all_torque = 0.0;      // Σ τ² with friction
  double all_current = 0.0;     // Σ i² with friction
  double current_beside = 0.0;  // Σ i² without it

  void add(const Eigen::Ref<const Vector>& current, const Eigen::Ref<const Vector>& torque,
           const Eigen::Ref<const Vector>& velocity, double slowest);
  [[nodiscard]] TargetGain gain() const;
};

void TargetSums::add(const Eigen::Ref<const Vector>& current, const Eigen::Ref<const Vector>& torque,
                     const Eigen::Ref<const Vector>& velocity, double slowest) {
  std::vector<Index> moving;
  for (Index k = 0; k < velocity.size(); ++k) {
    if (std::abs(velocity[k]) > slowest) {
      moving.push_back(k);
    }
  }
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
  double scores = 0.0;
  for (const Block& block : blocks) {
    scores += std::pow(block.both - g * block.torque, 2.0);
  }
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

// A log with targets in place of torques and control signals.
void add_log(const Log& log, const Robot& robot, std::vector<TargetSums>& sums) {
  const Matrix R = robot.gears();
  const Matrix torque = log.tau * inverse(R);
  const Matrix velocity = central_difference(log.q, log.f_m) * R.transpose();
  for (Index j = 0; j < R.rows(); ++j) {
    sums[static_cast<std::size_t>(j)].add(log.v_tau.col(j), torque.col(j), velocity.col(j),
                                          slow * R.row(j).cwiseAbs().sum());
  }
}

}  // namespace

bool TargetGains::any() const {
  return std::ranges::any_of(motors, [](const TargetGain& gain) { return gain.missing.empty(); });
}

std::string TargetGains::text(const Robot& robot) const {
  std::string values;
  std::string widths;
  std::string missing;
  for (std::size_t j = 0; j < motors.size(); ++j) {
    const TargetGain& gain = motors[j];
    values += j == 0 ? "" : ", ";
    values += gain.missing.empty() ? number(gain.value, 4) : "?";
    if (gain.missing.empty()) {
      widths += (widths.empty() ? "" : ", ") + number(100.0 * gain.half_width / std::abs(gain.value), 2);
    } else {
      missing += "; " + robot.joints[j].name + ": " + gain.missing;
    }
  }
  return "drive_gain = [" + values + "] by the target currents and torques of " +
         (logs.size() == 1 ? logs.front() : counted(std::ssize(logs), "log")) +
         (widths.empty() ? "" : ", 95 % intervals ± " + widths + " %") + missing;
}

std::optional<TargetGains> target_gains(std::span<const LogSource> sources, const Robot& robot) {
  TargetGains out;
  std::vector<TargetSums> sums(robot.joints.size());
  for (const LogSource& source : sources) {
    for (const std::filesystem::path& file : source.files) {
      try {
        if (const std::optional<LogSource> targets = with_targets(source, file, robot)) {
          for (const Log& log : read_logs(*targets, robot)) {
            add_log(log, robot, sums);
          }
          out.logs.push_back(file.filename().string());
        }
      } catch (const InputError& e) {
        // Nothing else needs these columns.
        out.doubts.emplace_back(e.what());
      }
    }
  }
  if (out.logs.empty() && out.doubts.empty()) {
    return std::nullopt;
  }
  for (std::size_t j = 0; j < sums.size(); ++j) {
    TargetGain& gain = out.motors.emplace_back(sums[j].gain());
    gain.value = std::copysign(gain.value, robot.joints[j].drive_gain);
  }
  return out;
}

}  // namespace rivid::detail
