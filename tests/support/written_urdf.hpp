#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "rivid/export/urdf.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/robots.hpp"

namespace rivid::test {

/// What a URDF can say, at random: a body for every link, friction for every joint; the rest zero.
inline Vector random_urdf_parameters(const Robot& robot, std::mt19937_64& random) {
  std::uniform_real_distribution<double> positive(0.01, 2.0);
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  std::vector<Inertial> bodies(robot.chain.links.size());
  std::ranges::generate(bodies, [&] { return random_inertial(random); });
  Vector chi_st = Vector::Zero(static_cast<Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto [kind, joint] = parameters[i];
    if (static_cast<int>(kind) < inertial_count) {
      chi_st[static_cast<Index>(i)] = bodies[static_cast<std::size_t>(joint)][static_cast<Index>(kind)];
    } else if (kind == ParameterKind::Fv || kind == ParameterKind::Fc) {
      chi_st[static_cast<Index>(i)] = positive(random);
    }
  }
  return chi_st;
}

/// The URDF written with these parameters and read back has the same standard parameters and gives the same
/// torques.
inline void expect_same_torques(const std::string& text, const Robot& robot, const Vector& chi_st,
                                std::mt19937_64& random) {
  // Of the largest one: some tens of roundings between the origin, the centre of mass, and back.
  constexpr double tolerance = 1e-9;
  constexpr double parameter_tolerance = 1e-12;
  const Robot back = parse_urdf(text, "written.urdf", same_part(robot));
  ASSERT_EQ(back.size(), robot.size());
  EXPECT_LE((back.chi_st() - chi_st).cwiseAbs().maxCoeff(),
            parameter_tolerance * chi_st.cwiseAbs().maxCoeff());
  const DynamicModel asked(robot, chi_st);
  const DynamicModel got(back, back.chi_st());
  for (int sample = 0; sample < 20; ++sample) {
    const Motion motion = random_motion(1, robot.size(), random);
    const auto torque = [&](const DynamicModel& model) {
      return inverse_dynamics(model, motion.q.transpose(), motion.qd.transpose(), motion.qdd.transpose());
    };
    const Vector expected = torque(asked);
    EXPECT_LE((torque(got) - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff());
  }
}

}  // namespace rivid::test
