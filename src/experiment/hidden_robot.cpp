#include <cmath>

#include "excite/prior.hpp"
#include "experiment/rehearsed_record.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/measurement.hpp"

namespace rivid::detail {

namespace {

// The motor of the last joint is turned by the joint before it, too.
void couple(Robot& robot) {
  Joint& motor = robot.joints.back();
  const auto last = static_cast<int>(robot.size()) - 1;
  robot.couplings.push_back({.motor = last,
                             .joints = {last - 1},
                             .ratios = {1.0},
                             .terms = Coupling::Terms::all,
                             .Iam = motor.Ia,
                             .Fvm = motor.Fv,
                             .Fcm = motor.Fc});
  motor.Ia = motor.Fv = motor.Fc = 0.0;
}

}  // namespace

HiddenRobot drawn_robot(const Robot& described, const Motion& motion, const Matrix& tau, double spread,
                        std::uint64_t seed) {
  const auto rms = [](const Matrix& x) { return Vector(x.cwiseAbs2().colwise().mean().cwiseSqrt()); };
  const Vector inertia = design_inertia(DynamicModel(described, described.chi_st()), motion.q);
  const Vector torque = rms(tau);
  const Vector speed = rms(motion.qd).cwiseMax(1e-3);  // of a joint that stands
  HiddenRobot out{.robot = drawn_about(described, spread, seed), .chi_st = {}};
  constexpr std::uint64_t stream = std::uint64_t{1} << 61U;  // beyond those of white_noise()
  const CounterNoise noise(seed, stream);
  std::uint64_t next = 0;
  const auto unless_known = [&](double& value, double low, double high) {
    const double drawn = low + (high - low) * noise.uniform(next++);
    value = value > 0.0 ? value : drawn;
  };
  for (Index j = 0; j < described.size(); ++j) {
    Joint& joint = out.robot.joints[static_cast<std::size_t>(j)];
    const double rotor = joint.rotor_inertia ? inertia[j] : 0.0;
    unless_known(joint.Ia, 0.1 * rotor, 0.5 * rotor);
    unless_known(joint.Fc, 0.05 * torque[j], 0.2 * torque[j]);
    unless_known(joint.Fv, 0.3 * joint.Fc / speed[j], 1.5 * joint.Fc / speed[j]);
  }
  out.chi_st = out.robot.chi_st();
  return out;
}

HiddenRobot with_trouble(HiddenRobot hidden, std::optional<Trouble> trouble) {
  Robot& robot = hidden.robot;
  if (trouble == Trouble::wrong_tip) {
    robot.chain.links.back().p += Eigen::Vector3d::Constant(0.05 / std::sqrt(3.0));
  } else if (trouble == Trouble::gripper_missing) {
    double mass = 0.0;
    for (const Inertial& body : robot.inertials) {
      mass += 0.05 * body[9];
    }
    const Eigen::Matrix3d ball = 0.4 * mass * 0.03 * 0.03 * Eigen::Matrix3d::Identity();  // of 30 mm radius
    robot.inertials.back() += inertial_from_com(mass, {0.05, 0.03, 0.1}, ball);
  } else if (trouble == Trouble::coupling) {
    couple(robot);
  }
  if (trouble == Trouble::coupling || trouble == Trouble::load_friction) {
    for (Joint& joint : robot.joints) {
      joint.friction = trouble == Trouble::coupling ? Friction::coulomb : Friction::load;
    }
  }
  hidden.chi_st = robot.chi_st();
  const std::vector<StandardParameter> all = robot.standard_parameters();
  for (std::size_t k = 0; trouble == Trouble::load_friction && k < all.size(); ++k) {
    if (all[k].kind == ParameterKind::Fl) {
      hidden.chi_st[static_cast<Index>(k)] = 0.1;
    }
  }
  return hidden;
}

}  // namespace rivid::detail
