#include "model/convex.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <set>

namespace rivid::detail {

namespace {

using Eigen::Vector3d;

constexpr double precision = 1e-9;  // of a distance [m]

// A point of the difference of two bodies, and its part in the nearest one.
struct Corner {
  Vector3d a;
  Vector3d b;
  double weight;

  [[nodiscard]] Vector3d difference() const { return a - b; }
};

// At most four corners, and the point of their hull that is nearest to the origin.
class Simplex {
 public:
  explicit Simplex(const Corner& first) { corners_[size_++] = first; }

  [[nodiscard]] Vector3d nearest() const { return first() - second(); }
  [[nodiscard]] Vector3d first() const { return sum(&Corner::a); }
  [[nodiscard]] Vector3d second() const { return sum(&Corner::b); }

  // The nearest point with one more corner [Wolfe 1976]; false where rounding leaves no better one.
  bool improve(const Vector3d& a, const Vector3d& b) {
    if (size_ == corners_.size()) {
      return false;
    }
    corners_[size_++] = {a, b, 0.0};
    for (;;) {
      const std::optional<Eigen::Vector4d> wanted = affine_weights();
      if (!wanted) {
        return false;
      }
      // As far towards these weights as none is negative: the corners whose weight ends are left.
      double part = 1.0;
      for (std::size_t i = 0; i < size_; ++i) {
        const double w = (*wanted)[static_cast<Index>(i)];
        if (w < 0.0) {
          part = std::min(part, corners_[i].weight / (corners_[i].weight - w));
        }
      }
      for (std::size_t i = 0; i < size_; ++i) {
        corners_[i].weight += part * ((*wanted)[static_cast<Index>(i)] - corners_[i].weight);
      }
      const auto end = std::remove_if(corners_.begin(), corners_.begin() + static_cast<Index>(size_),
                                      [](const Corner& corner) { return corner.weight <= 1e-14; });
      const auto left = static_cast<std::size_t>(end - corners_.begin());
      if (part == 1.0 || left == size_) {
        size_ = left;
        return size_ > 0;
      }
      size_ = left;
    }
  }

 private:
  [[nodiscard]] Vector3d sum(Vector3d Corner::* side) const {
    Vector3d out = Vector3d::Zero();
    for (std::size_t i = 0; i < size_; ++i) {
      out += corners_[i].weight * corners_[i].*side;
    }
    return out;
  }

  // Of the point nearest to the origin in the plane of the corners; nothing where they make none.
  [[nodiscard]] std::optional<Eigen::Vector4d> affine_weights() const {
    Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
    Vector3d lengths = Vector3d::Ones();
    const Vector3d origin = corners_[0].difference();
    const auto n = static_cast<Index>(size_) - 1;
    for (Index i = 0; i < n; ++i) {
      edges.col(i) = corners_[static_cast<std::size_t>(i + 1)].difference() - origin;
      lengths[i] = edges.col(i).norm();
      if (!(lengths[i] > 0.0)) {
        return std::nullopt;
      }
      edges.col(i) /= lengths[i];
    }
    for (Index i = 0; i < n; ++i) {
      for (Index k = 0; k < i; ++k) {
        gram(i, k) = gram(k, i) = edges.col(i).dot(edges.col(k));
      }
    }
    constexpr double dependent = 1e-14;  // of edges of length 1, 45 ε
    if (!(gram.determinant() > dependent)) {
      return std::nullopt;
    }
    const Vector3d parts = (gram.inverse() * (-edges.transpose() * origin)).eval().cwiseQuotient(lengths);
    Eigen::Vector4d out;
    out << 1.0 - parts.head(n).sum(), parts;
    return out;
  }

