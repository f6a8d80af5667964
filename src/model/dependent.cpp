#include "rivid/model/dependent.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

std::string who_of(const std::string& joint) { return "dependent joint \"" + joint + "\": "; }

// Sums of independent joints that the joints of a robot are.
class Resolver {
 public:
  struct Sum {
    Vector factors;  // one a joint of the robot, those of dependent ones zero
    double offset = 0.0;
  };

  Resolver(const Robot& robot, std::span<const DependentJoint> dependents)
      : of_joints_(robot.joints.size(), nullptr) {
    for (const Joint& joint : robot.joints) {
      names_.push_back(joint.name);
    }
    for (const DependentJoint& dependent : dependents) {
      const DependentJoint*& place = of_joints_[place_of(dependent.joint, who_of(dependent.joint) + "it")];
      if (place != nullptr) {
        throw InputError(who_of(dependent.joint) + "it is described twice");
      }
      place = &dependent;
    }
  }

  [[nodiscard]] bool depends(std::size_t joint) const { return of_joints_[joint] != nullptr; }
  // How a joint depends on others by a curve, nothing where it does not.
  [[nodiscard]] const DependentJoint* curved(std::size_t joint) const {
    return depends(joint) && of_joints_[joint]->curve ? of_joints_[joint] : nullptr;
  }
  // The independent joints that it goes over.
  [[nodiscard]] std::vector<std::size_t> leaders(const DependentJoint& dependent) const {
    std::vector<std::size_t> out;
    for (const auto& [name, factor] : dependent.of) {
      out.push_back(place_of(name, who_of(dependent.joint) + "it follows \"" + name + "\", which"));
      if (depends(out.back())) {
        throw InputError(who_of(dependent.joint) + "it follows \"" + name +
                         "\" by a curve, which must move by itself");
      }
    }
    return out;
  }

  // `behind`: dependent joints that lead to this one
  [[nodiscard]] Sum sum(std::size_t joint, std::vector<std::string> behind = {}) const {
    const auto n = std::ssize(names_);
    if (!depends(joint)) {
      return {Vector::Unit(n, static_cast<Index>(joint)), 0.0};
    }
    const DependentJoint& dependent = *of_joints_[joint];
    if (std::ranges::find(behind, dependent.joint) != behind.end()) {
      throw InputError(who_of(dependent.joint) + "it follows itself, by way of " + quoted_list(behind));
    }
    behind.push_back(dependent.joint);
    Sum out{Vector::Zero(n), dependent.offset};
    for (const auto& [name, factor] : dependent.of) {
      const std::size_t place =
          place_of(name, who_of(dependent.joint) + "it follows \"" + name + "\", which");
      if (curved(place) != nullptr) {
        throw InputError(
            who_of(dependent.joint) + "it follows \"" + name +
            "\", a passive joint of a four-bar linkage or of a table; only joints of which q is a "
            "sum are followed");
      }
      const Sum other = sum(place, behind);
      out.factors += factor * other.factors;
      out.offset += factor * other.offset;
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t place_of(const std::string& name, const std::string& who) const {
    const auto at = std::ranges::find(names_, name);
    if (at == names_.end()) {
      throw InputError(who + " is no joint of the robot" + did_you_mean(name, names_) + "; its joints are " +
                       quoted_list(names_));
    }
    return static_cast<std::size_t>(at - names_.begin());
  }

  std::vector<const DependentJoint*> of_joints_;
  std::vector<std::string> names_;
};

std::string written(const DependentJoint& dependent) {
  if (const auto* const bar = dependent.curve ? std::get_if<FourBarAngle>(&*dependent.curve) : nullptr) {
    return "joint \"" + dependent.joint + "\" follows joint \"" + dependent.of.begin()->first +
           "\" by a four-bar linkage of " + number(bar->ground, 4) + ", " + number(bar->crank, 4) + ", " +
           number(bar->coupler, 4) + " and " + number(bar->rocker, 4) + " m, which reaches from " +
           number(bar->least, 4) + " to " + number(bar->most, 4) + " rad";
  }
  if (dependent.curve) {
    const auto& spline = std::get<JointSpline>(*dependent.curve);
    std::string out = "joint \"" + dependent.joint + "\" follows by a spline";
    std::size_t a = 0;
    for (const auto& [name, factor] : dependent.of) {
      out += (a == 0 ? " \"" : ", \"") + name + "\" from " + number(spline.least[a], 4) + " to " +
             number(spline.most[a], 4) + " in " + counted(spline.pieces[a], "piece");
      ++a;
    }
    return out;
  }
  std::string out = "joint \"" + dependent.joint + "\" follows others: q = " + number(dependent.offset, 6);
  for (const auto& [name, factor] : dependent.of) {
    out += (factor < 0.0 ? " - " : " + ") + number(std::abs(factor), 6) + " q of \"" + name + "\"";
  }
  return out;
}

}  // namespace

Robot with_dependents(Robot robot, std::span<const DependentJoint> dependents) {
  if (dependents.empty()) {
    return robot;
  }
  const Resolver resolver(robot, dependents);
  const auto is_independent = [&](std::size_t j) { return !resolver.depends(j); };
  std::vector<std::size_t> order(robot.joints.size());  // of the links, those of dependent joints last
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_partition(order, is_independent);
  std::vector<int> places(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    places[order[k]] = static_cast<int>(k);
  }

  const Robot all = robot;
  robot.chain = {.links = {}, .gravity = all.chain.gravity, .parents = {}, .dependents = {}};
  robot.joints.clear();
  robot.inertials.clear();
  for (const std::size_t j : order) {
    const int parent = all.chain.parent(j);
    robot.chain.links.push_back(all.chain.links[j]);
    robot.chain.parents.push_back(parent < 0 ? -1 : places[static_cast<std::size_t>(parent)]);
    robot.inertials.push_back(all.inertials[j]);
    if (is_independent(j)) {
      robot.joints.push_back(all.joints[j]);
      continue;
    }
    Chain::Dependent& dependent = robot.chain.dependents.emplace_back(
        Chain::Dependent{.joint = all.joints[j].name, .link = all.joints[j].link});
    if (const DependentJoint* const curved = resolver.curved(j)) {
      dependent.curve = curved->curve;
      for (const std::size_t k : resolver.leaders(*curved)) {
        dependent.terms.push_back({places[k]});
      }
      continue;
    }
    const Resolver::Sum sum = resolver.sum(j);
    dependent.offset = sum.offset;
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (const double factor = sum.factors[static_cast<Index>(k)]; factor != 0.0) {
        dependent.terms.push_back({places[k], factor});
      }
    }
  }
  if (const auto fault = robot.complaint()) {
    throw InputError(*fault);
  }
  std::ranges::transform(dependent_joints(robot), std::back_inserter(robot.notes), written);
  return robot;
}

std::vector<DependentJoint> dependent_joints(const Robot& robot) {
  std::vector<DependentJoint> out;
  for (const Chain::Dependent& dependent : robot.chain.dependents) {
    DependentJoint& joint = out.emplace_back(
        DependentJoint{.joint = dependent.joint, .offset = dependent.offset, .curve = dependent.curve});
    for (const auto& [k, factor] : dependent.terms) {
      joint.of[robot.joints[static_cast<std::size_t>(k)].name] += factor;
    }
  }
  return out;
}

}  // namespace rivid
