#include "rivid/identify/identification.hpp"

namespace rivid {

namespace {

// ZZ of frame j as the link frame calls it: the joint's axis may be another one there.
ParameterKind about_axis(const Chain::Link& link) {
  for (const ParameterKind kind : {ParameterKind::XX, ParameterKind::YY}) {
    if (inertial_column(link, kind).index == static_cast<int>(ParameterKind::ZZ)) {
      return kind;
    }
  }
  return ParameterKind::ZZ;
}

}  // namespace

Vector regular_start(const Robot& robot, const BaseParameters& base) {
  Vector chi_st = Vector::Zero(static_cast<Index>(base.standard.size()));
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    const ParameterKind kind = joint.rotor_inertia                 ? ParameterKind::Ia
                               : joint.type == JointType::revolute ? about_axis(robot.chain.links[j])
                                                                   : ParameterKind::M;
    for (std::size_t i = 0; i < base.standard.size(); ++i) {
      if (base.standard[i].joint == static_cast<int>(j) && base.standard[i].kind == kind) {
        chi_st[static_cast<Index>(i)] = 1.0;
      }
    }
  }
  return base.from_standard(chi_st);
}

}  // namespace rivid
