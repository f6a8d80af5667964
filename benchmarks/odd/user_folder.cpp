#include "odd/user_folder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "odd/draw_arm.hpp"
#include "odd/session.hpp"

namespace rivid::odd {

namespace {

constexpr int position_digits = 11;
constexpr int torque_digits = 7;
constexpr double to_degrees = 180.0 / std::numbers::pi;

void append(std::string& to, double value, int digits) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  to.append(text.data(), end.ptr);
}

std::string in_urdf(const Vector3d& v) {
  constexpr int all_digits = 17;
  std::string out;
  for (const double value : v) {
    out += out.empty() ? "" : " ";
    append(out, value == 0.0 ? 0.0 : value, all_digits);
  }
  return out;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) {
    throw std::runtime_error("can not write " + file.string());
  }
}

std::string csv_of(const Recording& log, bool with_reference) {
  std::string out = "t";
  const auto name_columns = [&](const char* name) {
    for (Index j = 1; j <= log.q.cols(); ++j) {
      out += ',' + std::string(name) + std::to_string(j);
    }
  };
  name_columns("q");
  name_columns("tau");
  if (with_reference) {
    name_columns("qref");
  }
  out += '\n';
  const auto append_row = [&](const Matrix& columns, Index row, int digits) {
    for (Index j = 0; j < columns.cols(); ++j) {
      out += ',';
      append(out, columns(row, j), digits);
    }
  };
  for (Index k = 0; k < log.t.size(); ++k) {
    append(out, log.t[k], position_digits);
    append_row(log.q, k, position_digits);
    append_row(log.tau, k, torque_digits);
    if (with_reference) {
      append_row(log.q_r, k, position_digits);
    }
    out += '\n';
  }
  return out;
}

// Which joint the user is wrong about, and how.
class Belief {
 public:
  Belief(const Recipe& recipe, const Arm& arm, Random& random) : recipe_(recipe) {
    const int last = static_cast<int>(arm.size()) - 1;
    const bool geometry =
        recipe.belief == Recipe::Belief::shifted_joint || recipe.belief == Recipe::Belief::turned_joint;
    // Where the first joint stands in the base frame shows in no torque.
    joint_ = random.integer(geometry ? 1 : 0, last);
    other_ = (joint_ + random.integer(1, last)) % (last + 1);
    direction_ = random.direction();
    torques_ = random.chance(0.5);
  }

  // Gravity as it is, where the user's URDF has it along −z.
  void turn_gravity(Arm& truth) const {
    const double g = truth.gravity.norm();
    if (recipe_.belief == Recipe::Belief::tilted) {
      const Vector3d across = Vector3d(direction_.x(), direction_.y(), 0.0).normalized();
      truth.gravity = Eigen::AngleAxisd(recipe_.turn, across) * truth.gravity;
    } else if (recipe_.belief == Recipe::Belief::on_a_wall) {
      const std::array<Vector3d, 3> others = {Vector3d(g, 0.0, 0.0), Vector3d(0.0, -g, 0.0),
                                              Vector3d(0.0, 0.0, g)};
      truth.gravity = others[static_cast<std::size_t>(other_) % others.size()];
    }
  }

  // The arm as the user describes it.
  [[nodiscard]] Arm believed(Arm arm) const {
    ArmJoint& joint = arm.joints[static_cast<std::size_t>(joint_)];
    if (recipe_.belief == Recipe::Belief::shifted_joint) {
      joint.xyz += recipe_.shift * direction_;
    } else if (recipe_.belief == Recipe::Belief::turned_joint) {
      const Matrix3d turned = rotation(joint.rpy) * Eigen::AngleAxisd(recipe_.turn, direction_);
      joint.rpy = rpy_of(turned);
    }
    return arm;
  }

