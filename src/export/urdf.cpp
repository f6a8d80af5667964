#include "rivid/export/urdf.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "dense.hpp"
#include "export/joint_values.hpp"
#include "export/xml_edit.hpp"
#include "model/urdf_document.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::StartTag;
using detail::UrdfTopology;

// Of a group of numbers with one unit, such as those of a tensor: what rounding makes of numbers that did not
// change.
constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();
// Of the largest second moment: figures of thin bodies are printed with few digits.
constexpr double body_tolerance = 1e-9;
// A frame turned for an oblique axis is turned by more than the reader's 1e-9 rad.
constexpr double same_axes = 1e-10;

// A body as a URDF describes it.
struct Body {
  double mass = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d I_com = Eigen::Matrix3d::Zero();  // in the axes of the link

  static Body of(const Inertial& inertial) {
    Body out{.mass = inertial[9], .I_com = detail::symmetric_tensor(inertial.data())};
    if (out.mass != 0.0) {
      const Eigen::Vector3d c = inertial.segment<3>(6) / out.mass;
      out.com = c;
      out.I_com -= out.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    }
    return out;
  }

  [[nodiscard]] Eigen::Matrix3d second_moments() const {
    return 0.5 * I_com.trace() * Eigen::Matrix3d::Identity() - I_com;
  }
};

bool close(const Inertial& a, const Inertial& b) {
  const auto within = [&](Index from, Index count) {
    const double scale =
        std::max(a.segment(from, count).cwiseAbs().maxCoeff(), b.segment(from, count).cwiseAbs().maxCoeff());
    return (a - b).segment(from, count).cwiseAbs().maxCoeff() <= rounding * scale;
  };
  return within(0, 6) && within(6, 3) && within(9, 1);
}

std::array<double, 6> entries(const Eigen::Matrix3d& I) {
  return {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)};
}

bool same_chain(const Robot& a, const Robot& b) {
  return std::ranges::equal(a.joints, b.joints,
                            [](const Joint& x, const Joint& y) {
                              return x.name == y.name && x.link == y.link && x.type == y.type;
                            }) &&
         a.chain.parents == b.chain.parents && a.chain.dependents.size() == b.chain.dependents.size() &&
         std::ranges::equal(a.chain.links, b.chain.links, [](const Chain::Link& x, const Chain::Link& y) {
           return x.R == y.R && x.p == y.p && x.axes == y.axes && x.signs == y.signs;
         });
}

// The robot as the text describes it.
Robot read_again(std::string_view xml, const std::string& source, const Robot& robot) {
  if (robot.base.empty() || robot.joints.empty()) {
    throw InputError("rewritten_urdf: robot \"" + robot.name +
                     "\" was not read from a URDF, so there is none to write back");
  }
  const Robot again = parse_urdf(xml, source, same_part(robot));
  if (!same_chain(again, robot)) {
    throw InputError("rewritten_urdf: robot \"" + robot.name + "\" was not read from " + source +
                     ": its joints, links or frames differ");
  }
  return again;
}

// Puts new numbers into a URDF, link by link and joint by joint.
class Writer {
 public:
  Writer(std::string_view xml, const std::string& source, const Robot& robot, const Robot& as_read)
      : document_(xml, source),
        tree_(detail::urdf_topology(document_)),
        path_(detail::urdf_path(document_, tree_, same_part(robot))),
        robot_(robot),
        as_read_(as_read),
        splice_(xml) {}

  RewrittenUrdf run(const std::vector<detail::JointValues>& values) {
    // Rotations from rivid's link frames to those of the URDF come from both at q = 0.
    struct Turns {
      Eigen::Matrix3d previous = Eigen::Matrix3d::Identity();
      Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
      Eigen::Matrix3d passed = Eigen::Matrix3d::Identity();
    };
    std::vector<Turns> of_links(tree_.links.size());
    for (const int place : path_.joints) {
      const UrdfTopology::Joint& joint = tree_.joint(place);
      const Turns& before = of_links[static_cast<std::size_t>(joint.parent)];
      Turns& here = of_links[static_cast<std::size_t>(joint.child)];
      const Eigen::Matrix3d passed = before.passed * document_.pose(joint.node).rotation();
      if (!joint.moves()) {
        here = {before.previous, before.axes, passed};
        continue;
      }
      const std::size_t j = robot_.link_of(joint.name).value();
      const Chain::Link& link = robot_.chain.links[j];
      const Eigen::Matrix3d axes = link_axes(link);
      Eigen::Matrix3d turn = passed.transpose() * before.previous * before.axes * link.R * axes.transpose();
      if (turn.isIdentity(same_axes)) {
        turn.setIdentity();
      }
      write_group(joint.child, values[j].inertial, as_read_.inertials[j], turn);
      write_dynamics(joint, values[j]);
      if (j >= robot_.joints.size() && !joint.mimic()) {
        write_mimic(joint, robot_.chain.dependents[j - robot_.joints.size()]);
      }
      here = {turn, axes, Eigen::Matrix3d::Identity()};
    }
    return {splice_.result(), std::move(faults_), std::move(warnings_)};
  }

