#include "rivid/data/csv.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <random>
#include <string>

#include "rivid/data/log.hpp"
#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;
using test::TemporaryFile;

constexpr const char* two_joints =
    "t,q1,q2,qd1,qd2,tau1,tau2,v1,v2,qref1,qref2,qdref1,qdref2,note\n"
    "0,1,2,3,4,5,6,7,8,9,10,11,12,start\n"
    "0.01,1.5,2.5,3.5,4.5,5.5,6.5,7.5,8.5,9.5,10.5,11.5,12.5,\n"
    "0.02,1,2,3,4,5,6,7,8,9,10,11,12,end\n";

std::string refusal(std::string_view content, const LogOptions& options = {}) {
  const TemporaryFile file(content);
  return complaint_of([&] { static_cast<void>(read_csv(file.path(), options)); });
}

TEST(ReadCsv, NamesTheCommandThatConvertsOtherFormats) {
  using namespace std::string_view_literals;
  const auto refused = [](std::string_view content, const char* name, const char* package) {
    const TemporaryFile file(content);
    const std::string path = file.path().string();
    const std::string words = complaint_of([&] { static_cast<void>(read_csv(file.path())); });
    EXPECT_TRUE(says(words, name)) << words;
    EXPECT_TRUE(says(words, "the Python package " + std::string(package) + " makes one")) << words;
    EXPECT_TRUE(says(words, "rivid convert " + path)) << words;
    EXPECT_TRUE(words.ends_with(".csv")) << words;
  };
  refused("\x89MCAP0\r\n...", "is an MCAP bag", "rivid[ros]");
  refused("SQLite format 3\0..."sv, "is a rosbag2 bag", "rivid[ros]");
  refused("#ROSBAG V2.0\n", "is a ROS 1 bag", "rivid[ros]");
  refused("PAR1...", "is a Parquet file", "rivid[parquet]");
  refused("ARROW1\0\0"sv, "is a Feather file", "rivid[parquet]");
  refused("PK\x03\x04...", "is a zip archive", "rivid");
  refused("\x93NUMPY\1\0"sv, "is a NumPy file", "rivid");
  refused("MATLAB 5.0 MAT-file, Platform", "is a MATLAB file", "rivid[matlab]");
  refused("MATLAB 7.3 MAT-file, Platform", "is a MATLAB file", "rivid[matlab]");
  refused("\x89HDF\r\n\x1a\n...", "is an HDF5 file", "rivid[matlab]");
}

TEST(ReadCsv, FindsTheDefaultNames) {
  const TemporaryFile file(two_joints);
  const Log log = read_csv(file.path());
  EXPECT_EQ(log.samples(), 3);
  EXPECT_EQ(log.joints(), 2);
  EXPECT_EQ(log.t, (Vector{{0.0, 0.01, 0.02}}));
  EXPECT_DOUBLE_EQ(log.f_m, 100.0);
  EXPECT_EQ(log.q, (Matrix{{1, 2}, {1.5, 2.5}, {1, 2}}));
  EXPECT_EQ(log.qd.row(1), (Eigen::RowVector2d{3.5, 4.5}));
  EXPECT_EQ(log.tau.row(1), (Eigen::RowVector2d{5.5, 6.5}));
  EXPECT_EQ(log.v_tau.row(1), (Eigen::RowVector2d{7.5, 8.5}));
  EXPECT_EQ(log.q_r.row(1), (Eigen::RowVector2d{9.5, 10.5}));
  EXPECT_EQ(log.qd_r.row(1), (Eigen::RowVector2d{11.5, 12.5}));
  EXPECT_EQ(log.place(1), file.path().string() + ":3");
  EXPECT_TRUE(log.notes.empty());
  EXPECT_EQ(log.complaint(), std::nullopt);
}

TEST(ReadCsv, LeavesEmptyWhatWasNotRecorded) {
  const TemporaryFile file("time,q1\n0,1\n1,2\n");
  const Log log = read_csv(file.path());
  EXPECT_EQ(log.joints(), 1);
  for (const Matrix* values : {&log.qd, &log.tau, &log.v_tau, &log.q_r, &log.qd_r}) {
    EXPECT_EQ(values->size(), 0);
  }
}

TEST(ReadCsv, TakesTheColumnsThatAreListedInTheirUnits) {
  const TemporaryFile file("stamp;shoulder;elbow;current\n0;90;180;1,5\n10;0;90;-2\n");
  const double degree = unit_scale("deg");
  const Log log = read_csv(file.path(), {.position = {{"elbow", degree, 1.0}, {"#2", -degree}},
                                         .torque = {{"current", 2.0}, {"#4", 3.0}},
                                         .time = Column{"stamp", unit_scale("ms")}});
  EXPECT_DOUBLE_EQ(log.q(0, 0), std::numbers::pi + 1.0);
  EXPECT_DOUBLE_EQ(log.q(0, 1), -std::numbers::pi / 2.0);
  EXPECT_EQ(log.tau, (Matrix{{3.0, 4.5}, {-4.0, -6.0}}));
  EXPECT_DOUBLE_EQ(log.f_m, 100.0);
}

