#include "rivid/text.hpp"

#include <gtest/gtest.h>

#include <charconv>
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
    double back = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    ASSERT_EQ(back, x) << text;
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
