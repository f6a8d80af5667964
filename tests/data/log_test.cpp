#include "rivid/data/log.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/complaint.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

Log plain_log() {
  Log log;
  log.source = "run1.csv";
  log.f_m = 10.0;
  log.t = Vector::LinSpaced(5, 0.0, 0.4);
  log.q = Matrix::Ones(5, 2);
  log.tau = Matrix{{0, 1}, {2, 3}, {4, 5}, {6, 7}, {8, 9}};
  log.lines.runs = {{0, 2}, {2, 7}};
  return log;
}

TEST(Log, HasNothingToComplainAboutWhenItFits) { EXPECT_EQ(plain_log().complaint(), std::nullopt); }

TEST(Log, ComplainsAboutSizesRatesAndValues) {
  const auto complaint = [](auto change) {
    Log log = plain_log();
    change(log);
    return log.complaint().value_or("");
  };
  EXPECT_TRUE(says(complaint([](Log& log) { log = {}; }), "the log has 0 samples, at least 2 are required"));
  EXPECT_TRUE(says(complaint([](Log& log) { log.f_m = 0.0; }), "run1.csv: f_m is 0 Hz, must be positive"));
  EXPECT_TRUE(
      says(complaint([](Log& log) { log.f_m = 12.0; }), "f_m is 12 Hz, but the time stamps give 10 Hz"));
  EXPECT_TRUE(says(complaint([](Log& log) { log.q.resize(0, 0); }), "the log has no positions"));
  EXPECT_TRUE(says(complaint([](Log& log) { log.qd.setZero(5, 1); }),
                   "qd is 5 × 1, must be 5 × 2 (samples × joints)"));
  EXPECT_TRUE(
      says(complaint([](Log& log) { log.tau.conservativeResize(4, 2); }), "tau is 4 × 2, must be 5 × 2"));
  EXPECT_TRUE(says(complaint([](Log& log) { log.tau(3, 1) = std::numeric_limits<double>::quiet_NaN(); }),
                   "run1.csv:8: tau of joint 2 is nan; values must be finite"));
  EXPECT_TRUE(says(complaint([](Log& log) { log.t[2] = log.t[1]; }), "the time stamps are irregular"));
}

TEST(Log, NamesTheRowWhereTheLineIsNotKnown) {
  Log log = plain_log();
  EXPECT_EQ(log.place(0), "run1.csv:2");
  EXPECT_EQ(log.place(3), "run1.csv:8");
  log.lines = {};
  EXPECT_EQ(log.place(3), "run1.csv: row 4");
}

TEST(Rows, KeepTheirLines) {
  const Log part = excerpt(plain_log(), 1, 3);
  EXPECT_EQ(part.samples(), 3);
  EXPECT_EQ(part.tau, (Matrix{{2, 3}, {4, 5}, {6, 7}}));
  EXPECT_EQ(part.qd.size(), 0);
  EXPECT_EQ(part.f_m, 10.0);
  EXPECT_EQ(part.lines[0], 3U);
  EXPECT_EQ(part.lines[1], 7U);
  EXPECT_EQ(part.lines[2], 8U);
}

TEST(Rows, AreRefusedOutsideOfTheLog) {
  EXPECT_TRUE(says(complaint_of([] { static_cast<void>(excerpt(plain_log(), 3, 3)); }),
                   "excerpt: run1.csv has 5 samples; 3 from index 3 can not be taken"));
}

}  // namespace
}  // namespace rivid
