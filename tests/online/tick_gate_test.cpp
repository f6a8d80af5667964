#include "rivid/online/tick_gate.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "rivid/online/saved_state.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

constexpr double f_m = 1000.0;
constexpr double encoder = 1e-5;

Vector q_at(double t) { return Eigen::Vector2d(std::sin(t), 0.5 * std::cos(2.0 * t)); }
Vector tau_at(double t) { return Eigen::Vector2d(10.0 * std::cos(t), 3.0 * std::sin(3.0 * t)); }

// A second of ticks with noise, then what a test does to them; ticks come out in order.
class Stream {
 public:
  TickGate<double> gate{2, {.f_m = f_m}};
  std::vector<Vector> q, qd, tau;
  int begins = 0;

  Stream() {
    for (k = 0; k < 1000; ++k) {
      const TickQuality quality = tick(time(k));
      EXPECT_TRUE(quality.good()) << "tick " << k;
    }
    EXPECT_EQ(std::ssize(q), 998);  // a tick behind, and the first one has no neighbour
  }

  [[nodiscard]] static double time(Index k) { return 3.0 + static_cast<double>(k) / f_m; }
  TickQuality tick(double t) { return tick(t, q_at(t) + noise(encoder), tau_at(t) + noise(0.1)); }
  TickQuality tick(double t, const Vector& at, const Vector& torque) {
    newest = at;
    return gate.update(t, at, torque, [&](const Vector& x, const Vector& v, const Vector& y, bool anew) {
      q.push_back(x);
      qd.push_back(v);
      tau.push_back(y);
      begins += anew ? 1 : 0;
    });
  }
  Vector noise(double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    return Eigen::Vector2d(normal(random), normal(random));
  }
  // That of tick k, which comes out as the one before the last.
  void expect_true(Index tick) {
    const auto at = static_cast<std::size_t>(tick - 1);
    EXPECT_LE((q[at] - q_at(time(tick))).cwiseAbs().maxCoeff(), 8.0 * encoder) << "tick " << tick;
    EXPECT_LE((tau[at] - tau_at(time(tick))).cwiseAbs().maxCoeff(), 0.6) << "tick " << tick;
  }

  Vector newest;  // position
  Index k = 0;
  std::mt19937_64 random{5};
};

TEST(TickGate, HandsEvenTicksOnWithTheirVelocities) {
  Stream s;
  EXPECT_EQ(s.begins, 1);
  for (Index k = 500; k < 998; ++k) {
    s.expect_true(k);
    const double t = Stream::time(k);
    // The low-pass is 3 ms late.
    EXPECT_NEAR(s.qd[static_cast<std::size_t>(k - 1)][0], std::cos(t), 0.03);
  }
}

TEST(TickGate, FillsWhatIsLostAndSaysSo) {
  Stream s;
  const TickQuality quality = s.tick(Stream::time(s.k + 2));
  EXPECT_EQ(quality.lost, 2);
  EXPECT_FALSE(quality.gap);
  s.tick(Stream::time(s.k + 3));
  EXPECT_EQ(s.begins, 1);
  for (Index k = s.k - 1; k <= s.k + 2; ++k) {
    s.expect_true(k);
  }
  EXPECT_EQ(s.gate.counts().lost, 2);
}

TEST(TickGate, BeginsAnewBehindAGap) {
  Stream s;
  const TickQuality quality = s.tick(Stream::time(s.k + 40));
  EXPECT_TRUE(quality.gap);
  EXPECT_EQ(quality.lost, 40);
  s.tick(Stream::time(s.k + 41));
  s.tick(Stream::time(s.k + 42));
  EXPECT_EQ(s.begins, 2);
  // And where the clock was set back.
  EXPECT_TRUE(s.tick(Stream::time(0)).gap);
}

TEST(TickGate, TakesNoTickTwiceAndNoneOutOfOrder) {
  Stream s;
  const double last = Stream::time(s.k - 1);
  EXPECT_TRUE(s.tick(last).repeated);
  EXPECT_TRUE(s.tick(last - 1.0 / f_m).late);
  // The same numbers with a new time: they are filled in by the next ones.
  const Vector at = q_at(last);
  const Vector torque = tau_at(last);
  s.tick(Stream::time(s.k), at, torque);
  EXPECT_TRUE(s.tick(Stream::time(s.k + 1), at, torque).repeated);
  EXPECT_EQ(s.tick(Stream::time(s.k + 2)).lost, 1);
  EXPECT_EQ(s.begins, 1);
}

TEST(TickGate, ARobotAtRestRepeatsItself) {
  Stream s;
  const Vector at = q_at(Stream::time(s.k));
  for (Index i = 0; i < 3000; ++i) {  // until it is known to rest
    s.tick(Stream::time(s.k + i), at, Vector::Zero(2));
  }
  const Index repeated = s.gate.counts().repeated;
  for (Index i = 3000; i < 4000; ++i) {
    s.tick(Stream::time(s.k + i), at, Vector::Zero(2));
  }
  EXPECT_EQ(s.gate.counts().repeated, repeated);
}

TEST(TickGate, ATickAtAnotherTimeIsLateUnlessAllJitter) {
  Stream s;
  EXPECT_TRUE(s.tick(Stream::time(s.k) + 0.4 / f_m).late);
  EXPECT_EQ(s.tick(Stream::time(s.k + 1)).lost, 1);
  std::uniform_real_distribution<double> jitter(-0.4 / f_m, 0.4 / f_m);
  int late = 0;
  for (Index i = 2; i < 2000; ++i) {
    const double t = Stream::time(s.k + i);
    late += s.tick(t + jitter(s.random), q_at(t) + s.noise(encoder), tau_at(t) + s.noise(0.1)).late && i > 200
                ? 1
                : 0;
  }
  EXPECT_EQ(late, 0);
}

