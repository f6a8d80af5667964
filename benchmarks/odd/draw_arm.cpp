#include "odd/draw_arm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace rivid::odd {

namespace {

constexpr double right_angle = 0.5 * std::numbers::pi;
constexpr double prismatic_share = 0.06;

// Mostly along the axes, as arms are built.
double drawn_angle(Random& random) {
  return random.chance(0.85) ? right_angle * random.integer(-1, 1) : random.uniform(0.4, 1.2) * random.sign();
}

ArmJoint drawn_joint(bool first, Random& random) {
  ArmJoint out;
  out.prismatic = !first && random.chance(prismatic_share);
  out.rpy = {drawn_angle(random), 0.0, drawn_angle(random)};
  if (first && random.chance(0.6)) {
    out.rpy.setZero();  // a base that turns about the vertical
  }
  const double a = random.chance(0.6) ? random.uniform(0.15, 0.45) : 0.0;
  const double d = random.chance(0.5) ? random.uniform(0.1, 0.4) : 0.0;
  out.xyz = {a, 0.0, d};
  const bool parallel = !first && out.rpy.x() == 0.0;
  if (parallel && a == 0.0) {
    out.xyz.x() = random.uniform(0.15, 0.45);  // else the axis would be that of the parent
  }
  constexpr std::array<std::array<double, 3>, 3> others = {
      {{0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}}};
  if (random.chance(0.2)) {
    const auto axis = random.one_of(others);
    out.axis = {axis[0], axis[1], axis[2]};
  }
  return out;
}

// An ellipsoid along the way to the next joint.
Body drawn_body(double mass, const Vector3d& to_next, Random& random) {
  Body out;
  out.mass = mass;
  const double length = std::max(0.1, to_next.norm());
  out.com = 0.5 * to_next + random.uniform(0.1, 0.3) * length * random.direction();
  const Vector3d half = {0.5 * length, random.uniform(0.15, 0.4) * length,
                         random.uniform(0.15, 0.4) * length};
  const Vector3d squares = half.cwiseAbs2() / 5.0;
  const Matrix3d principal = mass * (squares.sum() * Vector3d::Ones() - squares).asDiagonal().toDenseMatrix();
  const Matrix3d R = rotation(std::numbers::pi * random.direction());
  out.inertia_com = R * principal * R.transpose();
  return out;
}

JointFriction drawn_friction(const Recipe& recipe, double rms, double speed, Random& random) {
  JointFriction out;
  const double Fc = recipe.friction * random.uniform(0.05, 0.2) * rms;
  const double Fv = random.uniform(0.3, 1.5) * Fc / (std::sqrt(recipe.friction) * speed);
  const double skew = recipe.asymmetry * random.sign();
  out.Fc_plus = Fc * (1.0 + 0.5 * skew);
  out.Fc_minus = Fc * (1.0 - 0.5 * skew);
  out.Fv_plus = Fv * (1.0 + 0.5 * skew);
  out.Fv_minus = Fv * (1.0 - 0.5 * skew);
  out.offset = random.uniform(-0.2, 0.2) * Fc;
  out.stribeck = recipe.stribeck * Fc;
  out.stribeck_speed = random.uniform(0.05, 0.2) * speed;
  out.load = recipe.load_friction;
  out.Fl = recipe.Fl;
  out.Fr = recipe.Fr * Fc / std::sqrt(speed);
  return out;
}

void add_oddities(const Recipe& recipe, const Load& load, Machine& out, Random& random) {
  const Index n = out.size();
  out.drift = recipe.drift;
  out.drift_time = 0.5 * recipe.duration;
  if (recipe.elastic_hz > 0.0) {
    out.stiffness.resize(n);
    out.damping.resize(n);
    for (Index j = 0; j < n; ++j) {
      const double link = std::max(0.1 * load.inertia[j], load.inertia[j] - out.Ia[j]);
      const double omega = 2.0 * std::numbers::pi * recipe.elastic_hz * random.uniform(1.0, 1.5);
      out.stiffness[j] = link * omega * omega;
      out.damping[j] = 2.0 * 0.05 * link * omega;
      // Motors so light that the spring would be stiff are of no interest.
      out.Ia[j] = std::max(out.Ia[j], 0.1 * link);
    }
  }
  if (recipe.ripple > 0.0) {
    out.ripple = recipe.ripple * load.rms;
    out.ripple_cycles.resize(n);
    for (double& cycles : out.ripple_cycles) {
      cycles = random.uniform(2.0, 12.0);
    }
  }
  out.backlash = 0.5 * recipe.backlash;
  if (n > 1) {
    out.spring = recipe.spring * load.rms[1];
  }
  if (recipe.payload > 0.0) {
    double mass = 0.0;
    for (Index j = std::max<Index>(0, n - 3); j < n; ++j) {
      mass += out.arm.joints[static_cast<std::size_t>(j)].body.mass;
    }
    const double r = 0.05;
    Body body{.mass = recipe.payload * mass, .com = 0.15 * random.direction(), .inertia_com = {}};
    body.inertia_com = 0.4 * body.mass * r * r * Matrix3d::Identity();
    const double from = random.uniform(0.3, 0.7) * recipe.duration;
    out.payload = Machine::Payload{.body = body, .from = from};
    if (recipe.put_down) {
      out.payload->until = from + 0.2 * recipe.duration;
    }
  }
}

}  // namespace

