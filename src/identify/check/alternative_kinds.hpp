#pragma once

#include <string>
#include <string_view>

#include "identify/check/alternative_tests.hpp"

namespace rivid::detail {

// An alternative for which something speaks, in a log of that sampling rate.
struct Told {
  const Robot& robot;
  const Alternative& it;
  const AlternativeTest& test;
  double f_m = 0.0;
  double value = test.estimate[0];  // of the first parameter
  double sigma = test.sigma[0];
};

// Words of an alternative, and its cure, which may be empty.
struct AlternativeWords {
  std::string what;
  std::string cure;
};

// What is known of a kind of alternatives, whatever the robot.
struct AlternativeKind {
  std::string_view code;
  bool fault = false;     // of robot or log, which makes parameters wrong; else what the model lacks
  bool positive = false;  // exists with positive coefficients alone
  double large =
      0.0;  // norm of the estimate above which it is no small error that something else looks like; 0: none
  AlternativeWords (*words)(const Told&) = nullptr;
  // What an experiment would change; none where no key of the file stands for it.
  std::vector<Change> (*changes)(const Told&) = nullptr;
};

[[nodiscard]] const AlternativeKind& kind_of(const Alternative& alternative);

}  // namespace rivid::detail
