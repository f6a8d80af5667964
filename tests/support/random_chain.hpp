#pragma once

#include <array>
#include <kdl/chain.hpp>
#include <numbers>
#include <random>
#include <string>

#include "rivid/types.hpp"

namespace rivid::test {

/// Draws KDL chains of every joint type, tips on and off the axis, physical bodies.
class RandomChain {
 public:
  explicit RandomChain(std::uint64_t seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  KDL::Vector vector(double size) {
    const double x = uniform(-size, size);
    const double y = uniform(-size, size);
    return {x, y, uniform(-size, size)};
  }

  KDL::Rotation rotation() {
    const double roll = uniform(-3.0, 3.0);
    const double pitch = uniform(-1.5, 1.5);
    return KDL::Rotation::RPY(roll, pitch, uniform(-3.0, 3.0));
  }

  KDL::RigidBodyInertia body() {
    // Six point masses on the axes of an ellipsoid: any such body is physical.
    const double m = uniform(0.1, 5.0);
    const double a = uniform(0.0, 0.02);
    const double b = uniform(0.0, 0.02);
    const double c = uniform(0.0, 0.02);
    const KDL::RotationalInertia principal(m * (b + c), m * (a + c), m * (a + b));
    const KDL::Rotation R = rotation();
    return KDL::Frame(R, vector(0.2)) * KDL::RigidBodyInertia(m, KDL::Vector::Zero(), principal);
  }

  /// A joint at the root of a segment, with a tip as URDF readers, Denavit-Hartenberg tables and KDL's own
  /// examples place it.
  KDL::Segment segment(const std::string& number, bool may_be_fixed) {
    using Type = KDL::Joint;
    static constexpr std::array types = {Type::RotX,    Type::RotY,      Type::RotZ,
                                         Type::TransX,  Type::TransY,    Type::TransZ,
                                         Type::RotAxis, Type::TransAxis, Type::Fixed};
    const auto type = types[static_cast<std::size_t>(integer(0, may_be_fixed ? 8 : 7))];
    const std::string name = "joint_" + number;
    const std::string link = "link_" + number;
    if (type == Type::Fixed) {
      const KDL::Frame tip(rotation(), vector(0.5));
      return KDL::Segment(link, KDL::Joint(name, type), tip, body());
    }
    const double Ia = integer(0, 1) * uniform(0.0, 2.0);
    if (type == Type::RotAxis || type == Type::TransAxis) {
      const KDL::Frame tip(rotation(), vector(0.5));
      const KDL::Vector axis = tip.M * link_axis();
      const KDL::Vector origin = integer(0, 3) == 0 ? vector(0.5) : tip.p;
      return KDL::Segment(link, KDL::Joint(name, origin, axis, type, 1.0, 0.0, Ia), tip, body());
    }
    const KDL::Joint joint(name, type, 1.0, 0.0, Ia);
    switch (integer(0, 2)) {
      case 0:
        return KDL::Segment(link, joint, KDL::Frame::Identity(), body());
      case 1:
        return KDL::Segment(link, joint, KDL::Frame(rotation(), vector(0.5)), body());
      default:
        return KDL::Segment(link, joint,
                            KDL::Frame::DH(uniform(-0.5, 0.5), integer(-1, 2) * std::numbers::pi / 2.0,
                                           uniform(-0.5, 0.5), uniform(-3.0, 3.0)),
                            body());
    }
  }

  KDL::Chain chain() {
    KDL::Chain out;
    const int segments = integer(1, 12);
    for (int i = 1; i <= segments; ++i) {
      const bool last_chance = i == segments && out.getNrOfJoints() == 0;
      out.addSegment(segment(std::to_string(i), !last_chance));
    }
    return out;
  }

  Vector positions(Index n) {
    Vector q(n);
    for (double& value : q) {
      value = uniform(-3.0, 3.0);
    }
    return q;
  }

 private:
  // ±x, ±y, ±z or oblique.
  KDL::Vector link_axis() {
    const int choice = integer(0, 7);
    if (choice > 5) {
      return vector(1.0);
    }
    KDL::Vector axis = KDL::Vector::Zero();
    axis(choice % 3) = choice < 3 ? 1.0 : -1.0;
    return axis;
  }

  std::mt19937_64 random_;
};

}  // namespace rivid::test
