#include "report/excitation_charts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "excite/clearance.hpp"
#include "identify/figures/joint_rows.hpp"
#include "report/documents.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Points of a curve that a picture of a panel's width can show.
constexpr Index most_points_of_a_motion = 500;

// When these samples are.
Vector instants(const std::vector<Index>& samples, double f_m) {
  Vector out(std::ssize(samples));
  std::ranges::transform(samples, out.begin(), [&](Index k) { return static_cast<double>(k) / f_m; });
  return out;
}

struct QuantityOfMotion {
  std::string name;
  std::string symbol;
  std::string revolute_unit;
  std::string prismatic_unit;
  const Matrix* values;
  Vector lower;
  Vector upper;
};

std::vector<QuantityOfMotion> quantities(const ForecastMotion& of) {
  const MotionBounds bounds = motion_bounds(of.plan.experiment.robot, of.plan.options.limits);
  std::vector<QuantityOfMotion> out = {
      {"position", "q", "rad", "m", &of.motion.q, bounds.lower, bounds.upper},
      {"velocity", "q̇", "rad/s", "m/s", &of.motion.qd, -bounds.velocity, bounds.velocity},
      {"acceleration", "q̈", "rad/s²", "m/s²", &of.motion.qdd, -bounds.acceleration, bounds.acceleration}};
  if (of.forecast.tau.size() > 0) {
    out.push_back({"torque", "τ", "N·m", "N", &of.forecast.tau, -bounds.torque, bounds.torque});
  }
  return out;
}