  // The columns as the user has them.
  void tell(const Arm& arm, Recording& log) const {
    switch (recipe_.belief) {
      case Recipe::Belief::torque_sign:
        log.tau.col(joint_) *= -1.0;
        break;
      case Recipe::Belief::swapped: {
        Matrix& columns = torques_ ? log.tau : log.q;
        columns.col(joint_).swap(columns.col(other_));
        break;
      }
      case Recipe::Belief::deg_rad:
        for (Index j = 0; j < log.q.cols(); ++j) {
          if (!arm.joints[static_cast<std::size_t>(j)].prismatic) {
            log.q.col(j) *= to_degrees;
            log.q_r.col(j) *= to_degrees;
          }
        }
        break;
      case Recipe::Belief::mNm:
        log.tau.col(joint_) *= 1e3;
        break;
      case Recipe::Belief::gain_and_zero:
        log.q.col(other_).array() += recipe_.turn;
        log.q_r.col(other_).array() += recipe_.turn;
        [[fallthrough]];
      case Recipe::Belief::gain:
        log.tau.col(joint_) *= recipe_.gain_factor;
        break;
      case Recipe::Belief::coupled:
        // A motor that turns the other joint too: its position is a sum, and the other motor bears less.
        log.q.col(joint_) += recipe_.coupling * log.q.col(other_);
        log.q_r.col(joint_) += recipe_.coupling * log.q_r.col(other_);
        log.tau.col(other_) -= recipe_.coupling * log.tau.col(joint_);
        break;
      case Recipe::Belief::zero_offset:
        log.q.col(joint_).array() += recipe_.turn;
        log.q_r.col(joint_).array() += recipe_.turn;
        break;
      default:
        break;
    }
  }

  // The frame of the last link is where the user's readings have it: with another zero the same arm, of which
  // no torque tells, has its last body turned in that frame.
  void turn_last_body(Arm& truth) const {
    ArmJoint& last = truth.joints.back();
    if (recipe_.belief != Recipe::Belief::zero_offset || joint_ + 1 != truth.size()) {
      return;
    }
    if (last.prismatic) {
      last.body.com -= recipe_.turn * last.axis;
      return;
    }
    const Matrix3d back = Eigen::AngleAxisd(-recipe_.turn, last.axis).toRotationMatrix();
    last.body.com = back * last.body.com;
    last.body.inertia_com = back * last.body.inertia_com * back.transpose();
  }

 private:
  const Recipe& recipe_;
  int joint_ = 0;
  int other_ = 0;
  Vector3d direction_;
  bool torques_ = true;
};

void misjudge_bodies(Arm& arm, Random& random) {
  for (ArmJoint& joint : arm.joints) {
    const double factor = random.log_uniform(0.4, 2.5);
    joint.body.mass *= factor;
    joint.body.inertia_com *= factor;
    joint.body.com *= random.uniform(0.5, 1.5);
  }
}

void describe_bodies(Recipe::Bodies bodies, Arm& arm, Random& random) {
  switch (bodies) {
    case Recipe::Bodies::right:
      break;
    case Recipe::Bodies::off:
      misjudge_bodies(arm, random);
      break;
    case Recipe::Bodies::alike:
      for (ArmJoint& joint : arm.joints) {
        joint.body = {.mass = 1.0, .inertia_com = Matrix3d::Identity()};
      }
      break;
    case Recipe::Bodies::none:
      for (ArmJoint& joint : arm.joints) {
        joint.body = {};
      }
      break;
  }
}

Truth attempt(const Name& name, const std::filesystem::path& folder, Random& random) {
  Truth out{.recipe = drawn_recipe(*name.kind, name.way, random, name.sound), .machine = {}};
  const Recipe& recipe = out.recipe;
  Arm arm = drawn_arm(recipe, random);
  const Belief belief(recipe, arm, random);
  belief.turn_gravity(arm);
  std::vector<RandomMotion> motions;
  for (int k = 0; k < (recipe.other_arm ? 3 : 2); ++k) {
    motions.emplace_back(recipe, arm, random);
  }
  out.machine = drawn_machine(recipe, arm, motions[0], random);
  const Controller controller = drawn_controller(recipe, out.machine, motions[0], random);
  Numbers largest = Numbers::Zero(arm.size());
  for (std::size_t k = 0; k < motions.size(); ++k) {
    // What happens in the middle of a log happens in the first one: the second is as clean as the user knows.
    Machine machine = out.machine;
    if (k > 0) {
      machine.payload.reset();
    }
    if (recipe.other_arm && k == 1) {
      misjudge_bodies(machine.arm, random);
    }
    Recording log = recorded(recipe, Plant(machine), controller, motions[k], random);
    largest = largest.cwiseMax(Numbers(log.tau.cwiseAbs().colwise().maxCoeff().transpose()));
    spoil(recipe, log, random);
    belief.tell(arm, log);
    write_text(folder / ("log_" + std::to_string(k + 1) + ".csv"), csv_of(log, recipe.has_reference));
  }
  Arm described = belief.believed(arm);
  describe_bodies(recipe.bodies, described, random);
  write_text(folder / "robot.urdf", urdf_of(described, largest));
  belief.turn_last_body(out.machine.arm);
  return out;
}

}  // namespace

