#include <gtest/gtest.h>

#include <numbers>

#include "rivid/data/log.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

TEST(UnitScale, TurnsUnitsIntoSi) {
  EXPECT_DOUBLE_EQ(180.0 * unit_scale("deg"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(60.0 * unit_scale("rpm"), 2.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(unit_scale("deg/s"), unit_scale("deg"));
  for (const char* unit : {"1", "rad", "m", "s", "Nm", "N·m", "N", "V", "A", "rad/s", "m/s"}) {
    EXPECT_EQ(unit_scale(unit), 1.0) << unit;
  }
  for (const char* unit : {"mm", "ms", "mNm", "mV", "mA", "mm/s"}) {
    EXPECT_EQ(unit_scale(unit), 1e-3) << unit;
  }
  EXPECT_EQ(unit_scale("um"), 1e-6);
  EXPECT_EQ(unit_scale("us"), 1e-6);
  EXPECT_EQ(unit_scale("ns"), 1e-9);
  EXPECT_EQ(unit_scale("kN"), 1e3);
  EXPECT_EQ(unit_scale("kNm"), 1e3);
}

TEST(UnitScale, RefusesOtherWordsWithTheList) {
  const std::string message = test::complaint_of([] { static_cast<void>(unit_scale("degree")); });
  EXPECT_TRUE(
      test::says(message, "unit_scale: \"degree\" is no known unit; the units are 1, rad, deg, m, mm"));
  const std::string close = test::complaint_of([] { static_cast<void>(unit_scale("Rad")); });
  EXPECT_TRUE(test::says(close, "did you mean \"rad\"?"));
}

TEST(UnitComplaint, IsSilentOnKnownUnitsAlone) {
  EXPECT_EQ(unit_complaint("deg"), std::nullopt);
  EXPECT_TRUE(test::says(unit_complaint("degs").value_or(""), "\"degs\" is no known unit"));
}

}  // namespace
}  // namespace rivid
