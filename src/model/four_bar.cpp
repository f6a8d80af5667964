#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/link_poses.hpp"
#include "rivid/error.hpp"
#include "rivid/model/dependent.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::LinkPose;
using detail::Planar;
using Vector2 = Planar<double>;

// Sine of the angle between coupler and rocker below which a linkage counts as stretched: forces grow without
// limit.
constexpr double stretched = 0.05;
// Of one minus the cosine between two axes.
constexpr double parallel = 1e-6;

// The linkage in the robot at q = 0, seen against the axis of the crank's joint.
class Linkage {
 public:
  Linkage(const Robot& robot, const FourBar& bar)
      : robot_(robot), bar_(bar), poses_(robot.chain.links.size()) {
    detail::place_links(robot.chain, Vector::Zero(std::ssize(robot.chain.links)), poses_);
    crank_ = place_of(bar.crank);
    coupler_ = place_of(bar.coupler);
    rocker_ = place_of(bar.rocker);
    for (const std::size_t joint : {crank_, coupler_, rocker_}) {
      if (robot.joints[joint].type != JointType::revolute ||
          std::abs(axis(joint).dot(axis(crank_))) < 1.0 - parallel) {
        refuse("joint \"" + robot.joints[joint].name +
               "\" is not revolute, or its axis is not parallel to the crank's");
      }
    }
    if (robot.chain.parent(coupler_) != static_cast<int>(crank_) ||
        robot.chain.parent(rocker_) != robot.chain.parent(crank_)) {
      refuse("the coupler must hang on the crank, and the rocker on what carries the crank");
    }
    measure();
  }

  [[nodiscard]] FourBarAngle angle(bool of_rocker) const {
    FourBarAngle out = lengths_;
    out.of_rocker = of_rocker;
    const std::size_t joint = of_rocker ? rocker_ : coupler_;
    out.reversed = axis(joint).dot(axis(crank_)) < 0.0;
    const Vector2 along = of_rocker ? rocker_along_ : coupler_along_;
    out.zero = std::atan2(along.y, along.x);
    const Eigen::Vector3d closing = own_axes(joint).transpose() * (point(rocker_, bar_.at) - poses_[joint].o);
    std::ranges::copy(closing, out.closing.begin());
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError("four-bar linkage of \"" + bar_.crank + "\", \"" + bar_.coupler + "\" and \"" +
                     bar_.rocker + "\": " + why);
  }

  [[nodiscard]] std::size_t place_of(const std::string& name) const {
    const auto at = robot_.link_of(name);
    if (!at) {
      refuse("no joint of the robot is called \"" + name + "\"");
    }
    return *at;
  }

  [[nodiscard]] Eigen::Vector3d axis(std::size_t link) const { return poses_[link].R.col(2); }

  // A link's own frame has the axes of frame j, renamed.
  [[nodiscard]] Eigen::Matrix3d own_axes(std::size_t link) const {
    return poses_[link].R * link_axes(robot_.chain.links[link]).transpose();
  }
  [[nodiscard]] Eigen::Vector3d point(std::size_t link, const Eigen::Vector3d& own) const {
    return poses_[link].o + own_axes(link) * own;
  }

  void measure() {
    const Eigen::Vector3d z = axis(crank_);
    const Eigen::Vector3d ground = poses_[rocker_].o - poses_[crank_].o;
    const Eigen::Vector3d across = ground - z * z.dot(ground);
    if (across.norm() < 1e-9) {
      refuse("crank and rocker turn about one axis");
    }
    const Eigen::Vector3d x = across.normalized();
    const Eigen::Vector3d y = z.cross(x);
    const auto planar = [&](const Eigen::Vector3d& v) { return Vector2{x.dot(v), y.dot(v)}; };
    const Vector2 of_crank = planar(poses_[coupler_].o - poses_[crank_].o);
    const Eigen::Vector3d closing = point(rocker_, bar_.at);
    rocker_along_ = planar(closing - poses_[rocker_].o);
    coupler_along_ = planar(closing - poses_[coupler_].o);
    const auto length = [](const Vector2& v) { return std::hypot(v.x, v.y); };
    lengths_ = {.ground = across.norm(),
                .crank = length(of_crank),
                .coupler = length(coupler_along_),
                .rocker = length(rocker_along_),
                .crank_angle = std::atan2(of_crank.y, of_crank.x)};
    if (std::min({lengths_.crank, lengths_.coupler, lengths_.rocker}) < 1e-9) {
      refuse("a link between two of its axes has no length");
    }
    lengths_.mirrored = cross(coupler_along_, rocker_along_) < 0.0;
    // Grashof's condition: with the shortest of the four as ground all others go round.
    const auto [shortest, longest] =
        std::minmax({lengths_.ground, lengths_.crank, lengths_.coupler, lengths_.rocker});
    const double sum = lengths_.ground + lengths_.crank + lengths_.coupler + lengths_.rocker;
    lengths_.turns = lengths_.ground == shortest && 2.0 * (shortest + longest) < sum;
    find_reach();
  }

  // Sine of the angle between coupler and rocker; no number where they do not meet.
  [[nodiscard]] double spread(double q) const {
    const double squared = std::pow(lengths_.ground, 2) + std::pow(lengths_.crank, 2) -
                           2.0 * lengths_.ground * lengths_.crank * std::cos(q + lengths_.crank_angle);
    const double cosine = (std::pow(lengths_.coupler, 2) + std::pow(lengths_.rocker, 2) - squared) /
                          (2.0 * lengths_.coupler * lengths_.rocker);
    return std::sqrt(1.0 - cosine * cosine);
  }

  void find_reach() {
    constexpr double step = 1e-3;  // [rad] a choice: so much of the reach may be lost
    if (!(spread(0.0) > stretched)) {
      refuse(
          "it can not be closed where the crank\'s joint is at 0, or coupler and rocker are in one line "
          "there");
    }
    const auto reach = [&](double way) {
      double q = 0.0;
      while (std::abs(q) < std::numbers::pi && spread(q + way) > stretched) {
        q += way;
      }
      return q;
    };
    lengths_.least = reach(-step);
    lengths_.most = reach(step);
  }

  const Robot& robot_;
  const FourBar& bar_;
  std::vector<LinkPose> poses_;
  std::size_t crank_ = 0;
  std::size_t coupler_ = 0;
  std::size_t rocker_ = 0;
  FourBarAngle lengths_;
  Vector2 coupler_along_{};
  Vector2 rocker_along_{};
};

}  // namespace

std::vector<DependentJoint> with_four_bars(const Robot& robot, std::span<const FourBar> four_bars,
                                           std::vector<DependentJoint> dependents) {
  for (const FourBar& bar : four_bars) {
    const Linkage linkage(robot, bar);
    for (const bool of_rocker : {false, true}) {
      const std::string& joint = of_rocker ? bar.rocker : bar.coupler;
      std::erase_if(dependents, [&](const DependentJoint& d) { return d.joint == joint; });
      dependents.push_back({.joint = joint, .of = {{bar.crank, 1.0}}, .curve = linkage.angle(of_rocker)});
    }
  }
  return dependents;
}

}  // namespace rivid
