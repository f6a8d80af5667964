#pragma once

#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <random>
#include <vector>

#include "rivid/model/mdh.hpp"
#include "rivid/types.hpp"

namespace rivid::benchmarks {

inline constexpr double quarter = std::numbers::pi / 2;

inline Robot scara() {
  const std::array<MdhRow, 2> table = {MdhRow{}, MdhRow{.a = 0.5}};
  return robot_from(table, {0.0, 0.0, 0.0});
}

/// Staeubli TX40, lengths of its data sheet.
inline Robot tx40() {
  const std::array<MdhRow, 6> table = {MdhRow{},
                                       MdhRow{.alpha = -quarter},
                                       MdhRow{.a = 0.225, .d = 0.035},
                                       MdhRow{.alpha = quarter, .d = 0.225},
                                       MdhRow{.alpha = -quarter},
                                       MdhRow{.alpha = quarter}};
  return robot_from(table);
}

/// Franka Emika Panda, the table of its documentation; 69 base parameters.
inline Robot panda() {
  const std::array<MdhRow, 7> table = {
      MdhRow{.d = 0.333},
      MdhRow{.alpha = -quarter},
      MdhRow{.alpha = quarter, .d = 0.316},
      MdhRow{.alpha = quarter, .a = 0.0825},
      MdhRow{.alpha = -quarter, .a = -0.0825, .d = 0.384},
      MdhRow{.alpha = quarter},
      MdhRow{.alpha = quarter, .a = 0.088},
  };
  return robot_from(table);
}

/// Seven joints whose axes and offsets know no right angles, as a calibrated URDF gives them.
inline Robot oblique() {
  Robot robot = panda();
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (Chain::Link& link : robot.chain.links) {
    link.R = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                 .normalized()
                 .toRotationMatrix();
    link.p = Eigen::Vector3d(normal(random), normal(random), normal(random)) * 0.2;
  }
  return robot;
}

/// Thirty joints with quarter turns between them.
inline Robot snake() {
  std::vector<MdhRow> table;
  for (int j = 0; j < 30; ++j) {
    table.push_back({.alpha = j % 2 == 0 ? quarter : -quarter, .a = j % 3 == 0 ? 0.05 : 0.0, .d = 0.1});
  }
  return robot_from(table);
}

/// Random positions up to 3, velocities up to 2 and a third series up to `third`, such as accelerations or
/// torques, (rows × columns) each.
inline Motion random_series(unsigned seed, Index rows, Index columns, double third) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  const auto matrix = [&](double scale) {
    return Matrix(Matrix::NullaryExpr(rows, columns, [&] { return scale * symmetric(random); }));
  };
  Motion out;
  out.q = matrix(3.0);
  out.qd = matrix(2.0);
  out.qdd = matrix(third);
  return out;
}

}  // namespace rivid::benchmarks
