#include "rivid/data/adjust.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rivid/data/csv.hpp"
#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;
using test::TemporaryFile;

Log plain_log(Index samples = 6) {
  Log log;
  log.source = "run1.csv";
  log.f_m = 10.0;
  log.t = Vector::LinSpaced(samples, 0.0, 0.1 * static_cast<double>(samples - 1));
  log.q = 10.0 * log.t;
  log.tau = 100.0 + 10.0 * log.t.array();
  return log;
}

TEST(ShiftTorque, TakesALagBack) {
  const Log log = shift_torque(plain_log(), 2);
  EXPECT_EQ(log.samples(), 4);
  EXPECT_TRUE(log.q.isApprox(Matrix{{0}, {1}, {2}, {3}}));
  EXPECT_TRUE(log.tau.isApprox(Matrix{{102}, {103}, {104}, {105}}));
  EXPECT_EQ(log.t[0], 0.0);
  EXPECT_EQ(log.notes.at(0), "torques moved by -2 samples, 2 rows dropped at the end");
}

TEST(ShiftTorque, TakesALeadBack) {
  const Log log = shift_torque(plain_log(), -1);
  EXPECT_TRUE(log.q.isApprox(Matrix{{1}, {2}, {3}, {4}, {5}}));
  EXPECT_TRUE(log.tau.isApprox(Matrix{{100}, {101}, {102}, {103}, {104}}));
  EXPECT_TRUE(says(log.notes.at(0), "1 row dropped at the start"));
}

TEST(ShiftTorque, InterpolatesFractionsOfASampleAndMovesControlSignalsToo) {
  Log recorded = plain_log();
  recorded.v_tau = 2.0 * recorded.tau;
  const Log log = shift_torque(recorded, -0.5);
  EXPECT_TRUE(log.q.isApprox(Matrix{{1}, {2}, {3}, {4}, {5}}));
  EXPECT_TRUE(log.tau.isApprox(Matrix{{100.5}, {101.5}, {102.5}, {103.5}, {104.5}}));
  EXPECT_TRUE(log.v_tau.isApprox(2.0 * log.tau));
  EXPECT_TRUE(shift_torque(recorded, 1.25).tau.isApprox(Matrix{{101.25}, {102.25}, {103.25}, {104.25}}));
}

TEST(ShiftTorque, LeavesTheLogAloneForNoLag) {
  const Log log = shift_torque(plain_log(), 0);
  EXPECT_EQ(log.tau, plain_log().tau);
  EXPECT_TRUE(log.notes.empty());
}

TEST(ShiftTorque, RefusesLogsWithoutTorquesOrWithTooFewSamples) {
  Log log = plain_log();
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(shift_torque(log, 6)); }),
                   "shift_torque: lag is 6 samples, but run1.csv has only 6"));
  log.tau.resize(0, 0);
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(shift_torque(log, 1)); }),
                   "run1.csv has neither torques nor control signals"));
}

TEST(SubtractTorque, SubtractsTheTableAtThePositionOfTheSample) {
  const TorqueTable table{"spring.csv", Vector{{-1.0, 0.0, 2.0, 10.0}}, Vector{{0.0, 10.0, 30.0, 110.0}}};
  const Log log = subtract_torque(plain_log(), 0, table);
  EXPECT_TRUE(log.tau.isApprox(Matrix{{90}, {81}, {72}, {63}, {54}, {45}}));
  EXPECT_EQ(log.notes.at(0), "torque of spring.csv subtracted from joint 1");
}

TEST(SubtractTorque, RefusesPositionsOutsideOfTheTableUnlessTheyAreHeld) {
  const TorqueTable table{"spring.csv", Vector{{0.0, 3.5}}, Vector{{5.0, 5.0}}};
  const std::string message =
      complaint_of([&] { static_cast<void>(subtract_torque(plain_log(), 0, table)); });
  EXPECT_TRUE(
      says(message, "run1.csv: row 5: joint 1 is at 4, outside of spring.csv, which goes from 0 to 3.5"));
  const Log held = subtract_torque(plain_log(), 0, table, Outside::hold);
  EXPECT_TRUE(held.tau.isApprox(plain_log().tau - Matrix::Constant(6, 1, 5.0)));
  EXPECT_TRUE(says(held.notes.at(0), "its end values held for 2 samples"));
}

