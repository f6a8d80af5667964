#include "excite/checked_clearances.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "rivid/model/kdl.hpp"

namespace rivid::detail {

namespace {

using Eigen::Vector3d;

// A capsule of a link, whose number among the moving ones is −1 for the base.
struct Solid {
  Index link;
  Capsule capsule;
};

// The line of a capsule in the base frame.
struct PlacedLine {
  Vector3d from;
  Vector3d to;
};

// The smallest value of a convex function on [0, 1], by golden sections.
template <typename F>
double least(const F& f) {
  constexpr int sections = 40;  // to 4e-9 of the line, where the distance is flat
  double low = 0.0;
  double high = 1.0;
  double a = high - (high - low) / std::numbers::phi;
  double b = low + (high - low) / std::numbers::phi;
  double at_a = f(a);
  double at_b = f(b);
  for (int k = 0; k < sections; ++k) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - (high - low) / std::numbers::phi;
      at_a = f(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + (high - low) / std::numbers::phi;
      at_b = f(b);
    }
  }
  return std::min({at_a, at_b, f(0.0), f(1.0)});
}

double from_box(const Vector3d& x, const Box& box) {
  return (box.min - x).cwiseMax(x - box.max).cwiseMax(0.0).norm();
}

double from_line(const Vector3d& x, const PlacedLine& line) {
  const Vector3d along = line.to - line.from;
  const double length = along.norm();
  if (length == 0.0) {
    return (x - line.from).norm();
  }
  const Vector3d unit = along / length;
  return (x - line.from - std::clamp(unit.dot(x - line.from), 0.0, length) * unit).norm();
}

// One pair, and how far its lines are apart.
struct Check {
  ClearanceUse use;
  double radii;
  std::function<double(const std::vector<PlacedLine>&)> apart;
};

Vector3d eigen_vector(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }

std::vector<Solid> solids_of(const Robot& robot, const Space& space, const KDL::Chain& chain) {
  std::vector<Solid> out;
  const auto is_given = [&](const std::string& link) {
    return std::ranges::find(space.capsules, link, &Capsule::link) != space.capsules.end();
  };
  const auto name_of = [&](Index link) {
    return link < 0 ? robot.base : robot.joints[static_cast<std::size_t>(link)].link;
  };
  for (const Capsule& capsule : space.capsules) {
    const auto found = std::ranges::find(robot.joints, capsule.link, &Joint::link);
    out.push_back({capsule.link == robot.base ? -1 : found - robot.joints.begin(), capsule});
  }
  for (Index link = -1; link < robot.size(); ++link) {
    const Vector3d next = link + 1 < robot.size()
                              ? eigen_vector(chain.getSegment(static_cast<unsigned>(link + 1)).pose(0.0).p)
                              : Vector3d(Vector3d::Zero());
    // A point is the end of the capsule before it, unless that one was given.
    const bool is_end = next.isZero(0.0) && !(link >= 0 && is_given(name_of(link - 1)));
    if (!is_given(name_of(link)) && !is_end) {
      out.push_back({link, {name_of(link), Vector3d::Zero(), next, space.radius}});
    }
  }
  return out;
}

std::vector<Check> checks_of(const Space& space, const std::vector<Solid>& solids) {
  using Lines = std::vector<PlacedLine>;
  std::vector<Check> out;
  for (std::size_t a = 0; a < solids.size(); ++a) {
    const Capsule& own = solids[a].capsule;
    const auto add = [&](const std::string& second, double radii, auto apart) {
      out.push_back({{.first = own.link, .second = second}, radii, std::move(apart)});
    };
    for (const HalfSpace& free : space.half_spaces) {
      if (solids[a].link >= 0) {
        add(free.name, own.radius, [a, free](const Lines& lines) {
          const auto height = [&](const Vector3d& x) {
            return (free.normal.dot(x) - free.offset) / free.normal.norm();
          };
          return std::min(height(lines[a].from), height(lines[a].to));
        });
      }
    }
    for (const Box& box : space.boxes) {
      if (solids[a].link >= 0) {
        add(box.name, own.radius, [a, box](const Lines& lines) {
          return least([&](double part) {
            return from_box(lines[a].from + part * (lines[a].to - lines[a].from), box);
          });
        });
      }
    }
    for (std::size_t b = 0; space.self_collision && b < solids.size(); ++b) {
      if (solids[b].link > solids[a].link + 1) {
        add(solids[b].capsule.link, own.radius + solids[b].capsule.radius, [a, b](const Lines& lines) {
          return least([&](double part) {
            return from_line(lines[a].from + part * (lines[a].to - lines[a].from), lines[b]);
          });
        });
      }
    }
  }
  return out;
}

}  // namespace

std::vector<ClearanceUse> checked_clearances(const Robot& robot, const Space& space,
                                             const std::vector<bool>& kept, const Matrix& q, double f_m) {
  const KDL::Chain chain = kdl_chain(robot);
  const std::vector<Solid> solids = solids_of(robot, space, chain);
  std::vector<Check> checks = checks_of(space, solids);
  assert(checks.size() == kept.size());
  for (std::size_t k = 0; k < checks.size(); ++k) {
    checks[k].use.distance = std::numeric_limits<double>::infinity();
    checks[k].use.wanted = kept[k] ? space.clearance : std::numeric_limits<double>::quiet_NaN();
  }
  std::vector<PlacedLine> lines(solids.size());
  std::vector<KDL::Frame> frames(robot.joints.size() + 1);
  for (Index row = 0; row < q.rows(); ++row) {
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      frames[j + 1] =
          frames[j] * chain.getSegment(static_cast<unsigned>(j)).pose(q(row, static_cast<Index>(j)));
    }
    for (std::size_t s = 0; s < solids.size(); ++s) {
      const KDL::Frame& frame = frames[static_cast<std::size_t>(solids[s].link + 1)];
      const auto placed = [&](const Vector3d& x) {
        return eigen_vector(frame * KDL::Vector(x.x(), x.y(), x.z()));
      };
      lines[s] = {placed(solids[s].capsule.from), placed(solids[s].capsule.to)};
    }
    for (Check& check : checks) {
      const double distance = check.apart(lines) - check.radii;
      if (distance < check.use.distance) {
        check.use.distance = distance;
        check.use.time = static_cast<double>(row) / f_m;
      }
    }
  }
  std::vector<ClearanceUse> out(checks.size());
  std::ranges::transform(checks, out.begin(), &Check::use);
  std::ranges::stable_sort(
      out, {}, [](const ClearanceUse& use) { return std::pair(std::isnan(use.wanted), use.distance); });
  return out;
}

}  // namespace rivid::detail
