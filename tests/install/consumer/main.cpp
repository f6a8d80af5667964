#include <array>
#include <iostream>

#include "rivid/rivid.hpp"

// A planar arm of two joints from its modified Denavit-Hartenberg table, and what its torques can show.
int main() {
  const std::array<rivid::MdhRow, 2> table = {{{.name = "shoulder"}, {.a = 0.5, .name = "elbow"}}};
  const rivid::Robot robot = rivid::robot_from(table, {0.0, -9.81, 0.0});
  const rivid::BaseParameters base = rivid::base_parameters(robot);
  std::cout << "rivid " << RIVID_VERSION << ": " << base.size() << " base parameters of "
            << base.standard.size() << " standard ones\n";
  for (const rivid::BaseParameter& p : base.parameters) {
    std::cout << p.name << " = " << p.regrouped << " [" << p.unit << "]\n";
  }
}