TEST(SubtractTorque, RefusesJointsAndTablesThatAreNone) {
  const TorqueTable table{"spring.csv", Vector{{0.0, 9.0}}, Vector{{5.0, 5.0}}};
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(subtract_torque(plain_log(), 1, table)); }),
                   "there is no joint 2; run1.csv has 1"));
  const TorqueTable bad{"spring.csv", Vector{{0.0, 0.0}}, Vector{{5.0, 5.0}}};
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(subtract_torque(plain_log(), 0, bad)); }),
                   "the positions of the table must increase, but row 2 has 0 after 0"));
}

TEST(ReadTorqueTable, ReadsTwoColumns) {
  const TemporaryFile file("q2,tau\n0,1\n1,3\n", "spring.csv");
  const TorqueTable table = read_torque_table(file.path());
  EXPECT_EQ(table.q, (Vector{{0, 1}}));
  EXPECT_EQ(table.tau, (Vector{{1, 3}}));
  const TemporaryFile wide("a,b,c\n0,1,2\n");
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(read_torque_table(wide.path())); }),
                   "two columns are required, position and torque; got 3 (a, b, c)"));
  const TemporaryFile falling("a,b\n1,1\n0,2\n");
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(read_torque_table(falling.path())); }), "must increase"));
}

Log reference_log() {
  Log reference;
  reference.source = "commanded.csv";
  reference.f_m = 50.0;
  reference.t = Vector::LinSpaced(101, -1.0, 1.0);
  reference.q_r = reference.t.array().cube();
  reference.qd_r = 3.0 * reference.t.array().square();
  return reference;
}

TEST(WithReference, TakesTheReferenceAtTheDelayedTime) {
  const Log log = with_reference(plain_log(), reference_log(), 0.05);
  for (Index k = 0; k < log.samples(); ++k) {
    const double t = log.t[k] - 0.05;
    EXPECT_NEAR(log.q_r(k, 0), t * t * t, 1e-12);                 // a spline holds a cubic exactly
    EXPECT_NEAR(log.qd_r(k, 0), 3.0 * t * t, 3.0 * 0.02 * 0.02);  // a chord of a parabola
  }
  EXPECT_EQ(log.notes.at(0), "reference from commanded.csv, 0.05 s later");
}

TEST(WithReference, RefusesSamplesOutsideOfTheReferenceUnlessItIsHeld) {
  const std::string message =
      complaint_of([] { static_cast<void>(with_reference(plain_log(20), reference_log(), 0.25)); });
  EXPECT_TRUE(
      says(message, "run1.csv: row 14: t − delay is 1.05 s, but commanded.csv covers -1 to 1 s only"));
  EXPECT_TRUE(says(message, "cut the log to t = -0.75 to 1.25 s"));
  const Log held = with_reference(plain_log(20), reference_log(), 0.25, Outside::hold);
  EXPECT_NEAR(held.q_r(19, 0), 1.0, 1e-12);
  EXPECT_EQ(held.qd_r(19, 0), 0.0);
  EXPECT_NEAR(held.qd_r(12, 0), 3.0 * 0.95 * 0.95, 2e-3);
  EXPECT_TRUE(says(held.notes.at(0), "held for 7 samples"));
}

TEST(WithReference, RefusesReferencesThatDoNotFit) {
  Log reference = reference_log();
  reference.q_r = Matrix::Zero(101, 2);
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(with_reference(plain_log(), reference)); }),
                   "commanded.csv has 2 joints, run1.csv has 1"));
  EXPECT_TRUE(says(complaint_of([] { static_cast<void>(with_reference(plain_log(), plain_log())); }),
                   "run1.csv has no reference positions"));
  EXPECT_TRUE(
      says(complaint_of([] { static_cast<void>(with_reference(plain_log(), reference_log(), HUGE_VAL)); }),
           "delay_s is inf s, must be finite"));
}

}  // namespace
}  // namespace rivid