TEST(ReadCsv, ReadsAFileWithoutAHeaderByNumbers) {
  const TemporaryFile file("0 1 2\n0.5 3 4\n");
  const Log log = read_csv(file.path(), {.position = {{"#2"}}, .torque = {{"#3"}}, .time = Column{"#1"}});
  EXPECT_EQ(log.q, (Matrix{{1}, {3}}));
  EXPECT_EQ(log.tau, (Matrix{{2}, {4}}));
  EXPECT_TRUE(says(refusal("0 1 2\n0.5 3 4\n"),
                   "there are no position columns \"q1\", \"q2\", … and none are listed; say "
                   "which columns hold them; the columns are #1, #2, #3"));
}

TEST(ReadCsv, NeedsNoTimeColumnWhereTheRateIsStated) {
  const TemporaryFile file("q1\n1\n2\n3\n");
  const Log log = read_csv(file.path(), {.rate_hz = 200.0});
  EXPECT_EQ(log.f_m, 200.0);
  EXPECT_EQ(log.t, (Vector{{0.0, 0.005, 0.01}}));
  EXPECT_TRUE(says(refusal("q1\n1\n2\n"),
                   "there is no time column \"t\" or \"time\"; say which column it is, or state the rate"));
}

TEST(ReadCsv, PrefersTheStatedRateAndNotesWhatTheTimeStampsTell) {
  const TemporaryFile file("t,q1\n5,1\n5.01,2\n5.02,3\n5.02,4\n5.03,5\n");
  const Log log = read_csv(file.path(), {.rate_hz = 100.0});
  EXPECT_EQ(log.f_m, 100.0);
  EXPECT_DOUBLE_EQ(log.t[4], 5.04);
  ASSERT_EQ(log.notes.size(), 1U);
  EXPECT_TRUE(says(log.notes[0], "time stamps are irregular: 5 samples"));
  EXPECT_TRUE(says(log.notes[0], "1 repeated (first at row 4, t = 5.02 s)"));
  EXPECT_TRUE(says(log.notes[0], "the stated rate of 100 Hz is used"));
  EXPECT_EQ(log.complaint(), std::nullopt);

  const TemporaryFile slower("t,q1\n0,1\n0.01,2\n0.02,3\n");
  EXPECT_TRUE(says(read_csv(slower.path(), {.rate_hz = 125.0}).warnings.at(0).text,
                   "the time stamps give 100 Hz; the stated rate of 125 Hz is used"));
}

TEST(ReadCsv, NotesIrregularTimeStampsAndTheLogComplains) {
  const TemporaryFile file("t,q1\n0,1\n0.01,2\n0.02,3\n0.05,4\n0.06,5\n");
  const Log log = read_csv(file.path());
  ASSERT_EQ(log.notes.size(), 1U);
  EXPECT_TRUE(says(log.notes[0], "1 gap of 2 missing rows (first at row 4, t = 0.05 s)"));
  EXPECT_TRUE(says(log.complaint().value_or(""), "the time stamps are irregular"));
  EXPECT_TRUE(says(log.complaint().value_or(""), "regularised()"));
}

TEST(ReadCsv, RefusesGapsAmongTheDefaultNames) {
  EXPECT_TRUE(says(refusal("t,q1,q2,q4\n0,1,2,3\n"),
                   "there is a column \"q4\" but no \"q3\"; list the columns of position"));
  EXPECT_TRUE(says(refusal("t,q1,q2,tau2\n0,1,2,3\n"), "there is a column \"tau2\" but no \"tau1\""));
}

TEST(ReadCsv, RefusesAQuantityWithoutAColumnForEachJoint) {
  EXPECT_TRUE(
      says(refusal("t,q1,q2,tau1\n0,1,2,3\n"),
           "torque has 1 column (tau1, found by name), position has 2; one for each joint is required"));
  EXPECT_TRUE(says(refusal(two_joints, {.position = {{"q1"}}}), "velocity has 2 columns"));
  const TemporaryFile file(two_joints);
  const Log one = read_csv(file.path(), {.position = {{"q2"}}, .default_names = false});
  EXPECT_EQ(one.joints(), 1);
  EXPECT_EQ(one.t[1], 0.01) << "time is looked for anyway";
  EXPECT_EQ(one.tau.size(), 0);
}

TEST(ReadCsv, FindsTheTimeByNameWhereNoRateIsStated) {
  const TemporaryFile file(two_joints);
  EXPECT_EQ(read_csv(file.path(), {.position = {{"q1"}}, .default_names = false}).t,
            read_csv(file.path(), {.position = {{"q1"}}, .time = Column{"t"}, .default_names = false}).t);
}

