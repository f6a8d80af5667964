#include "rivid/text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace rivid {
namespace {

TEST(Exact, ReadsBackAsTheSameNumber) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int k = 0; k < 10000; ++k) {
    const double x = std::ldexp(mantissa(random), exponent(random));
    const std::string text = exact(x);
    ASSERT_EQ(finite_number(text), x) << text;
  }
}

TEST(FiniteNumber, IsAWholeTextInAnyLocale) {
  EXPECT_EQ(finite_number("-1.5e-3"), -0.0015);
  EXPECT_EQ(finite_number("5e-324"), 5e-324);
  for (const char* const no_number :
       {"", " 1", "1 ", "+1", "1,5", "0x10", "1e999", "1e-999", "inf", "nan", "1.5m"}) {
    EXPECT_EQ(finite_number(no_number), std::nullopt) << no_number;
  }
}

TEST(Exact, IsAsShortAsItCanBe) {
  EXPECT_EQ(exact(0.1), "0.1");
  EXPECT_EQ(exact(1e300), "1e+300");
  EXPECT_EQ(exact(-0.0), "0");
  EXPECT_EQ(exact(3.0), "3");
}

TEST(Fixed, HasSoManyDecimals) {
  EXPECT_EQ(fixed(2.0 / 3.0, 3), "0.667");
  EXPECT_EQ(fixed(-12.0, 0), "-12");
  EXPECT_EQ(fixed(1e20, 1), "100000000000000000000.0");
}

}  // namespace
}  // namespace rivid