Arm drawn_arm(const Recipe& recipe, Random& random) {
  Arm out;
  const double size = random.log_uniform(0.5, 1.5);
  double mass = random.uniform(6.0, 20.0) * size * size;
  for (int j = 0; j < recipe.joints; ++j) {
    out.joints.push_back(drawn_joint(j == 0, random));
    if (recipe.gantry && j < 3) {
      // Each along its z axis, which the turn of a right angle lays across the one before.
      out.joints.back().prismatic = true;
      out.joints.back().axis = Vector3d::UnitZ();
      out.joints.back().rpy = {right_angle * random.sign(), 0.0, j == 0 ? 0.0 : right_angle};
    }
    out.joints.back().xyz *= size;
  }
  for (int j = 0; j < recipe.joints; ++j) {
    const bool last = j + 1 == recipe.joints;
    const Vector3d to_next = last ? Vector3d(size * random.uniform(0.1, 0.25) * random.direction())
                                  : out.joints[static_cast<std::size_t>(j) + 1].xyz;
    out.joints[static_cast<std::size_t>(j)].body = drawn_body(mass, to_next, random);
    mass *= random.uniform(0.55, 0.9);
  }
  return out;
}

Load load_of(const Arm& arm, const Numbers& Ia, const RandomMotion& motion) {
  const ArmDynamics dynamics(arm);
  const Index n = arm.size();
  Load out{.inertia = Numbers::Zero(n), .rms = Numbers::Zero(n), .largest = Numbers::Zero(n)};
  constexpr int instants = 200;
  for (int i = 0; i < instants; ++i) {
    const ReferencePoint at = motion.at(motion.duration() * i / instants);
    const Numbers tau = dynamics.torques(at.q, at.qd, at.qdd) + Ia.cwiseProduct(at.qdd);
    out.inertia = out.inertia.cwiseMax(Numbers(dynamics.mass(at.q).diagonal()) + Ia);
    out.rms += tau.cwiseAbs2() / instants;
    out.largest = out.largest.cwiseMax(tau.cwiseAbs());
  }
  out.rms = out.rms.cwiseSqrt();
  return out;
}

Machine drawn_machine(const Recipe& recipe, const Arm& arm, const RandomMotion& motion, Random& random) {
  Machine out;
  out.arm = arm;
  const Index n = arm.size();
  out.Ia = Numbers::Zero(n);
  const Numbers links = load_of(arm, out.Ia, motion).inertia;
  for (Index j = 0; j < n; ++j) {
    out.Ia[j] = recipe.rotors ? random.uniform(0.1, 0.8) * links[j] : 0.0;
  }
  const Load load = load_of(arm, out.Ia, motion);
  for (Index j = 0; j < n; ++j) {
    const double unit = arm.joints[static_cast<std::size_t>(j)].prismatic ? 0.25 : 1.0;
    // What the joint would need for an ordinary motion, where this one needs little.
    const double usual = std::max(load.rms[j], 0.5 * unit * load.inertia[j]);
    out.friction.push_back(drawn_friction(recipe, usual, unit, random));
  }
  add_oddities(recipe, load, out, random);
  return out;
}

}  // namespace rivid::odd