 private:
  struct Lumped {
    int link;
    Eigen::Isometry3d pose;  // in the frame of the moving link
  };

  [[nodiscard]] StartTag tag(pugi::xml_node node) const {
    const std::ptrdiff_t at = node.offset_debug();
    const std::string_view name = node.name();
    if (at < 0 || splice_.text().substr(static_cast<std::size_t>(at), name.size()) != name) {
      throw InputError(document_.source() + ": can not be written back, it is not encoded in UTF-8");
    }
    return detail::start_tag(splice_.text(), static_cast<std::size_t>(at));
  }

  // The <inertial> of a link, in the link's frame; zeros where there is none.
  [[nodiscard]] Inertial inertial_of(int link) const {
    const std::optional<detail::UrdfBody> body = document_.body(tree_.link(link).node);
    if (!body) {
      return Inertial::Zero();
    }
    Inertial at_com = Inertial::Zero();
    at_com.head<6>() = Eigen::Map<const Eigen::Vector<double, 6>>(body->inertia.data());
    at_com[9] = body->mass;
    return transformed(at_com, body->pose.rotation(), body->pose.xyz);
  }

  // Links that stand still on a moving one while the joints of branches are at zero.
  [[nodiscard]] std::vector<Lumped> lumped_into(int moving) const {
    std::vector<Lumped> out = {{moving, Eigen::Isometry3d::Identity()}};
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (const int place : tree_.link(out[i].link).children) {
        const UrdfTopology::Joint& joint = tree_.joint(place);
        if (!joint.moves() || std::ranges::find(path_.joints, place) == path_.joints.end()) {
          out.push_back({joint.child, out[i].pose * document_.pose(joint.node).isometry()});
        }
      }
    }
    out.erase(out.begin());
    return out;
  }

  // A moving link and what is lumped into it: together they get the inertial `target`.
  void write_group(int link, const Inertial& target, const Inertial& before, const Eigen::Matrix3d& turn) {
    if (close(target, before)) {
      return;
    }
    const auto in_link = [&](const Inertial& x) {
      return turn.isIdentity(0.0) ? x : transformed(x, turn, Eigen::Vector3d::Zero());
    };
    const Inertial whole = in_link(target);
    const std::vector<Lumped> lumped = lumped_into(link);
    Inertial others = Inertial::Zero();
    for (const Lumped& other : lumped) {
      others += transformed(inertial_of(other.link), other.pose.linear(), other.pose.translation());
    }
    Inertial rest = close(whole, others) ? Inertial(Inertial::Zero()) : Inertial(whole - others);
    const std::string who = "link \"" + tree_.link(link).name + "\"";
    if (const auto complaint = body_complaint(whole)) {
      faults_.push_back(Finding{"no_body", {}, who + ": " + *complaint});
    } else if (!others.isZero(0.0) && body_complaint(rest)) {
      const double share = 0.5 * largest_share(others, whole);
      for (const Lumped& other : lumped) {
        write_inertial(other.link, share * inertial_of(other.link));
      }
      rest = whole - share * others;
      warnings_.push_back(
          Finding{"lumped_links_scaled",
                  {},
                  who + ": what is identified leaves no body to it beside the links that are fixed to it (" +
                      names(lumped) + "); their masses and inertias were scaled by " + number(share, 4)});
    }
    write_inertial(link, rest);
  }

  [[nodiscard]] std::string names(const std::vector<Lumped>& links) const {
    std::vector<std::string> out;
    for (const Lumped& each : links) {
      if (tree_.link(each.link).node.child("inertial")) {
        out.push_back(tree_.link(each.link).name);
      }
    }
    return quoted_list(out);
  }

  // The largest s for which whole − s part is a body; zero where whole is flat.
  static double largest_share(const Inertial& part, const Inertial& whole) {
    const Eigen::LLT<Eigen::Matrix4d> factor(pseudo_inertia(whole));
    if (factor.info() != Eigen::Success) {
      return 0.0;
    }
    const Eigen::Matrix4d half = factor.matrixL().solve(pseudo_inertia(part));
    const double largest = detail::symmetric_eigenvalues(factor.matrixL().solve(half.transpose())).maxCoeff();
    return largest > 1.0 ? 1.0 / largest : 1.0;
  }

  void write_inertial(int link, const Inertial& inertial) {
    const pugi::xml_node link_node = tree_.link(link).node;
    const pugi::xml_node node = link_node.child("inertial");
    const Body body = Body::of(inertial);
    if (body.mass == 0.0 && !inertial.segment<3>(6).isZero(0.0)) {
      throw InputError("rewritten_urdf: link \"" + tree_.link(link).name +
                       "\" has a first moment but no mass; a URDF can not say that");
    }
    if (!node) {
      if (!inertial.isZero(0.0)) {
        add_inertial(link_node, body);
      }
      return;
    }
    const pugi::xml_node origin = node.child("origin");
    const Eigen::Matrix3d R = document_.pose(node).rotation();
    const std::array<double, 6> I = entries(R.isIdentity(0.0) ? body.I_com : R.transpose() * body.I_com * R);
    const double size = body.I_com.cwiseAbs().maxCoeff();
    set_numbers(node.child("mass"), "value", {&body.mass, 1}, std::abs(body.mass));
    for (std::size_t k = 0; k < I.size(); ++k) {
      set_numbers(node.child("inertia"), detail::urdf_tensor_names[k], {&I[k], 1}, size);
    }
    const bool given = body.mass != 0.0 && (origin || !body.com.isZero(0.0));
    if (given && !origin) {
      splice_.insert_child(tag(node), {"<origin xyz=\"" + detail::exact_list(body.com) + "\"/>"});
    } else if (given) {
      const double length = std::max(body.com.cwiseAbs().maxCoeff(), std::sqrt(size / std::abs(body.mass)));
      set_numbers(origin, "xyz", {body.com.data(), 3}, length);
    }
  }

  void add_inertial(pugi::xml_node link, const Body& body) {
    const std::array<double, 6> I = entries(body.I_com);
    std::string inertia = "  <inertia";
    for (std::size_t k = 0; k < I.size(); ++k) {
      inertia.append(" ").append(detail::urdf_tensor_names[k]).append("=\"").append(exact(I[k])).append("\"");
    }
    splice_.insert_child(
        tag(link), {"<inertial>", "  <origin xyz=\"" + detail::exact_list(body.com) + "\" rpy=\"0 0 0\"/>",
                    "  <mass value=\"" + exact(body.mass) + "\"/>", inertia + "/>", "</inertial>"});
  }

  // Replaces those numbers of an attribute that are more than rounding away from the new ones.
  void set_numbers(pugi::xml_node node, const char* name, std::span<const double> values, double scale) {
    const StartTag at = tag(node);
    const StartTag::Attribute* const attribute = at.attribute(name);
    std::vector<std::pair<std::size_t, std::string_view>> words;  // offset, text
    if (attribute != nullptr) {
      constexpr std::string_view blanks = " \t\r\n";
      const std::string_view text = attribute->value;
      for (std::size_t i = text.find_first_not_of(blanks); i != std::string_view::npos;) {
        const std::size_t end = std::min(text.find_first_of(blanks, i), text.size());
        words.emplace_back(attribute->begin + i, text.substr(i, end - i));
        i = text.find_first_not_of(blanks, end);
      }
    }
    if (words.size() != values.size()) {  // not there, or blanks written as entities
      splice_.set(at, name, detail::exact_list(Vector::Map(values.data(), std::ssize(values))));
      return;
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
      const auto& [begin, word] = words[i];
      const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
      const double old = finite_number(digits).value_or(std::numeric_limits<double>::quiet_NaN());
      if (!(std::abs(old - values[i]) <= rounding * scale)) {
        splice_.replace(begin, word.size(), exact(values[i]));
      }
    }
  }

  void write_dynamics(const UrdfTopology::Joint& joint, const detail::JointValues& values) {
    const std::string who = "joint \"" + joint.name + "\"";
    const pugi::xml_node node = joint.node.child("dynamics");
    std::string added;
    const auto write = [&](const char* attribute, std::optional<double> value) {
      if (!value) {
        return;
      }
      if (*value < 0.0) {
        faults_.push_back(
            Finding{"driving_friction",
                    {},
                    who + ": its " + attribute + " is " + number(*value, 4) + ", must not be negative"});
        value = 0.0;
      }
      if (node.attribute(attribute)) {
        set_numbers(node, attribute, {&*value, 1}, *value);
      } else if (*value > 0.0 && node) {
        splice_.set(tag(node), attribute, exact(*value));
      } else if (*value > 0.0) {
        added.append(" ").append(attribute).append("=\"").append(exact(*value)).append("\"");
      }
    };
    write("damping", values.damping);
    write("friction", values.friction);
    if (!added.empty()) {
      splice_.insert_child(tag(joint.node), {"<dynamics" + added + "/>"});
    }
  }

  // What the experiment says of a joint, as far as a URDF can.
  void write_mimic(const UrdfTopology::Joint& joint, const Chain::Dependent& dependent) {
    if (dependent.terms.size() > 1 || dependent.curve) {
      warnings_.push_back(
          Finding{"format_has_no_place",
                  {},
                  "joint \"" + joint.name + "\" " +
                      (!dependent.curve                                         ? "follows several joints"
                       : std::holds_alternative<FourBarAngle>(*dependent.curve) ? "is of a four-bar linkage"
                                                                                : "follows a table") +
                      " in the experiment, which no mimic joint can: it moves by itself in the model"});
      return;
    }
    const auto& [k, factor] = dependent.terms.front();
    splice_.insert_child(
        tag(joint.node),
        {"<mimic" + detail::xml_attribute("joint", robot_.joints[static_cast<std::size_t>(k)].name) +
         detail::xml_attribute("multiplier", factor) + detail::xml_attribute("offset", dependent.offset) +
         "/>"});
  }

  detail::UrdfDocument document_;
  UrdfTopology tree_;
  detail::UrdfPath path_;
  const Robot& robot_;
  const Robot& as_read_;
  detail::Splice splice_;
  std::vector<Finding> faults_;
  std::vector<Finding> warnings_;
};

}  // namespace