TEST(ReadCsv, RefusesAPositionAsTorque) {
  EXPECT_TRUE(says(refusal(two_joints, {.position = {{"q1"}}, .torque = {{"q1"}}, .default_names = false}),
                   "torque lists column \"q1\", which is listed as a position"));
}

TEST(ReadCsv, NotesDefaultNamesBesideListedPositions) {
  const TemporaryFile file("t,m1,m2,tau1,tau2\n0,1,2,3,4\n1,1,2,3,4\n");
  const Log log = read_csv(file.path(), {.position = {{"m1"}, {"m2"}}});
  ASSERT_EQ(log.notes.size(), 1U);
  EXPECT_EQ(log.notes[0], "torque not listed, taken from tau1 to tau2");
}

TEST(ReadCsv, TellsAMissingColumnOfAList) {
  EXPECT_TRUE(says(refusal(two_joints, {.torque = {{"tau1"}, {"tau_2"}}}),
                   "there is no column \"tau_2\"; the columns are t, q1"));
  EXPECT_TRUE(says(refusal(two_joints, {.torque = {{"tau1"}, {"tau_2"}}}), "did you mean \"tau2\"?"));
}

TEST(ReadCsv, RefusesOptionsThatCanNotBeMeant) {
  EXPECT_TRUE(says(refusal(two_joints, {.position = {{"q1"}, {"q1"}}}),
                   "read_csv: position lists column \"q1\" twice"));
  EXPECT_TRUE(
      says(refusal(two_joints, {.torque = {{"tau1", 0.0}}}), "torque: the scale of column \"tau1\" is 0"));
  EXPECT_TRUE(says(refusal(two_joints, {.torque = {{""}}}), "torque has a column without a name"));
  EXPECT_TRUE(
      says(refusal(two_joints, {.time = Column{"t", -1.0}}), "time: the scale is -1, must be positive"));
  EXPECT_TRUE(says(refusal(two_joints, {.rate_hz = 0.0}), "rate_hz is 0 Hz, must be positive"));
  EXPECT_TRUE(says(refusal(two_joints, {.table = {.columns = {"t"}}}), "table.columns must be empty"));
  EXPECT_TRUE(says(refusal("t,q1\n0,1\n"), "the log has one sample, at least 2 are required"));
  EXPECT_TRUE(says(refusal("t,q1\n1,1\n0,1\n"), "the time stamps do not go forward"));
}

TEST(ReadCsv, ReadsBackALogBitByBit) {
  constexpr std::uint64_t seed = 11;
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Matrix values(500, 6);
  std::string content = "q1,q2,q3,tau1,tau2,tau3\r\n";
  for (Index k = 0; k < values.rows(); ++k) {
    for (Index c = 0; c < values.cols(); ++c) {
      values(k, c) = normal(generator);
      char cell[40];
      const int length = std::snprintf(cell, sizeof cell, "%.17g", values(k, c));
      content.append(cell, static_cast<std::size_t>(length));
      content += c + 1 < values.cols() ? "," : "\r\n";
    }
  }
  const TemporaryFile file(content);
  const Log log = read_csv(file.path(), {.rate_hz = 1000.0});
  EXPECT_EQ(log.q, values.leftCols(3)) << "seed " << seed;
  EXPECT_EQ(log.tau, values.rightCols(3)) << "seed " << seed;
}

TEST(ReadReference, NeedsReferencesAndNoPositions) {
  const TemporaryFile file("t,qref1,qdref1\n0,1,2\n0.5,3,4\n");
  const Log log = read_reference(file.path());
  EXPECT_EQ(log.q_r, (Matrix{{1}, {3}}));
  EXPECT_EQ(log.qd_r, (Matrix{{2}, {4}}));
  EXPECT_EQ(log.joints(), 1);
  const TemporaryFile other("t,q1\n0,1\n1,2\n");
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(read_reference(other.path())); }),
                   "there are no reference columns \"qref1\""));
}

TEST(ToCsv, IsReadBackBitByBit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1e3, 1e3);
  const auto values = [&] { return Matrix(Matrix::NullaryExpr(20, 2, [&] { return any(random); })); };
  Log log;
  log.t = Vector::LinSpaced(20, 0.0, 0.19);
  log.q = values();
  log.tau = 1e-300 * values();
  log.q_r = 1e200 * values();
  const TemporaryFile file(to_csv(log));
  const Log back = read_csv(file.path());
  EXPECT_EQ(back.t, log.t);
  EXPECT_EQ(back.q, log.q);
  EXPECT_EQ(back.tau, log.tau);
  EXPECT_EQ(back.q_r, log.q_r);
  EXPECT_EQ(back.qd.size() + back.v_tau.size() + back.qd_r.size(), 0);
}

TEST(ToCsv, OfALogWithoutRowsIsItsHeader) {
  Log log;
  log.q = Matrix(0, 2);
  log.v_tau = Matrix(0, 2);
  EXPECT_EQ(to_csv(log), "t,q1,q2,v1,v2\n");
}

}  // namespace
}  // namespace rivid