// Limits are drawn where the motion comes near them; far away they would leave no room for the curve.
Chart motion_chart(const ForecastMotion& of, const QuantityOfMotion& quantity, Index j) {
  constexpr double near = 0.5;  // of a limit; a choice
  const Joint& joint = of.plan.experiment.robot.joints[static_cast<std::size_t>(j)];
  const std::vector<Index> some = every_few(of.motion.samples(), most_points_of_a_motion);
  const Vector values = (*quantity.values)(some, j);
  const bool turns = joint.type == JointType::revolute;
  Chart out =
      time_chart(quantity.name + "-" + std::to_string(j + 1), joint.name,
                 "The " + quantity.name + " of " + joint.name + " over time",
                 quantity.symbol + " [" + (turns ? quantity.revolute_unit : quantity.prismatic_unit) + "]",
                 {{quantity.symbol, "measured", Series::Kind::line, instants(some, of.forecast.f_m), values}},
                 Chart::Size::panel);
  out.height = 190.0;
  const double middle = 0.5 * (quantity.lower[j] + quantity.upper[j]);
  for (const double limit : {quantity.lower[j], quantity.upper[j]}) {
    const double nearest = limit > middle ? values.maxCoeff() : values.minCoeff();
    if (std::isfinite(limit) && (nearest - middle) / (limit - middle) >= near) {
      out.rules.push_back({false, limit, "bound"});
      out.y_shown.push_back(limit);
    }
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- at a glance

const LimitUse* tightest(const Forecast& forecast, const std::string& joint) {
  const LimitUse* out = nullptr;
  for (const LimitUse& use : forecast.limits) {
    if (use.joint == joint && (out == nullptr || use.share > out->share)) {
      out = &use;
    }
  }
  return out;
}

Stack bar_of(double share, const std::string& label) {
  return {{{"fit", std::clamp(share, 0.0, 1.0)}}, label};
}

Table joints_at_a_glance(const Forecast& forecast) {
  using J = JointInformation;
  double most = 0.0;
  for (const J& joint : forecast.joints) {
    most = std::isfinite(joint.share) ? std::max(most, joint.share) : most;
  }
  return table_of(forecast.joints,
                  {{{"joint", format::name}, &J::joint},
                   {{"information", format::percents(1)}, &J::share},
                   {{"", format::stack},
                    [=](const J& j) -> Cell {
                      return std::isfinite(j.share) && most > 0.0
                                 ? Cell(bar_of(j.share / most, "information " + percent(j.share)))
                                 : Cell("");
                    }},
                   {{"largest use"},
                    [&](const J& j) {
                      const LimitUse* const use = tightest(forecast, j.joint);
                      return use == nullptr ? std::string("none")
                                            : use->quantity + " " + fixed(100.0 * use->share, 1) + " %";
                    }},
                   {{"", format::stack}, [&](const J& j) -> Cell {
                      const LimitUse* const use = tightest(forecast, j.joint);
                      return use == nullptr
                                 ? Cell("")
                                 : Cell(bar_of(use->share, use->quantity + " " + percent(use->share)));
                    }}});
}

// ---------------------------------------------------------------------------------------------- in space

// The edges of a box in one stroke.
Skeleton::Trace outline(const Box& box) {
  constexpr std::array<std::array<int, 3>, 8> corners = {
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  // numbers of corners, edges twice where need be
  constexpr std::array<std::size_t, 16> stroke = {0, 1, 2, 3, 0, 4, 5, 1, 5, 6, 2, 6, 7, 3, 7, 4};
  Skeleton::Trace out{box.name, "obstacle", {}};
  for (const std::size_t corner : stroke) {
    Eigen::Vector3d point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Index>(axis);
      point[a] = corners[corner][axis] == 0 ? box.min[a] : box.max[a];
    }
    out.points.push_back(point);
  }
  return out;
}

// A square of the plane below or beside the robot.
Skeleton::Trace outline(const HalfSpace& space, double reach) {
  const Eigen::Vector3d normal = space.normal.normalized();
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  const Eigen::Vector3d middle = space.offset * normal;
  Skeleton::Trace out{space.name, "obstacle", {}};
  for (const auto& [a, b] : {std::pair{1.0, 1.0}, {-1.0, 1.0}, {-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}}) {
    out.points.emplace_back(middle + reach * (a * u + b * v));
  }
  return out;
}

Skeleton motion_in_space(const ForecastMotion& of) {
  constexpr Index poses = 6;                       // along the motion that are drawn; a choice
  constexpr Index most_poses_to_go_through = 150;  // of the slider; a choice that bounds the page
  const Robot& robot = of.plan.experiment.robot;
  Skeleton out = skeleton_of(robot, of.motion.q.row(0));
  out.id = "motion-in-space";
  out.title = "Path of the last joint";
  out.label = "The robot at the beginning of the motion, the path of its last joint, and the obstacles";
  Skeleton::Trace path{"last joint", "path-of-tool", {}};
  double reach = 0.0;
  for (const Index k : every_few(of.motion.samples(), most_points_of_a_motion)) {
    path.points.push_back(skeleton_of(robot, of.motion.q.row(k)).joints.back());
    reach = std::max(reach, path.points.back().norm());
  }
  for (Index pose = 1; pose < poses; ++pose) {
    const Index k = of.motion.samples() * pose / poses;
    out.traces.push_back({"pose at " + number(static_cast<double>(k) / of.forecast.f_m, 3) + " s", "pose",
                          skeleton_of(robot, of.motion.q.row(k)).joints});
  }
  out.traces.push_back(std::move(path));
  for (const Index k : every_few(of.motion.samples(), most_poses_to_go_through)) {
    out.poses.push_back(
        {static_cast<double>(k) / of.forecast.f_m, skeleton_of(robot, of.motion.q.row(k)).joints});
  }
  const Space& space = of.plan.options.space;
  for (const Box& box : space.boxes) {
    out.traces.push_back(outline(box));
  }
  for (const HalfSpace& half : space.half_spaces) {
    out.traces.push_back(outline(half, 0.7 * reach));
  }
  return out;
}

}  // namespace

std::vector<Block> motion_at_a_glance(const ForecastMotion& of) {
  const Space& space = of.plan.options.space;
  std::vector<std::pair<std::string, std::string>> keys = {
      {"arm", "arm at both ends"}, {"pose", "between"}, {"predicted", "path of the last joint"}};
  if (!space.boxes.empty() || !space.half_spaces.empty()) {
    keys.emplace_back("obstacle", "obstacles");
  }
  return {{joints_at_a_glance(of.forecast)},
          plots_block("hero", {motion_in_space(of)}),
          {Legend{std::move(keys), "Drag, or use the arrow keys, to turn the robot."}}};
}

Block clearances_over_time(const ForecastMotion& of) {
  constexpr std::size_t most_pairs = 8;  // of bodies, a curve each; a choice
  const std::vector<ClearanceUse>& nearest = of.forecast.clearances;
  const std::vector<Index> some = every_few(of.motion.samples(), most_points_of_a_motion);
  const auto shown = std::min<std::size_t>(
      most_pairs, static_cast<std::size_t>(std::ranges::count_if(
                      nearest, [](const ClearanceUse& use) { return std::isfinite(use.wanted); })));
  Matrix distances(std::ssize(some), static_cast<Index>(shown));
  for (Index row = 0; row < distances.rows(); ++row) {
    const Index k = some[static_cast<std::size_t>(row)];
    const std::vector<ClearanceUse> all =
        checked_clearances(of.plan.experiment.robot, of.plan.options.space,
                           std::vector<bool>(nearest.size(), true), of.motion.q.row(k), of.forecast.f_m);
    for (std::size_t pair = 0; pair < shown; ++pair) {
      const auto same = [&](const ClearanceUse& use) {
        return use.first == nearest[pair].first && use.second == nearest[pair].second;
      };
      distances(row, static_cast<Index>(pair)) = std::ranges::find_if(all, same)->distance;
    }
  }
  std::vector<std::string> names;
  for (std::size_t pair = 0; pair < shown; ++pair) {
    names.push_back(nearest[pair].first + " from " + nearest[pair].second);
  }
  Chart chart =
      time_chart("clearances-over-time", "Distances over time", "Distances of the nearest pairs over time",
                 "distance [m]", curves(instants(some, of.forecast.f_m), names, distances));
  chart.rules.push_back({false, of.plan.options.space.clearance, "bound"});
  chart.y_shown = {0.0, of.plan.options.space.clearance};
  return plots_block("", {std::move(chart)});
}

Section motion_section(const ForecastMotion& of) {
  Section out{"motion", "Motion", "Motion", {}, Shown::page};
  Plots plots{.layout = "panels"};
  for (const QuantityOfMotion& quantity : quantities(of)) {
    Plots::Group& group = plots.groups.emplace_back(
        Plots::Group{quantity.symbol + ", " + quantity.name, "dashed: limits that the motion comes near"});
    for (Index j = 0; j < of.motion.joints(); ++j) {
      group.plots.emplace_back(motion_chart(of, quantity, j));
    }
  }
  out.blocks.push_back({std::move(plots)});
  return out;
}

Section information_section(const ForecastMotion& of) {
  constexpr Index most_stretches = 150;  // of time, a column each; a choice
  Section out{"information", "Information", "Information by joint and time", {}, Shown::page};
  const Matrix& leverage = of.forecast.leverage;
  if (leverage.size() == 0) {
    out.blocks.push_back(
        {Sentence{"The motion does not determine all parameters, so that the information of its rows has no "
                  "common measure"}});
    return out;
  }
  const Index stretches = std::min(most_stretches, leverage.rows());
  Vector time(stretches);
  Matrix rate(stretches, leverage.cols());
  for (Index s = 0; s < stretches; ++s) {
    const Index first = leverage.rows() * s / stretches;
    const Index size = leverage.rows() * (s + 1) / stretches - first;
    time[s] = (static_cast<double>(first) + 0.5 * static_cast<double>(size)) / of.forecast.f_m;
    rate.row(s) = leverage.middleRows(first, size).colwise().mean() * of.forecast.f_m;
  }
  std::vector<std::string> names;
  std::ranges::transform(of.forecast.joints, std::back_inserter(names), &JointInformation::joint);
  out.blocks = {
      {Sentence{"The leverage w M⁻¹ wᵀ / σ² of a row is its weight in the estimate. Its sum over all rows is "
                "the number of parameters, less prior information"}},
      plots_block("", {time_chart("information-over-time", "Parameters a second",
                                  "Information of each joint's rows over time", "leverage [1/s]",
                                  curves(time, names, rate))})};
  return out;
}

}  // namespace rivid::detail
