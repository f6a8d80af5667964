#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "excite/design_parts.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr Index instants = 4001;  // of a move that are checked; a choice

// q(t) = from + s(t) (to − from) with the quintic s from 0 to 1; its variables are one.
class Line final : public Curve {
 public:
  Line(const Vector& from, const Vector& to, double duration, const MotionBounds& bounds)
      : Curve(duration, bounds, from) {
    for (Index j = 0; j < from.size(); ++j) {
      T_.emplace_back(Matrix::Constant(1, 1, to[j] - from[j]));
    }
  }
  [[nodiscard]] double highest_frequency() const override { return 2.0 * std::numbers::pi / duration_; }
  [[nodiscard]] FunctionTables tables(const Vector& t) const override {
    const Eigen::ArrayXd u = t.array() / duration_;
    const Eigen::ArrayXd w = u * (1.0 - u);
    return {.position = u.cube() * (10.0 + u * (6.0 * u - 15.0)),
            .velocity = 30.0 / duration_ * w.square(),
            .acceleration = 60.0 / std::pow(duration_, 2) * w * (1.0 - 2.0 * u),
            .jerk = 60.0 / std::pow(duration_, 3) * (1.0 - 6.0 * w)};
  }
};

// The pair that is too near, and where; nothing where none is.
std::string too_near(const Task& task, const Line& line) {
  const Vector t = Vector::LinSpaced(instants, 0.0, line.duration());
  const Matrix q = line.motion(line.tables(t), line.coefficients(Vector::Ones(line.variables()))).q;
  for (const ClearanceUse& use : checked_clearances(task.robot, task.space, task.clearances->kept(), q,
                                                    static_cast<double>(instants - 1))) {
    if (use.distance < use.wanted + clearance_reserve) {
      return "at " + number(100.0 * use.time, 2) + " % of it " + use.first + " is " +
             number(use.distance, 3) + " m from " + use.second + " where it must be at least " +
             number(use.wanted, 3) + " m";
    }
  }
  return {};
}

// Seconds of the shortest move within the limits, or what is against any.
double seconds_of(const Task& task, const Matrix& via, double rate_hz, double more,
                  const std::function<bool(const Curve&)>& suits, std::string& fault) {
  // The last is 1.1^39 = 41 times the duration of the fastest; what fails there is no matter of speed.
  constexpr int rounds = 40;
  constexpr double slower = 1.1;  // each round; a choice: a move is at most 10 % longer than need be
  // of the duration: rounding must not exceed a limit that the fastest move reaches
  constexpr double reserve = 1e-4;
  constexpr double no_limit = 1e12;  // any large value: stands for infinity, which a move may not have
  const MotionBounds& bounds = task.bounds;
  const PointToPointReference fastest({.via = via,
                                       .max_velocity = bounds.velocity,
                                       .max_acceleration = bounds.acceleration.cwiseMin(no_limit),
                                       .max_jerk = bounds.jerk.cwiseMin(no_limit)});
  double least = fastest.duration() * (1.0 + reserve);
  for (int k = 0; k < rounds; ++k, least *= slower) {
    const double duration = std::max(std::ceil((least - more) * rate_hz), 1.0) / rate_hz + more;
    const Line line(via.row(0), via.row(1), duration, bounds);
    const Vector values = DenseCheck(task, line, instants)(Vector::Ones(line.variables()));
    const std::vector<SideLimit> sides = side_limits(bounds);
    Index at = 0;
    const double worst = values.maxCoeff(&at);
    if (worst <= 0.0 && suits(line)) {
      fault.clear();
      return duration;
    }
    fault = "torques leave no room, however slow it is";
    if (worst > 0.0) {
      fault = at < std::ssize(sides) ? excess_in_words(task, at, worst) : too_near(task, line);
    }
    if (at >= std::ssize(sides) || sides[static_cast<std::size_t>(at)].quantity == Limited::position) {
      break;
    }
  }
  return 0.0;
}

}  // namespace

PointToPoint lead(const std::string& who, const Task& task, const Vector& from, const Vector& to,
                  const Vector& middle, double rate_hz, double more,
                  const std::function<bool(const Curve&)>& suits) {
  const Vector of_ranges = 0.5 * (task.bounds.lower + task.bounds.upper);
  std::string straight;
  for (const std::vector<Vector>& poses :
       {std::vector{from, to}, std::vector{from, middle, to}, std::vector{from, of_ranges, to}}) {
    const Index moves = std::ssize(poses) - 1;
    PointToPoint out{.via = Matrix(moves + 1, from.size()), .durations = Vector(moves)};
    for (Index i = 0; i <= moves; ++i) {
      out.via.row(i) = poses[static_cast<std::size_t>(i)];
    }
    std::string fault;
    for (Index i = 0; i < moves && fault.empty(); ++i) {
      out.durations[i] =
          seconds_of(task, out.via.middleRows(i, 2), rate_hz, i == 0 ? more : 0.0, suits, fault);
    }
    if (fault.empty()) {
      return out;
    }
    straight = straight.empty() ? fault : straight;
  }
  throw InputError("design: " + who + ": on the straight way " + straight +
                   "; the ways through the middle of the motion and of the positions are not free either. "
                   "Choose another pose, or give start, a pose that can be reached from it");
}

double SequenceReference::duration() const {
  double out = 0.0;
  for (const auto& part : parts_) {
    out += part->duration();
  }
  return out;
}

void SequenceReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                           Eigen::Ref<Vector> qdd_r) const {
  auto part = parts_.begin();
  for (; part + 1 != parts_.end() && t >= (*part)->duration(); ++part) {
    t -= (*part)->duration();
  }
  (*part)->at((*part)->begin() + t, q_r, qd_r, qdd_r);
}

}  // namespace rivid::detail
