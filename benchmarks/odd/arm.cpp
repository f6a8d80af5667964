#include "odd/arm.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace rivid::odd {

namespace {

Matrix3d cross(const Vector3d& v) {
  Matrix3d out;
  out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return out;
}

}  // namespace

Matrix3d rotation(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Vector3d rpy_of(const Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
          std::atan2(R(1, 0), R(0, 0))};
}

OriginInertia::OriginInertia(const Body& body)
    : m(body.mass),
      h(body.mass * body.com),
      I(body.inertia_com - body.mass * cross(body.com) * cross(body.com)) {}

OriginInertia& OriginInertia::operator+=(const OriginInertia& other) {
  m += other.m;
  h += other.h;
  I += other.I;
  return *this;
}

ArmDynamics::ArmDynamics(const Arm& arm) : size_(arm.size()), gravity_(arm.gravity) {
  for (const ArmJoint& joint : arm.joints) {
    Link link;
    link.prismatic = joint.prismatic;
    link.axis = joint.axis.normalized();
    link.p = joint.xyz;
    // Rodrigues: R(q) = a aᵀ + cos q (1 − a aᵀ) + sin q [a ×].
    const Matrix3d R = rotation(joint.rpy);
    const Matrix3d along = link.axis * link.axis.transpose();
    link.R0 = joint.prismatic ? R : Matrix3d(R * along);
    link.R1 = R * (Matrix3d::Identity() - along);
    link.R2 = R * cross(link.axis);
    link.inertia = OriginInertia(joint.body);
    links_.push_back(link);
  }
}

ArmDynamics::Pose ArmDynamics::pose(const Numbers& q) const {
  Pose out;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Link& link = links_[j];
    const double q_j = q[static_cast<Index>(j)];
    out.R[j] = link.R0;
    out.p[j] = link.p;
    if (link.prismatic) {
      out.p[j] += link.R0 * (q_j * link.axis);
    } else {
      out.R[j] += std::cos(q_j) * link.R1 + std::sin(q_j) * link.R2;
    }
  }
  return out;
}

Numbers ArmDynamics::torques(const Numbers& q, const Numbers& qd, const Numbers& qdd) const {
  const Pose at = pose(q);
  std::array<Vector3d, most_joints> force;
  std::array<Vector3d, most_joints> moment;
  Vector3d w = Vector3d::Zero();
  Vector3d dw = Vector3d::Zero();
  Vector3d a = -gravity_;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Link& link = links_[j];
    const auto row = static_cast<Index>(j);
    const Vector3d at_origin = a + dw.cross(at.p[j]) + w.cross(w.cross(at.p[j]));
    const Vector3d w_parent = at.R[j].transpose() * w;
    w = w_parent;
    dw = at.R[j].transpose() * dw;
    a = at.R[j].transpose() * at_origin;
    if (link.prismatic) {
      a += link.axis * qdd[row] + 2.0 * qd[row] * w_parent.cross(link.axis);
    } else {
      w += link.axis * qd[row];
      dw += link.axis * qdd[row] + qd[row] * w_parent.cross(link.axis);
    }
    const OriginInertia& body = link.inertia;
    force[j] = body.m * a + dw.cross(body.h) + w.cross(w.cross(body.h));
    moment[j] = body.I * dw + w.cross(body.I * w) + body.h.cross(a);
  }
  Numbers tau(size_);
  for (std::size_t j = links_.size(); j-- > 0;) {
    tau[static_cast<Index>(j)] = links_[j].axis.dot(links_[j].prismatic ? force[j] : moment[j]);
    if (j > 0) {
      const Vector3d f = at.R[j] * force[j];
      force[j - 1] += f;
      moment[j - 1] += at.R[j] * moment[j] + at.p[j].cross(f);
    }
  }
  return tau;
}

SquareMatrix ArmDynamics::mass(const Numbers& q) const {
  const Pose at = pose(q);
  std::array<OriginInertia, most_joints> composite;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    composite[j] = links_[j].inertia;
  }
  for (std::size_t j = links_.size(); j-- > 1;) {
    const OriginInertia& body = composite[j];
    const Matrix3d& R = at.R[j];
    OriginInertia moved;
    const Vector3d h = R * body.h;
    const Vector3d& p = at.p[j];
    moved.m = body.m;
    moved.h = h + body.m * p;
    moved.I = R * body.I * R.transpose() +
              (2.0 * p.dot(h) + body.m * p.squaredNorm()) * Matrix3d::Identity() - p * h.transpose() -
              h * p.transpose() - body.m * p * p.transpose();
    composite[j - 1] += moved;
  }
  SquareMatrix M(size_, size_);
  for (std::size_t j = 0; j < links_.size(); ++j) {
    // Force and moment that a unit acceleration of joint j asks of all that it carries, handed down to the
    // base.
    const Vector3d& axis = links_[j].axis;
    const OriginInertia& body = composite[j];
    Vector3d f = links_[j].prismatic ? Vector3d(body.m * axis) : Vector3d(axis.cross(body.h));
    Vector3d n = links_[j].prismatic ? Vector3d(body.h.cross(axis)) : Vector3d(body.I * axis);
    for (std::size_t i = j + 1; i-- > 0;) {
      const double entry = links_[i].axis.dot(links_[i].prismatic ? f : n);
      M(static_cast<Index>(i), static_cast<Index>(j)) = entry;
      M(static_cast<Index>(j), static_cast<Index>(i)) = entry;
      f = at.R[i] * f;
      n = at.R[i] * n + at.p[i].cross(f);
    }
  }
  return M;
}

double ArmDynamics::potential(const Numbers& q) const {
  const Pose at = pose(q);
  double energy = 0.0;
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();
  for (std::size_t j = 0; j < links_.size(); ++j) {
    p += R * at.p[j];
    R = R * at.R[j];
    energy -= gravity_.dot(links_[j].inertia.m * p + R * links_[j].inertia.h);
  }
  return energy;
}

}  // namespace rivid::odd
