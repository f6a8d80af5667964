#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "dense.hpp"
#include "rivid/text.hpp"
#include "urdf_document.hpp"

namespace rivid::detail {

namespace {

constexpr double inertia_tolerance =
    1e-6;  // of the largest principal moment: figures are printed with few digits
constexpr double axis_length_tolerance = 1e-3;  // relative to 1: axes are printed with few digits
constexpr double infinity = std::numeric_limits<double>::infinity();

std::string link_who(const std::string& name) { return "link \"" + name + "\""; }
std::string joint_who(const std::string& name) { return "joint \"" + name + "\""; }

template <typename... Parts>
std::string concatenated(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

using rivid::exact;
std::string exact(const Eigen::Vector3d& v) { return exact(v.x()) + ' ' + exact(v.y()) + ' ' + exact(v.z()); }

void set(pugi::xml_node node, const char* attribute, const std::string& value) {
  node.append_attribute(attribute).set_value(value.c_str());
}

struct Limits {
  double lower = -infinity;
  double upper = infinity;
  double velocity = infinity;
  double effort = infinity;
};

// Reads the elements one by one, collects warnings and writes the plain form.
class Checker {
 public:
  Checker(const UrdfDocument& document, const UrdfOptions& options)
      : document_(document),
        tree_(urdf_topology(document)),
        path_(urdf_path(document, tree_, options)),
        dependent_(options.dependent),
        role_(tree_.joints.size(), Role::elsewhere),
        counts_(tree_.links.size(), false) {
    for (const int joint : path_.joints) {
      role_[static_cast<std::size_t>(joint)] = Role::chain;
    }
    visit_moving_links([&](int link, int /*carrier*/) {
      counts_[static_cast<std::size_t>(link)] = true;
      visit_branches(link, [&](const UrdfTopology::Joint& joint) {
        counts_[static_cast<std::size_t>(joint.child)] = true;
      });
    });
  }

  CheckedUrdf run() {
    warn_of_branches();
    const pugi::xml_node robot = plain_.append_child("robot");
    const std::string_view name = document_.robot().attribute("name").value();
    set(robot, "name", name.empty() ? "robot" : std::string(name));
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      write_link(robot, tree_.links[i], counts_[i]);
    }
    for (std::size_t i = 0; i < tree_.joints.size(); ++i) {
      write_joint(robot, tree_.joints[i], role_[i]);
    }
    warn_of_empty_links();
    warn_of_the_base();
    warn_of_transmissions();
    std::ostringstream text;
    plain_.save(text);
    CheckedUrdf out{text.str(), tree_.link(path_.base).name, {}, warnings_, dependent_};
    for (const int joint : path_.joints) {
      out.links.push_back(tree_.link(tree_.joint(joint).child).name);
    }
    return out;
  }

 private:
  enum class Role { elsewhere, chain };

  void warn(pugi::xml_node node, const std::string& message) {
    warnings_.push_back(Finding{"robot_doubt", {}, document_.where(node) + message});
  }

  void write_origin(pugi::xml_node to, pugi::xml_node from, const std::string& who) {
    const pugi::xml_node origin = document_.only_child(from, "origin", who);
    if (origin.attribute("quat_xyzw")) {
      document_.refuse(origin,
                       who + ": <origin> has quat_xyzw, which is not supported; write the rotation as rpy");
    }
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    const pugi::xml_node out = to.append_child("origin");
    set(out, "xyz", exact(document_.triple_or(zero, origin, "xyz", who)));
    set(out, "rpy", exact(document_.triple_or(zero, origin, "rpy", who)));
  }

  // An impossible body is refused where it moves with the robot. Elsewhere it does no harm.
  void refuse_body(pugi::xml_node node, const std::string& complaint, bool counts) {
    if (counts) {
      document_.refuse(node, complaint);
    }
    warn(node, complaint + "; the link does not move with the robot, its <inertial> has no effect");
  }

  void write_link(pugi::xml_node robot, const UrdfTopology::Link& link, bool counts) {
    pugi::xml_node plain_link = robot.append_child("link");
    set(plain_link, "name", link.name);
    const std::string who = link_who(link.name);
    const pugi::xml_node inertial = document_.only_child(link.node, "inertial", who);
    if (!inertial) {
      return;
    }
    pugi::xml_node out = plain_link.append_child("inertial");
    write_origin(out, inertial, who);

    const pugi::xml_node mass_node = document_.only_child(inertial, "mass", who);
    const pugi::xml_node inertia_node = document_.only_child(inertial, "inertia", who);
    if (!mass_node || !inertia_node) {
      document_.refuse(inertial, who + ": its <inertial> has no <" + (mass_node ? "inertia" : "mass") + ">");
    }
    const double mass = document_.number(mass_node, "value", who);
    if (mass < 0.0) {
      refuse_body(mass_node, concatenated(who, ": mass is ", mass, " kg, must not be negative"), counts);
    }
    set(out.append_child("mass"), "value", exact(mass));
    std::array<double, 6> I{};
    const pugi::xml_node inertia_out = out.append_child("inertia");
    for (std::size_t i = 0; i < I.size(); ++i) {
      I[i] = document_.number(inertia_node, urdf_tensor_names[i], who);
      set(inertia_out, urdf_tensor_names[i], exact(I[i]));
    }
    check_inertia(inertia_node, who, mass, I, counts);
  }

  void check_inertia(pugi::xml_node node, const std::string& who, double mass, const std::array<double, 6>& I,
                     bool counts) {
    const Eigen::Matrix3d tensor = symmetric_tensor(I.data());
    const double size = tensor.cwiseAbs().maxCoeff();
    if (mass == 0.0 && size > 0.0) {
      refuse_body(node, who + ": mass is 0 kg, but its inertia is not zero; a body without mass has none",
                  counts);
    }
    if (size == 0.0) {
      return;
    }
    // Scaled, so that huge and tiny figures neither overflow nor vanish.
    const Eigen::Vector3d moments = size * symmetric_eigenvalues(tensor / size);
    const std::string principal = concatenated(moments[0], ", ", moments[1], ", ", moments[2], " kg·m²");
    if (moments[0] < -inertia_tolerance * size) {
      refuse_body(node, who + ": its inertia is not positive semidefinite: principal moments " + principal,
                  counts);
    } else if (counts && moments[0] + moments[1] < moments[2] * (1.0 - inertia_tolerance)) {
      warn(node, who + ": its inertia is physically inconsistent: of the principal moments " + principal +
                     " the largest must not exceed the sum of the others");
    }
  }

  void write_joint(pugi::xml_node robot, const UrdfTopology::Joint& joint, Role role) {
    const std::string who = joint_who(joint.name);
    const bool one_axis = joint.type == "revolute" || joint.type == "continuous" || joint.type == "prismatic";
    if (role == Role::chain && joint.moves()) {
      if (!one_axis) {
        document_.refuse(joint.node,
                         who + ": is of type " + joint.type +
                             "; only revolute, continuous, prismatic and fixed joints can be identified");
      }
      if (joint.mimic() &&
          std::ranges::find(dependent_, joint.name, &DependentJoint::joint) == dependent_.end()) {
        take_mimic(joint, who);
      }
    }
    pugi::xml_node out = robot.append_child("joint");
    set(out, "name", joint.name);
    set(out, "type", one_axis && !joint.held ? joint.type : "fixed");
    write_origin(out, joint.node, who);
    set(out.append_child("parent"), "link", tree_.link(joint.parent).name);
    set(out.append_child("child"), "link", tree_.link(joint.child).name);
    if (one_axis && !joint.held) {
      write_axis(out, joint, who);
      write_limits(out, joint, who, role);
      write_dynamics(out, joint, who);
    }
  }

  void take_mimic(const UrdfTopology::Joint& joint, const std::string& who) {
    const pugi::xml_node mimic = joint.mimic();
    const bool moves = std::ranges::any_of(
        path_.joints, [&](int k) { return tree_.joint(k).moves() && tree_.joint(k).name == joint.leader(); });
    if (!moves) {
      document_.refuse(
          mimic, who + ": follows joint \"" + joint.leader() + "\" (mimic), which is none of the robot's");
    }
    dependent_.push_back({.joint = joint.name,
                          .of = {{joint.leader(), document_.number_or(1.0, mimic, "multiplier", who)}},
                          .offset = document_.number_or(0.0, mimic, "offset", who)});
  }

  void write_axis(pugi::xml_node out, const UrdfTopology::Joint& joint, const std::string& who) {
    const pugi::xml_node node = document_.only_child(joint.node, "axis", who);
    if (node && !node.attribute("xyz")) {
      document_.refuse(node, who + ": <axis> has no xyz");
    }
    const Eigen::Vector3d axis = document_.triple_or(Eigen::Vector3d::UnitX(), node, "xyz", who);
    const double length = axis.stableNorm();
    if (length == 0.0) {
      document_.refuse(node,
                       who + ": its axis is \"" + node.attribute("xyz").value() + "\", must not be zero");
    }
    if (std::abs(length - 1.0) > axis_length_tolerance) {
      warn(node, concatenated(who, ": its axis \"", node.attribute("xyz").value(), "\" has the length ",
                              length, "; taken as a direction"));
    }
    // Divided twice, since the square of a huge or tiny length would not be finite.
    set(out.append_child("axis"), "xyz",
        exact(Eigen::Vector3d((axis / axis.cwiseAbs().maxCoeff()).normalized())));
  }

  // Files out of CAD programs hold zeros where nothing was filled in.
  double positive_limit(pugi::xml_node node, const char* attribute, const std::string& who, bool tell) {
    const double value = document_.number_or(infinity, node, attribute, who);
    if (value < 0.0) {
      document_.refuse(node,
                       concatenated(who, ": its ", attribute, " limit is ", value, ", must not be negative"));
    }
    if (tell && (value == 0.0 || value == infinity)) {
      warn(node, who + ": its " + attribute + " limit is " + (value == 0.0 ? "0" : "not given") +
                     "; taken as unlimited");
    }
    return value == 0.0 ? infinity : value;
  }

  Limits limits(const UrdfTopology::Joint& joint, const std::string& who, bool tell) {
    Limits out;
    const pugi::xml_node node = document_.only_child(joint.node, "limit", who);
    const bool bounded = joint.type != "continuous";
    if (!node) {
      if (tell && bounded) {
        warn(joint.node, who + ": has no <limit>; taken as unlimited");
      }
      return out;
    }
    out.velocity = positive_limit(node, "velocity", who, tell);
    out.effort = positive_limit(node, "effort", who, tell);
    const double lower = document_.number_or(0.0, node, "lower", who);
    const double upper = document_.number_or(0.0, node, "upper", who);
    if (!bounded) {
      return out;
    }
    if (lower > upper) {
      document_.refuse(node,
                       concatenated(who, ": its lower limit ", lower, " is above its upper limit ", upper));
    }
    if (lower < upper) {
      out.lower = lower;
      out.upper = upper;
    } else if (tell) {
      warn(node, concatenated(who, ": its position limits are both ", lower, "; taken as unlimited"));
    }
    return out;
  }

  void write_limits(pugi::xml_node out, const UrdfTopology::Joint& joint, const std::string& who, Role role) {
    const Limits values = limits(joint, who, role == Role::chain);
    const pugi::xml_node node = out.append_child("limit");
    set(node, "lower", exact(std::max(values.lower, -urdf_unlimited)));
    set(node, "upper", exact(std::min(values.upper, urdf_unlimited)));
    set(node, "velocity", exact(std::min(values.velocity, urdf_unlimited)));
    set(node, "effort", exact(std::min(values.effort, urdf_unlimited)));
  }

  void write_dynamics(pugi::xml_node out, const UrdfTopology::Joint& joint, const std::string& who) {
    const pugi::xml_node node = document_.only_child(joint.node, "dynamics", who);
    if (!node) {
      return;
    }
    const pugi::xml_node dynamics = out.append_child("dynamics");
    for (const char* attribute : {"damping", "friction"}) {
      const double value = document_.number_or(0.0, node, attribute, who);
      if (value < 0.0) {
        document_.refuse(node,
                         concatenated(who, ": its ", attribute, " is ", value, ", must not be negative"));
      }
      set(dynamics, attribute, exact(value));
    }
  }

  // Links that move as one with the chain's link, when the joints of branches stand still.
  template <typename Visit>
  void visit_branches(int link, const Visit& visit) const {
    std::vector<int> open = {link};
    while (!open.empty()) {
      const int parent = open.back();
      open.pop_back();
      for (const int j : tree_.link(parent).children) {
        if (role_[static_cast<std::size_t>(j)] == Role::elsewhere) {
          visit(tree_.joint(j));
          open.push_back(tree_.joint(j).child);
        }
      }
    }
  }

  // The robot's links by what carries their parameters: the link of the last moving joint at or before each.
  template <typename Visit>
  void visit_moving_links(const Visit& visit) const {
    std::vector<int> carriers(tree_.links.size(), -1);
    for (const int j : path_.joints) {
      const UrdfTopology::Joint& joint = tree_.joint(j);
      int& carrier = carriers[static_cast<std::size_t>(joint.child)];
      carrier = joint.moves() ? joint.child : carriers[static_cast<std::size_t>(joint.parent)];
      if (carrier >= 0) {
        visit(joint.child, carrier);
      }
    }
  }

  // A hand may have forty joints: one warning a link.
  void warn_of_branches() {
    for (const int j : path_.joints) {
      if (const UrdfTopology::Joint& joint = tree_.joint(j); joint.held) {
        warn(joint.node, joint_who(joint.name) + ": lies on the way to joints of the robot but " +
                             (joint.mimic() ? "follows another one (mimic)" : "is none of them") +
                             "; held at q = 0");
      }
    }
    std::map<int, std::vector<const UrdfTopology::Joint*>> lumped;
    visit_moving_links([&](int link, int carrier) {
      visit_branches(link, [&](const UrdfTopology::Joint& joint) {
        if (joint.moves()) {
          lumped[carrier].push_back(&joint);
        }
      });
    });
    for (const auto& [carrier, joints] : lumped) {
      std::string names;
      for (const UrdfTopology::Joint* joint : joints) {
        names += (names.empty() ? "\"" : ", \"") + joint->name + "\"" + (joint->mimic() ? " (mimic)" : "");
      }
      const bool one = joints.size() == 1;
      warn(joints.front()->node, (one ? "one joint is" : std::to_string(joints.size()) + " joints are") +
                                     " no part of the robot: " + names + "; held at q = 0, what " +
                                     (one ? "it moves" : "they move") + " is lumped into link \"" +
                                     tree_.link(carrier).name + "\"");
    }
  }

  void warn_of_empty_links() {
    std::vector<bool> filled(tree_.links.size(), false);
    const auto fill = [&](int link, int carrier) {
      if (tree_.link(link).node.child("inertial")) {
        filled[static_cast<std::size_t>(carrier)] = true;
      }
    };
    visit_moving_links([&](int link, int carrier) {
      fill(link, carrier);
      visit_branches(link, [&](const UrdfTopology::Joint& joint) { fill(joint.child, carrier); });
    });
    visit_moving_links([&](int link, int carrier) {
      if (link == carrier && !filled[static_cast<std::size_t>(link)]) {
        warn(tree_.link(link).node, link_who(tree_.link(link).name) +
                                        ": has no <inertial>; its a-priori inertial parameters are zero");
      }
    });
  }

  void warn_of_the_base() {
    const UrdfTopology::Link& base = tree_.link(path_.base);
    if (const pugi::xml_node inertial = base.node.child("inertial")) {
      warn(inertial, link_who(base.name) + ": its <inertial> has no effect, since the base stands still");
    }
  }

  void warn_of_transmissions() {
    if (const pugi::xml_node transmission = document_.robot().child("transmission")) {
      warn(transmission,
           "<transmission> is ignored; state the drives as drive_gain and gear_ratio of the joints");
    }
  }

  const UrdfDocument& document_;
  UrdfTopology tree_;
  UrdfPath path_;
  std::vector<DependentJoint> dependent_;  // stated ones, then mimic joints
  std::vector<Role> role_;
  std::vector<bool> counts_;  // links whose bodies move with the chain
  pugi::xml_document plain_;
  std::vector<Finding> warnings_;
};

}  // namespace

CheckedUrdf checked_urdf(const UrdfDocument& document, const UrdfOptions& options) {
  return Checker(document, options).run();
}

}  // namespace rivid::detail
