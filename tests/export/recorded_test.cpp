#include "export/recorded.hpp"

#include <gtest/gtest.h>

#include <string>

#include "rivid/model/kinds.hpp"

namespace rivid::detail {
namespace {

TEST(Recorded, FoldsConstantsAndLeavesOutWhatChangesNothing) {
  Recording in;
  const Recorded x = in.input("x");
  const Recorded zero = 0.0;
  EXPECT_EQ(in.expression(Recorded(2.0) * Recorded(3.0) + zero), "6.0");
  EXPECT_EQ(in.expression(zero * x + Recorded(1.0) * x), "x");
  EXPECT_EQ(in.expression(zero - (-x)), "x");
  EXPECT_EQ(in.expression(Recorded(2.0) + (-x)), "2.0 - x");
  EXPECT_EQ(in.expression(select(Recorded(1.0) > zero, x, zero)), "x");
}

TEST(Recorded, DoesNothingTwiceAndReadsInputsBeforeOutputs) {
  Recording in;
  const Recorded x = in.input("x[0]");
  const Recorded y = in.input("x[1]");
  const Recorded product = x * y;
  in.output("x[0]", product + y * x);
  in.output("x[1]", sin(product) + x);
  static_cast<void>(cos(y));  // nobody asks for it
  EXPECT_EQ(in.statements(""),
            "const double v0 = x[0];\n"
            "const double v1 = x[1];\n"
            "const double v2 = v1 * v0;\n"
            "x[0] = v2 + v2;\n"
            "x[1] = sin(v2) + v0;\n");
}

TEST(Recorded, WritesWhatIsDecidedLater) {
  Recording in;
  const Recorded speed = in.input("speed");
  in.returned(sign(speed));
  EXPECT_EQ(in.statements(),
            "  const double v0 = speed;\n"
            "  return (v0 > 0.0) ? 1.0 : (((-v0) > 0.0) ? -1.0 : 0.0);\n");
}

}  // namespace
}  // namespace rivid::detail
