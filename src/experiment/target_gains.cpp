#include "experiment/target_gains.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "dense.hpp"
#include "rivid/data/table.hpp"

namespace rivid::detail {

namespace {

constexpr std::array<std::string_view, 5> wanted_currents = {"itarget", "targetcurrent", "targeti",
                                                             "currenttarget", "icmd"};
constexpr std::array<std::string_view, 7> wanted_torques = {
    "tautarget", "targetmoment", "targettau", "targettorque", "momenttarget", "torquetarget", "taucmd"};
// Slower samples say little of the sign of the friction [rad/s | m/s].
constexpr double slow = 0.05;
// Currents that the torques do not explain better than that are of something else.
constexpr double most_error = 0.2;
constexpr Index fewest_samples = 50;

std::string letters_of(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0) {
      out += static_cast<char>(std::tolower(byte));
    }
  }
  return out;
}

// Columns of one quantity, one a joint in the order of the file; empty where their number is another.
std::vector<std::string> columns_of(std::span<const std::string> names,
                                    std::span<const std::string_view> words, Index joints) {
  std::vector<std::string> out;
  for (const std::string& name : names) {
    if (std::ranges::count(words, std::string_view(letters_of(name))) > 0) {
      out.push_back(name);
    }
  }
  return static_cast<Index>(out.size()) == joints ? out : std::vector<std::string>();
}

}  // namespace

std::optional<TargetGains> target_gains(const std::filesystem::path& log, std::span<const std::string> names,
                                        std::span<const std::string> velocity, Index joints) {
  const std::vector<std::string> currents = columns_of(names, wanted_currents, joints);
  const std::vector<std::string> torques = columns_of(names, wanted_torques, joints);
  if (currents.empty() || torques.empty() || static_cast<Index>(velocity.size()) != joints) {
    return std::nullopt;
  }
  TableOptions options;
  options.columns = currents;
  options.columns.insert(options.columns.end(), torques.begin(), torques.end());
  options.columns.insert(options.columns.end(), velocity.begin(), velocity.end());
  const Matrix table = read_table(log, options).values;
  TargetGains out{Vector(joints), 0.0};
  for (Index j = 0; j < joints; ++j) {
    const auto qd = table.col(2 * joints + j);
    std::vector<Index> moving;
    for (Index k = 0; k < qd.size(); ++k) {
      if (std::abs(qd[k]) > slow) {
        moving.push_back(k);
      }
    }
    if (static_cast<Index>(moving.size()) < fewest_samples) {
      return std::nullopt;
    }
    const Vector speed = qd(moving);
    const Vector current = table.col(j)(moving);
    Matrix A(speed.size(), 4);
    A << Vector(table.col(joints + j)(moving)), speed, speed.cwiseSign(), Vector::Ones(speed.size());
    // A joint without any load has no slope.
    const Vector x = minimum_norm_solution(A, current, 1e-9);
    const double error = (current - A * x).norm() / current.norm();
    if (!(x[0] > 0.0) || !(error < most_error)) {
      return std::nullopt;
    }
    out.gains[j] = 1.0 / x[0];
    out.error = std::max(out.error, error);
  }
  return out;
}

}  // namespace rivid::detail
