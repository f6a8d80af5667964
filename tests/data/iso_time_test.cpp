#include "data/iso_time.hpp"

#include <gtest/gtest.h>

#include "rivid/data/csv.hpp"
#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

using detail::iso_time;

TEST(IsoTime, CountsDaysAndSecondsInUtc) {
  const auto at = iso_time("2024-05-06T07:08:09.25Z");
  ASSERT_TRUE(at);
  EXPECT_EQ(at->day, 19849);  // date -d 2024-05-06 +%s / 86400
  EXPECT_EQ(at->seconds, 7 * 3600 + 8 * 60 + 9.25);
  EXPECT_EQ(iso_time("1970-01-01 00:00:00")->day, 0);
  EXPECT_EQ(iso_time("1969-12-31 00:00:00")->day, -1);
  EXPECT_EQ(iso_time("2024-02-29T00:00:00,5")->seconds, 0.5);
}

TEST(IsoTime, TakesOffsetsOff) {
  for (const char* const same : {"2024-05-06T09:38:09+02:30", "2024-05-06T09:38:09+0230",
                                 "2024-05-06 05:08:09 -02", "2024-05-06T07:08:09", "2024-05-06T07:08:09Z"}) {
    const auto at = iso_time(same);
    ASSERT_TRUE(at) << same;
    EXPECT_EQ(at->seconds, 7 * 3600 + 8 * 60 + 9) << same;
  }
}

TEST(IsoTime, IsNothingElse) {
  for (const char* const text :
       {"", "1.5", "2024", "2024-05-06", "2024-05-06T07:08", "2024-13-06T07:08:09", "2024-02-30T07:08:09",
        "2024-05-06T24:08:09", "2024-05-06T07:60:09", "2024-05-06T07:08:61", "2024-05-06T07:08:09X",
        "2024-05-06T07:08:09+2", "2024-05-06T07:08:09+25:00", "2024-05-06T07:08:09Zx", "-024-05-06T07:08:09",
        "2024/05/06T07:08:09"}) {
    EXPECT_FALSE(iso_time(text)) << text;
  }
}

Log log_of_lines(const std::string& header, const std::vector<std::string>& stamps) {
  std::string text = header + ",q1,tau1\n";
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    text += stamps[k] + "," + std::to_string(k) + ",1\n";
  }
  const test::TemporaryFile file(text, "run.csv");
  const std::string time = header.substr(0, header.find(','));
  return read_csv(file.path(), {.time = Column{time}});
}

TEST(IsoTime, IsTheTimeOfALogInSecondsSinceMidnight) {
  const Log log = log_of_lines("stamp", {"2024-05-06T23:59:59.998Z", "2024-05-06T23:59:59.999Z",
                                         "2024-05-07T00:00:00.000Z", "2024-05-07T00:00:00.001Z"});
  // A double of 86400 resolves 1.5e-11 s.
  EXPECT_NEAR(log.t[0], 86399.998, 1e-10);
  EXPECT_NEAR(log.t[3], 86400.001, 1e-10);
  EXPECT_NEAR(log.f_m, 1000.0, 1e-5);
}

TEST(Stamps, OfSecondsAndNanosecondsAreOne) {
  const Log log =
      log_of_lines("header.stamp.sec,header.stamp.nanosec",
                   {"1700000000,998000000", "1700000000,999000000", "1700000001,0", "1700000001,1000000"});
  const double midnight = 1699920000.0;
  EXPECT_NEAR(log.t[0], 1700000000.998 - midnight, 1e-6);
  EXPECT_NEAR(log.t[3] - log.t[0], 0.003, 1e-10);
  EXPECT_NEAR(log.f_m, 1000.0, 1e-5);
}

}  // namespace
}  // namespace rivid
