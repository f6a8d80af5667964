// Modified Denavit-Hartenberg tables: a robot that is accepted can be computed with.

#include "experiment/sections.hpp"
#include "harness.hpp"
#include "rivid/regressor/base.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rivid;
  constexpr std::size_t most_joints = 7;  // base parameters take a while with more
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto robot = fuzz::accepted([&] {
    return detail::mdh_robot(detail::parsed_text_table(text, "robot.csv"), "robot", {0.0, 0.0, -9.81});
  });
  if (!robot) {
    return 0;
  }
  fuzz::require(!robot->complaint(), "a robot that was read can be used");
  for (const Chain::Link& link : robot->chain.links) {
    constexpr double rounding = 1e-12;
    fuzz::require((link.R * link.R.transpose()).isIdentity(rounding), "R is a rotation");
    fuzz::require(link.p.allFinite(), "p is finite");
  }
  if (robot->joints.size() <= most_joints) {
    (void)fuzz::accepted([&] { return base_parameters(*robot).size(); });
  }
  return 0;
}