std::string Name::text() const {
  return std::string(kind->name) + '-' + (way != nullptr ? std::string(way->name) + '-' : "") +
         std::to_string(number);
}

Vector Truth::base_values(const BaseParameters& base) const {
  Vector chi_st(static_cast<Index>(base.standard.size()));
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto [kind, joint] = base.standard[i];
    const auto j = static_cast<std::size_t>(joint);
    const OriginInertia body(machine.arm.joints[j].body);
    const JointFriction& friction = machine.friction[j];
    const std::array<double, 14> values = {
        body.I(0, 0), body.I(0, 1), body.I(0, 2), body.I(1, 1), body.I(1, 2), body.I(2, 2), body.h.x(),
        body.h.y(), body.h.z(), body.m, machine.Ia[joint],
        // Where directions differ these are no truth, only near it: friction is not judged there.
        0.5 * (friction.Fv_plus + friction.Fv_minus), 0.5 * (friction.Fc_plus + friction.Fc_minus),
        friction.offset + 0.5 * (friction.Fc_plus - friction.Fc_minus)};
    const auto at = static_cast<std::size_t>(kind);
    chi_st[static_cast<Index>(i)] = kind == ParameterKind::Fl   ? friction.load + friction.Fl
                                    : kind == ParameterKind::Fr ? friction.Fr
                                                                : values.at(at);
  }
  return base.from_standard(chi_st);
}

Truth write_experiment(const Name& name, const std::filesystem::path& folder) {
  Random random(name.seed, name.kind->name, name.number);
  constexpr int most_attempts = 50;
  for (int k = 0; k < most_attempts; ++k) {
    try {
      return attempt(name, folder, random);
    } catch (const Diverged&) {
      // Another controller of another arm.
    }
  }
  throw std::runtime_error(name.text() + ": no stable loop was found");
}

std::string urdf_of(const Arm& arm, const Numbers& largest_torque) {
  constexpr double effort_margin = 1.5;
  std::ostringstream out;
  out.precision(17);
  out << "<?xml version=\"1.0\"?>\n<robot name=\"odd_" << arm.size() << "\">\n  <link name=\"base\"/>\n";
  for (Index j = 0; j < arm.size(); ++j) {
    const ArmJoint& joint = arm.joints[static_cast<std::size_t>(j)];
    const Body& body = joint.body;
    const Matrix3d& I = body.inertia_com;
    const std::string number = std::to_string(j + 1);
    const double reach = joint.prismatic ? 1.0 : 2.0 * std::numbers::pi;
    out << "  <link name=\"link_" << number << "\">\n";
    if (body.mass > 0.0) {
      out << "    <inertial>\n      <origin xyz=\"" << in_urdf(body.com) << "\"/>\n      <mass value=\""
          << body.mass << "\"/>\n      <inertia ixx=\"" << I(0, 0) << "\" ixy=\"" << I(0, 1) << "\" ixz=\""
          << I(0, 2) << "\" iyy=\"" << I(1, 1) << "\" iyz=\"" << I(1, 2) << "\" izz=\"" << I(2, 2)
          << "\"/>\n    </inertial>\n";
    }
    out << "  </link>\n  <joint name=\"joint_" << number << "\" type=\""
        << (joint.prismatic ? "prismatic" : "revolute") << "\">\n    <parent link=\""
        << (j == 0 ? "base" : "link_" + std::to_string(j)) << "\"/>\n"
        << "    <child link=\"link_" << number << "\"/>\n    <origin xyz=\"" << in_urdf(joint.xyz)
        << "\" rpy=\"" << in_urdf(joint.rpy) << "\"/>\n    <axis xyz=\"" << in_urdf(joint.axis)
        << "\"/>\n    <limit lower=\"" << -reach << "\" upper=\"" << reach << "\" velocity=\"10\" effort=\""
        << effort_margin * std::max(1.0, largest_torque[j]) << "\"/>\n  </joint>\n";
  }
  out << "</robot>\n";
  return out.str();
}

}  // namespace rivid::odd
