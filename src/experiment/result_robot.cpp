#include "experiment/result_robot.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <ranges>
#include <utility>

namespace rivid::detail {

namespace {

// Of frames and of gravity, as files of other programs round them.
constexpr double tolerance = 1e-9;

std::string_view word(JointType type) { return type == JointType::revolute ? "revolute" : "prismatic"; }

JointType joint_type(const JsonNode& node) {
  const std::string found = node.text();
  for (const JointType type : {JointType::revolute, JointType::prismatic}) {
    if (found == word(type)) {
      return type;
    }
  }
  node.fail("is " + in_quotes(found) + ", must be \"revolute\" or \"prismatic\"");
}

Eigen::Vector3d vector3(const JsonNode& node) { return Eigen::Vector3d(node.numbers(3).data()); }

// Each row as long as there are rows.
Matrix square(const JsonNode& node) {
  const std::vector<JsonNode> rows = node.list();
  const auto n = static_cast<Index>(rows.size());
  Matrix out(n, n);
  for (Index i = 0; i < n; ++i) {
    const std::vector<double> row = rows[static_cast<std::size_t>(i)].numbers(rows.size());
    out.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), n);
  }
  return out;
}

Chain::Link link(const JsonNode& frame, JointType type) {
  Chain::Link out;
  out.type = type;
  const JsonNode rotation = frame.at("rotation");
  const Matrix R = square(rotation);
  if (R.rows() != 3 || !(R.transpose() * R).isIdentity(tolerance) || R.determinant() < 0.0) {
    rotation.fail("is no rotation");
  }
  out.R = R;
  out.p = vector3(frame.at("origin"));
  const JsonNode axes = frame.at("axes");
  const std::vector<double> signed_axes = axes.numbers(3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double axis = std::abs(signed_axes[k]);
    if (axis != 1.0 && axis != 2.0 && axis != 3.0) {
      axes.fail("must hold 1, 2 and 3, each with a sign");
    }
    out.axes[k] = static_cast<int>(axis) - 1;
    out.signs[k] = signed_axes[k] > 0.0 ? 1 : -1;
  }
  if (std::abs(link_axes(out).determinant()) != 1.0) {
    axes.fail("must hold 1, 2 and 3, each with a sign");
  }
  return out;
}

Joint joint(const JsonNode& node) {
  Joint out;
  out.name = node.at("name").text();
  out.link = node.at("link").text();
  out.type = joint_type(node.at("type"));
  out.friction = node.at("friction").choice(friction_rows | std::views::transform(&FrictionRow::law));
  out.sign_speed = node.at("sign_speed").number();
  out.rotor_inertia = node.at("rotor_inertia").boolean();
  out.drive_gain = node.at("drive_gain").number();
  out.gear_ratio = node.at("gear_ratio").number();
  return out;
}

int joint_index(const JsonNode& node, const Robot& robot) {
  const std::string wanted = node.text();
  const auto at = std::ranges::find(robot.joints, wanted, &Joint::name);
  if (at == robot.joints.end()) {
    node.fail("is " + in_quotes(wanted) + ", which is no joint of the robot");
  }
  return static_cast<int>(at - robot.joints.begin());
}

Coupling coupling(const JsonNode& node, const Robot& robot) {
  using enum Coupling::Coulomb;
  Coupling out;
  out.motor = joint_index(node.at("motor"), robot);
  for (const JsonNode& other : node.at("joints").list()) {
    out.joints.push_back(joint_index(other, robot));
  }
  out.ratios = node.at("ratios").numbers();
  out.inertia =
      node.at("inertia").choice({Coupling::Inertia::none, Coupling::Inertia::free, Coupling::Inertia::tied});
  out.viscous = node.at("viscous").boolean();
  out.coulomb = node.at("coulomb").choice({none, sum, single});
  out.terms = node.at("terms").choice({Coupling::Terms::cross, Coupling::Terms::all});
  return out;
}

std::string in_words(const Eigen::Vector3d& x) {
  return "[" + number(x.x()) + ", " + number(x.y()) + ", " + number(x.z()) + "]";
}

}  // namespace

Robot result_robot(const JsonNode& robot) {
  Robot out;
  out.name = robot.at("name").text();
  out.base = robot.at("base").text();
  out.chain.gravity = vector3(robot.at("gravity"));
  for (const JsonNode& node : robot.at("joints").list()) {
    out.joints.push_back(joint(node));
    out.chain.links.push_back(link(node.at("frame"), out.joints.back().type));
  }
  out.inertials.assign(out.joints.size(), Inertial::Zero());
  for (const JsonNode& node : robot.at("coupling").list()) {
    out.couplings.push_back(coupling(node, out));
  }
  if (const JsonNode gears = robot.at("gear_matrix"); !gears.json().is_null()) {
    out.gear_matrix = square(gears);
  }
  if (const auto complaint = out.complaint()) {
    robot.fail("can not be used: " + *complaint);
  }
  return out;
}

void expect_same_geometry(const JsonNode& node, const Robot& result, const Robot& robot) {
  const auto differs = [&](const std::string& what, const std::string& found, const std::string& wanted) {
    node.fail("is another one than \"" + robot.name + "\": " + what + " is " + found + " here and " + wanted +
              " there");
  };
  if (result.size() != robot.size()) {
    differs("the number of joints", std::to_string(result.size()), std::to_string(robot.size()));
  }
  if ((result.chain.gravity - robot.chain.gravity).cwiseAbs().maxCoeff() > tolerance) {
    differs("gravity", in_words(result.chain.gravity), in_words(robot.chain.gravity));
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& here = result.joints[j];
    const Joint& there = robot.joints[j];
    if (here.name != there.name) {
      differs("joint " + std::to_string(j + 1), in_quotes(here.name), in_quotes(there.name));
    }
    const std::string who = "joint \"" + there.name + "\": ";
    if (here.type != there.type) {
      differs(who + "its type", std::string(word(here.type)), std::string(word(there.type)));
    }
    const Chain::Link& frame = result.chain.links[j];
    const Chain::Link& other = robot.chain.links[j];
    if ((frame.p - other.p).cwiseAbs().maxCoeff() > tolerance) {
      differs(who + "its origin in the frame before it", in_words(frame.p), in_words(other.p));
    }
    if ((frame.R - other.R).cwiseAbs().maxCoeff() > tolerance) {
      differs(who + "its axis z in the frame before it", in_words(frame.R.col(2)), in_words(other.R.col(2)));
    }
  }
}

}  // namespace rivid::detail
