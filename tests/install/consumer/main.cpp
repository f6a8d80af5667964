#include <iostream>

#include "rivid/model/robot.hpp"

int main() {
  const rivid::Robot robot;
  std::cout << "rivid " << RIVID_VERSION << ": a robot of " << robot.size() << " joints, "
            << robot.standard_parameters().size() << " standard parameters\n";
}