std::optional<std::string> body_complaint(const Inertial& inertial) {
  if (inertial.isZero(0.0)) {
    return std::nullopt;
  }
  const Body body = Body::of(inertial);
  if (!(body.mass > 0.0)) {
    return "its mass is " + number(body.mass, 4) + " kg, must be positive";
  }
  const Eigen::Vector3d moments = detail::symmetric_eigenvalues(body.second_moments());
  // Rounding of the step from the link's origin to the centre of mass counts, too.
  const double size = std::max(moments.cwiseAbs().maxCoeff(), inertial.head<6>().cwiseAbs().maxCoeff());
  if (moments[0] < -body_tolerance * size) {
    return "no body has its inertia: its second moments about the centre of mass have the eigenvalue " +
           number(moments[0], 4) + " kg·m², must not be negative";
  }
  return std::nullopt;
}

RewrittenUrdf rewritten_urdf(std::string_view xml, const std::string& source, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const UrdfWriteOptions& options) {
  const Robot as_read = read_again(xml, source, robot);
  std::string floating;
  std::string added;
  if (robot.base_joints > 0) {
    added = detail::floating_joints(detail::UrdfDocument(xml, source));
    floating = detail::with_floating_joints(xml, source);
    xml = floating;
  }
  const std::vector<detail::JointValues> values = detail::joint_values(robot, chi_st, "rewritten_urdf");
  RewrittenUrdf out = Writer(xml, source, robot, as_read).run(values);
  if (!added.empty()) {
    out.text.erase(out.text.rfind(added), added.size());
  }
  if (!out.faults.empty() && !options.force) {
    out.text.clear();
  }
  return out;
}

std::string urdf_text(const std::filesystem::path& path) { return std::string(read_input(path).bytes()); }

RewrittenUrdf rewritten_urdf(const std::filesystem::path& path, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const UrdfWriteOptions& options) {
  return rewritten_urdf(urdf_text(path), path.string(), robot, chi_st, options);
}

}  // namespace rivid
