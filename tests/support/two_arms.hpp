#pragma once

#include <random>
#include <string>
#include <vector>

#include "support/normal.hpp"

namespace rivid::test {

/// A torso that turns, two arms of three joints on it, and a hand on each whose two fingers, one of which
/// follows the other, hang on the last link.
inline std::string two_arms() {
  std::string out = "<robot name=\"two_arms\"><link name=\"base\"/>";
  const auto body = [&](const std::string& link, const std::string& com, double mass, const std::string& I) {
    out += "<link name=\"" + link + "\"><inertial><origin xyz=\"" + com + "\"/><mass value=\"" +
           std::to_string(mass) + "\"/><inertia " + I + "/></inertial></link>";
  };
  const auto joint = [&](const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& xyz, const std::string& axis,
                         const std::string& more = "") {
    out += "<joint name=\"" + name + "\" type=\"" + type + "\"><origin xyz=\"" + xyz + "\"/><parent link=\"" +
           parent + "\"/><child link=\"" + child + "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-3\" upper=\"3\" velocity=\"6\" effort=\"300\"/>" + more + "</joint>";
  };
  const std::string large = R"(ixx="0.30" iyy="0.28" izz="0.12" ixy="0.01" ixz="0.02" iyz="-0.01")";
  const std::string small = R"(ixx="0.040" iyy="0.042" izz="0.010" ixy="0.001" ixz="-0.002" iyz="0.001")";
  body("torso", "0.02 0.01 0.2", 12.0, large);
  joint("waist", "revolute", "base", "torso", "0 0 0.5", "0 0 1");
  for (const std::string side : {"left", "right"}) {
    const std::string y = side == "left" ? "0.2" : "-0.2";
    body(side + "_upper", "0.01 " + y.substr(0, y.size() - 1) + "02 -0.1", 3.0, small);
    joint(side + "_shoulder", "revolute", "torso", side + "_upper", "0 " + y + " 0.4", "0 1 0");
    body(side + "_fore", "0.12 0.01 0.01", 2.0, small);
    joint(side + "_elbow", "revolute", side + "_upper", side + "_fore", "0 0.02 -0.3", "0 0 1");
    body(side + "_hand", "0.01 -0.02 0.09", 1.2, small);
    joint(side + "_wrist", "revolute", side + "_fore", side + "_hand", "0.28 0 0", "1 0 0");
    body(side + "_finger", "0 0 0.02", 0.1, R"(ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0")");
    joint(side + "_grip", "prismatic", side + "_hand", side + "_finger", "0 0.02 0.1", "0 1 0");
    body(side + "_thumb", "0 0 0.02", 0.1, R"(ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0")");
    joint(side + "_grip_2", "prismatic", side + "_hand", side + "_thumb", "0 -0.02 0.1", "0 1 0",
          "<mimic joint=\"" + side + "_grip\" multiplier=\"-1\"/>");
  }
  return out + "</robot>";
}

/// A CSV of so many random harmonics for n joints, whose accelerations decay with the frequency.
///
/// @param scales  of the joints; none: 1
inline std::string random_fourier(int n, int harmonics, std::uint64_t seed,
                                  const std::vector<double>& scales = {}) {
  std::mt19937_64 random(seed);
  Normal normal;
  std::string out;
  for (const char* const part : {"A", "B"}) {
    for (int j = 1; j <= n; ++j) {
      out += (out.empty() ? "" : ",") + std::string(part) + std::to_string(j);
    }
  }
  for (int h = 1; h <= harmonics; ++h) {
    out += '\n';
    for (int k = 0; k < 2 * n; ++k) {
      const double scale = scales.empty() ? 0.5 : 0.5 * scales[static_cast<std::size_t>(k % n)];
      out += (k == 0 ? "" : ",") + std::to_string(scale * normal(random) / (h < 4 ? 1.0 : 0.25 * h));
    }
  }
  return out + '\n';
}

}  // namespace rivid::test