  std::array<Corner, 4> corners_ = {};
  std::size_t size_ = 0;
};

// Nearest points of two hulls, and what these are apart at least.
struct Approach {
  Simplex points;
  double least;
};

// By Gilbert, Johnson & Keerthi [1988], the first hull shifted. Ends as soon as more than `enough` is shown.
Approach nearest(const PlacedHull& a, const PlacedHull& b, const Vector3d& shift,
                 const Vector3d& start = Vector3d::Zero(),
                 double enough = std::numeric_limits<double>::infinity()) {
  constexpr int steps = 100;  // a choice that ends what does not settle
  Vector3d x = start;
  if (x.isZero(0.0)) {
    x = a.placed(a.points.col(0)) + shift - b.placed(b.points.col(0));
  }
  Vector3d first = a.farthest(-x) + shift;
  Vector3d second = b.farthest(x);
  Approach out{Simplex({first, second, 1.0}), x.dot(first - second) / x.norm()};
  for (int k = 0; k < steps && !(out.least > enough); ++k) {
    x = out.points.nearest();
    const double size = x.norm();
    if (size <= precision) {
      break;
    }
    first = a.farthest(-x) + shift;
    second = b.farthest(x);
    out.least = std::fmax(out.least, x.dot(first - second) / size);
    Simplex better = out.points;
    if (size - out.least <= precision || !better.improve(first, second) || better.nearest().norm() >= size) {
      break;
    }
    out.points = better;
  }
  return out;
}

double distance_from(const Vector3d& point, const Eigen::Matrix3Xd& hull) {
  const Eigen::Matrix3Xd one = point;
  return nearest({one}, {hull}, Vector3d::Zero()).points.nearest().norm();
}

}  // namespace

Vector3d PlacedHull::farthest(const Vector3d& direction) const {
  const Vector3d along = pose.R.transpose() * direction;
  const double x = along.x();
  const double y = along.y();
  const double z = along.z();
  // By pointer: distances of meshes take most of their time here.
  const double* p = points.data();
  Index best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (Index k = 0; k < points.cols(); ++k, p += 3) {
    const double far = x * p[0] + y * p[1] + z * p[2];
    if (far > most) {
      most = far;
      best = k;
    }
  }
  return placed(points.col(best));
}

double gap(const PlacedHull& a, const PlacedHull& b, const Vector3d& normal) {
  return normal.dot(a.farthest(-normal) - b.farthest(normal));
}

Separation separation(const PlacedHull& a, const PlacedHull& b, const Vector3d& start, double enough) {
  const Approach found = nearest(a, b, Vector3d::Zero(), start, enough);
  const Vector3d apart = found.points.nearest();
  const double distance = apart.norm();
  // [m] bodies that are nearer touch: a difference of nearest points has no direction then
  constexpr double touching = 1e-7;
  if (distance > touching) {
    const bool is_enough = found.least > enough;
    return {found.points.first(), found.points.second(), apart / distance,
            is_enough ? found.least : distance};
  }
  // The first body is moved out of the second one along a direction. The nearest points then have a direction
  // in which it is shorter, and so on; from a few directions, since each way leads to an optimum of its own,
  // or from the one that is known.
  constexpr double beside = 0.01;  // [m] gap to which the bodies are moved apart; a choice
  constexpr int steps = 10;        // from each direction; a choice
  Separation out{.distance = -std::numeric_limits<double>::infinity()};
  const auto shorten = [&](Vector3d normal) {
    double best = gap(a, b, normal);
    for (int k = 0; k < steps; ++k) {
      const Vector3d next = nearest(a, b, (beside - best) * normal).points.nearest().normalized();
      const double shorter = gap(a, b, next);
      if (!(shorter > best + precision)) {
        break;
      }
      best = shorter;
      normal = next;
    }
    if (best > out.distance) {
      out.distance = best;
      out.normal = normal;
    }
  };
  if (start.isZero(0.0)) {
    for (Index axis = 0; axis < 3; ++axis) {
      shorten(Vector3d::Unit(axis));
      shorten(-Vector3d::Unit(axis));
    }
  } else {
    shorten(start.normalized());
  }
  out.first = a.farthest(-out.normal);
  out.second = b.farthest(out.normal);
  return out;
}

Hull enclosing_hull(const Eigen::Matrix3Xd& points, Index most) {
  // [m] by which a point may lie beyond the corners; a choice: the radius covers it
  constexpr double enough = 5e-4;
  // evenly over the sphere; a choice: 6° apart, so that small corners are not missed by much
  constexpr Index directions = 1000;
  const auto farthest_of = [&](const Vector3d& direction) {
    Index at = 0;
    (direction.transpose() * points).maxCoeff(&at);
    return at;
  };
  // Of many points those that are the farthest in directions all around.
  std::set<Index> corners;
  for (Index k = 0; k < directions; ++k) {
    const double z = 1.0 - (2.0 * static_cast<double>(k) + 1.0) / directions;
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / std::numbers::phi;
    const double r = std::sqrt(1.0 - z * z);
    corners.insert(farthest_of({r * std::cos(turn), r * std::sin(turn), z}));
  }
  Hull out;
  const auto add = [&](Index point) {
    out.points.conservativeResize(3, out.points.cols() + 1);
    out.points.rightCols<1>() = points.col(point);
  };
  // The farthest one first: distances fall as the hull grows, so that those of before are bounds.
  std::priority_queue<std::pair<double, Index>> open;
  add(*corners.begin());
  for (const Index corner : corners) {
    open.emplace((points.col(corner) - out.points.col(0)).norm(), corner);
  }
  while (!open.empty() && open.top().first > enough && out.points.cols() < most) {
    const Index corner = open.top().second;
    open.pop();
    const double distance = distance_from(points.col(corner), out.points);
    if (open.empty() || distance >= open.top().first) {
      if (distance > precision) {
        add(corner);
      }
    } else {
      open.emplace(distance, corner);
    }
  }
  for (Index k = 0; k < points.cols(); ++k) {
    out.radius = std::max(out.radius, distance_from(points.col(k), out.points));
  }
  return out;
}

}  // namespace rivid::detail
