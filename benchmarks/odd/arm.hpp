#pragma once

#include <array>
#include <vector>

#include "rivid/types.hpp"

// The arms that are simulated, and their dynamics. Nothing here is rivid's: what rivid gets wrong must not be
// wrong here too.
namespace rivid::odd {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int most_joints = 9;
constexpr int most_freedoms = 2 * most_joints;  // of elastic joints: links and motors
/// A number for each joint, or for each degree of freedom.
using Numbers = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_freedoms, 1>;
using SquareMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_freedoms, most_freedoms>;

/// A body as a URDF describes it.
struct Body {
  double mass = 0.0;
  Vector3d com = Vector3d::Zero();          ///< in the link's frame [m]
  Matrix3d inertia_com = Matrix3d::Zero();  ///< about the centre of mass [kg·m²]
};

/// A joint and the link that it moves.
struct ArmJoint {
  bool prismatic = false;
  Vector3d rpy = Vector3d::Zero();  ///< of the link's frame in the parent's at q = 0, as URDF has it [rad]
  Vector3d xyz = Vector3d::Zero();  ///< origin of the link's frame in the parent's at q = 0 [m]
  Vector3d axis = Vector3d::UnitZ();
  Body body;
};

struct Arm {
  std::vector<ArmJoint> joints;
  Vector3d gravity = {0.0, 0.0, -9.80665};  ///< acceleration of free fall in the base frame [m/s²]

  [[nodiscard]] Index size() const { return static_cast<Index>(joints.size()); }
};

/// R = R_z(yaw) R_y(pitch) R_x(roll).
[[nodiscard]] Matrix3d rotation(const Vector3d& rpy);
/// The inverse of rotation().
[[nodiscard]] Vector3d rpy_of(const Matrix3d& R);

/// A body about the origin of its frame: what adds up when bodies are joined.
struct OriginInertia {
  double m = 0.0;
  Vector3d h = Vector3d::Zero();  ///< mass times centre of mass
  Matrix3d I = Matrix3d::Zero();  ///< about the origin

  OriginInertia() = default;
  explicit OriginInertia(const Body& body);
  OriginInertia& operator+=(const OriginInertia& other);
};

/// Rigid-body dynamics of an arm without friction and rotors: recursive Newton-Euler for the torques [Luh
/// 1980], composite bodies for the mass matrix [Walker & Orin 1982], in the frames of the links.
class ArmDynamics {
 public:
  explicit ArmDynamics(const Arm& arm);

  /// Joins a body to the last link.
  void carry(const Body& payload) { links_.back().inertia += OriginInertia(payload); }

  /// τ = M q̈ + N(q, q̇), (n) each.
  [[nodiscard]] Numbers torques(const Numbers& q, const Numbers& qd, const Numbers& qdd) const;
  /// M(q), (n × n).
  [[nodiscard]] SquareMatrix mass(const Numbers& q) const;
  /// Potential energy in the field of gravity [J].
  [[nodiscard]] double potential(const Numbers& q) const;
  [[nodiscard]] Index size() const { return size_; }

 private:
  struct Link {
    bool prismatic = false;
    Vector3d axis, p;
    Matrix3d R0, R1, R2;  // orientation in the parent: R0 + cos q R1 + sin q R2
    OriginInertia inertia;
  };
  struct Pose {
    std::array<Matrix3d, most_joints> R;  // of each link in its parent
    std::array<Vector3d, most_joints> p;
  };
  [[nodiscard]] Pose pose(const Numbers& q) const;

  Index size_ = 0;
  Vector3d gravity_;
  std::vector<Link> links_;
};

}  // namespace rivid::odd
