// What public functions refuse: arguments of other sizes, of another robot, or without content.

#include <gtest/gtest.h>

#include "rivid/identify/identification.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

TEST(Arguments, SeriesOfALongRunCovarianceHaveTheSameColumns) {
  const std::vector<Matrix> unequal = {Matrix::Ones(10, 3), Matrix::Ones(10, 2)};
  EXPECT_TRUE(says(complaint_of([&] { return long_run_covariance(unequal, 2); }),
                   "long_run_covariance: a series has 2 columns, the first has 3"));
  EXPECT_TRUE(
      says(complaint_of([&] { return bartlett_lag(unequal); }), "bartlett_lag: a series has 2 columns"));
  EXPECT_TRUE(
      says(complaint_of([&] { return long_run_covariance(std::vector{Matrix(Matrix::Ones(10, 3))}, -1); }),
           "long_run_covariance: lag is -1"));
}

TEST(Arguments, TheBaseOfAnObservationIsThatOfItsRobot) {
  std::mt19937_64 random(1);
  const BaseParameters of_scara = base_parameters(test::scara());
  const Motion motion = test::random_motion(10, 1, random);
  EXPECT_TRUE(says(complaint_of([&] { return observation(test::slider(), of_scara, motion); }),
                   "robot \"slider\" has 1 joints; give base_parameters() of this robot"));
}

TEST(Arguments, AnIdentificationToValidateHasValues) {
  EXPECT_TRUE(says(complaint_of([] { return validate(test::scara(), Identification(), Log()); }),
                   "validate: the identification has 0 values"));
}

TEST(Arguments, TextOnALineIsUtf8WithoutControlCharacters) {
  EXPECT_EQ(on_one_line("q̇ · 日本 😀"), "q̇ · 日本 😀");
  EXPECT_EQ(on_one_line("a\x1B[31mb\x7F\n"), "a?[31mb??");
  EXPECT_EQ(on_one_line("\xC2\x9B"
                        "31m"),
            "??31m")
      << "CSI as one character";
  EXPECT_EQ(on_one_line("\xFF\xC0\xAF"), "???");
  EXPECT_EQ(on_one_line("\xED\xA0\x80"), "???") << "a surrogate";
  EXPECT_EQ(on_one_line("\xF4\x90\x80\x80"), "????") << "beyond the last character";
  EXPECT_EQ(on_one_line("cut \xE6\x97"), "cut ??");
}

}  // namespace
}  // namespace rivid