TEST(TickGate, SaysAndPassesOverWhatIsNoNumber) {
  Stream s;
  Vector bad = q_at(Stream::time(s.k));
  bad[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(s.tick(Stream::time(s.k), bad, Vector::Zero(2)).not_finite);
  EXPECT_TRUE(s.tick(std::numeric_limits<double>::infinity()).not_finite);
  EXPECT_TRUE(s.tick(Stream::time(s.k), Vector::Zero(3), Vector::Zero(2)).not_finite);
  EXPECT_EQ(s.tick(Stream::time(s.k + 1)).lost, 1);
  s.tick(Stream::time(s.k + 2));
  s.expect_true(s.k);
}

TEST(TickGate, ReplacesAGlitchOfPositionOrTorqueAndNothingBesideIt) {
  for (const bool of_torque : {false, true}) {
    Stream s;
    const double t = Stream::time(s.k);
    s.tick(t, q_at(t) + (of_torque ? 0.0 : 0.02) * Vector::Unit(2, 0),
           tau_at(t) - (of_torque ? 50.0 : 0.0) * Vector::Unit(2, 1));
    EXPECT_TRUE(s.tick(Stream::time(s.k + 1)).glitch);
    EXPECT_FALSE(s.tick(Stream::time(s.k + 2)).glitch);
    s.tick(Stream::time(s.k + 3));
    for (Index k = s.k - 2; k <= s.k + 2; ++k) {
      s.expect_true(k);
    }
  }
}

TEST(TickGate, FillsNothingFromAGlitchBesideALostTick) {
  Stream s;
  const double t = Stream::time(s.k + 1);  // one is lost before it
  EXPECT_EQ(s.tick(t, q_at(t) + 0.05 * Vector::Unit(2, 0), tau_at(t)).lost, 1);
  EXPECT_TRUE(s.tick(Stream::time(s.k + 2)).glitch);
  s.tick(Stream::time(s.k + 3));
  for (Index k = s.k - 2; k <= s.k + 2; ++k) {
    s.expect_true(k);
  }
}

// A collision: the velocity jumps, and the torque with it.
TEST(TickGate, LeavesAKinkOfPositionsAndAStepOfTorquesAlone) {
  Stream s;
  Vector stopped;
  for (Index i = 0; i < 20; ++i) {
    const double t = Stream::time(s.k + i);
    stopped = i == 0 ? q_at(t) : stopped;
    EXPECT_FALSE(s.tick(t, stopped + s.noise(encoder), tau_at(t) + Vector::Constant(2, 80.0)).glitch) << i;
  }
  EXPECT_LE((s.q.back() - stopped).cwiseAbs().maxCoeff(), 8.0 * encoder);
  EXPECT_GE(s.tau.back()[0], 60.0);
}

// Of an encoder that hung for some ticks: the torques went on.
TEST(TickGate, BeginsAnewWherePositionsWereFrozenAndJump) {
  Stream s;
  const Vector stuck = s.newest;
  int repeated = 0;
  int gaps = 0;
  for (Index i = 0; i < 40; ++i) {
    const double t = Stream::time(s.k + i);
    const TickQuality quality = i < 20 ? s.tick(t, stuck, tau_at(t)) : s.tick(t);
    repeated += quality.repeated ? 1 : 0;
    gaps += quality.gap ? 1 : 0;
  }
  EXPECT_GE(repeated, 2);
  EXPECT_GE(gaps, 2);
  for (const Vector& qd : s.qd) {
    EXPECT_LE(qd.cwiseAbs().maxCoeff(), 1.2) << "the jump is no velocity";
  }
}

// A tenth of a second with 500 rad/s², which is more than a glitch needs, and lasts.
TEST(TickGate, AnAccelerationThatLastsIsNoGlitch) {
  Stream s;
  const Vector from = q_at(Stream::time(s.k - 1));
  for (Index i = 0; i < 100; ++i) {
    const double t = static_cast<double>(i + 1) / f_m;
    const Vector q = from + Vector::Constant(2, 250.0 * t * t) + s.noise(encoder);
    EXPECT_TRUE(s.tick(Stream::time(s.k + i), q, tau_at(Stream::time(s.k + i))).good()) << i;
  }
}

TEST(TickGate, QuantisedPositionsAreNoGlitches) {
  TickGate<double> gate(2, {.f_m = f_m});
  constexpr double quantum = 2e-3;  // 2000 rad/s² at this rate
  int glitches = 0;
  for (Index k = 0; k < 5000; ++k) {
    const double t = static_cast<double>(k) / f_m;
    const Vector q = quantum * (q_at(t) / quantum).array().round().matrix();
    glitches += gate.update(t, q, tau_at(t), [](const auto&...) {}).glitch ? 1 : 0;
  }
  EXPECT_LE(glitches, 50);
}

TEST(TickGate, SaysWhatIsWrong) {
  EXPECT_EQ(test::complaint_of([] { TickGate<double>(2, {.f_m = -1.0}); }),
            "TickGate: f_m is -1 Hz, must be positive");
  EXPECT_TRUE(test::says(test::complaint_of([] { TickGate<double>(2, {.largest_acceleration = 0.0}); }),
                         "largest_acceleration is 0"));
}

}  // namespace
}  // namespace rivid
