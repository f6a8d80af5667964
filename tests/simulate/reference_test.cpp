#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "rivid/simulate/references.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/random_matrix.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

// The same sum in another order.
constexpr double rounding = 1e-12;
// A central difference of fourth order with steps of 1e-4 loses 1e-16/1e-4 to rounding.
constexpr double difference_step = 1e-4;
constexpr double of_differences = 1e-9;

struct Instant {
  Vector q, qd, qdd;
};

Instant at(const Reference& reference, double t) {
  Instant out{Vector(reference.joints()), Vector(reference.joints()), Vector(reference.joints())};
  reference.at(t, out.q, out.qd, out.qdd);
  return out;
}

// Derivative of one member by differences of fourth order.
template <typename Member>
Vector difference(const Reference& reference, double t, Member member) {
  const double h = difference_step;
  const auto value = [&](int k) { return Vector(at(reference, t + k * h).*member); };
  return (8.0 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12.0 * h);
}

void expect_consistent(const Reference& reference, double t) {
  const Instant here = at(reference, t);
  const double scale = 1.0 + here.qdd.cwiseAbs().maxCoeff() + here.qd.cwiseAbs().maxCoeff();
  EXPECT_LT((difference(reference, t, &Instant::q) - here.qd).cwiseAbs().maxCoeff(), of_differences * scale)
      << "at " << t;
  EXPECT_LT((difference(reference, t, &Instant::qd) - here.qdd).cwiseAbs().maxCoeff(),
            100.0 * of_differences * scale)
      << "at " << t;
}

Matrix via_points() {
  Matrix via(4, 2);
  via << 0.0, 0.0, 1.5, 2.0, -1.0, -1.0, 1.0, 1.5;
  return via;
}

PointToPoint quintic_moves() { return {.via = via_points(), .durations = Vector::Constant(1, 2.5)}; }

PointToPoint limited_moves() {
  return {.via = via_points(),
          .profile = MoveProfile::trapezoidal_acceleration,
          .max_velocity = Eigen::Vector2d(2.0, 1.0),
          .max_acceleration = Eigen::Vector2d(5.0, 6.0),
          .max_jerk = Eigen::Vector2d(60.0, 50.0),
          .dwell = Eigen::Vector4d(0.1, 0.2, 0.0, 0.3)};
}

FourierSeries series() {
  return {.omega_f = 0.8,
          .A = test::random_matrix(3, 5, 11),
          .B = test::random_matrix(3, 5, 12),
          .q0 = Eigen::Vector3d(0.1, -0.2, 0.3)};
}

// A log of a smooth motion on a clock with jitter.
struct Samples {
  Vector t;
  Matrix q_r;
};

Samples samples(double jitter) {
  Samples out{Vector(400), Matrix(400, 2)};
  const Matrix noise = test::random_matrix(400, 1, 5);
  for (Index k = 0; k < 400; ++k) {
    const double t = 3.0 + 0.01 * (static_cast<double>(k) + jitter * std::clamp(noise(k, 0), -1.0, 1.0));
    out.t[k] = t;
    out.q_r.row(k) << std::sin(2.0 * t), std::cos(3.0 * t);
  }
  return out;
}

std::vector<std::unique_ptr<Reference>> all_references() {
  const Samples log = samples(0.3);
  std::vector<std::unique_ptr<Reference>> out;
  out.push_back(std::make_unique<LoggedReference>(log.t, log.q_r));
  out.push_back(std::make_unique<LinearReference>(log.t, log.q_r));
  out.push_back(std::make_unique<FourierReference>(series()));
  out.push_back(std::make_unique<PointToPointReference>(quintic_moves()));
  out.push_back(std::make_unique<PointToPointReference>(limited_moves()));
  return out;
}

TEST(References, RestBeforeTheBeginningAndAfterTheEnd) {
  for (const auto& reference : all_references()) {
    const double begin = reference->begin();
    const double end = begin + reference->duration();
    for (const auto& [outside, inside] : {std::pair{begin - 1.0, begin}, std::pair{end + 1.0, end}}) {
      const Instant rest = at(*reference, outside);
      EXPECT_EQ(rest.q, at(*reference, inside).q);
      EXPECT_TRUE(rest.qd.isZero(0.0));
      EXPECT_TRUE(rest.qdd.isZero(0.0));
    }
  }
}

TEST(References, DoNotStopForRoundingOfTheLastInstant) {
  const FourierReference reference(series());
  const double end = reference.duration();
  EXPECT_EQ(at(reference, std::nextafter(end, 2.0 * end)).qd, at(reference, end).qd);
  EXPECT_GT(at(reference, end).qd.norm(), 0.1);
}

TEST(References, DoNotAllocate) {
  for (const auto& reference : all_references()) {
    Instant out = at(*reference, 0.0);
    const long count = test::allocations_of([&] {
      for (int k = 0; k < 100; ++k) {
        reference->at(0.1 * k, out.q, out.qd, out.qdd);
      }
    });
    EXPECT_EQ(count, 0);
  }
  EXPECT_GT(test::allocations_of([] { const FourierReference counted(series()); }), 0);
}

TEST(LoggedReference, GoesThroughItsSamplesWithContinuousAcceleration) {
  for (const double jitter : {0.0, 1e-4, 0.45}) {
    const Samples log = samples(jitter);
    const LoggedReference reference(log.t, log.q_r);
    EXPECT_EQ(reference.joints(), 2);
    EXPECT_EQ(reference.begin(), log.t[0]);
    for (Index k = 0; k < log.t.size(); ++k) {
      const double t = log.t[k];
      EXPECT_LT((at(reference, t).q.transpose() - log.q_r.row(k)).cwiseAbs().maxCoeff(), rounding);
      if (k > 0) {
        const double before = std::nextafter(t, 0.0);
        EXPECT_LT((at(reference, t).qd - at(reference, before).qd).norm(), rounding);
        EXPECT_LT((at(reference, t).qdd - at(reference, before).qdd).norm(), 1e3 * rounding);
      }
    }
  }
}

TEST(LoggedReference, HasTheDerivativesOfItsPosition) {
  const Samples log = samples(0.3);
  const LoggedReference reference(log.t, log.q_r);
  for (Index k = 0; k + 1 < log.t.size(); k += 7) {
    expect_consistent(reference, 0.5 * (log.t[k] + log.t[k + 1]));
  }
  const double t = 5.0;
  // The interpolation error of a cubic spline: h⁴ for the position, h² for its second derivative.
  EXPECT_NEAR(at(reference, t).q[0], std::sin(2.0 * t), 1e-6);
  EXPECT_NEAR(at(reference, t).qd[0], 2.0 * std::cos(2.0 * t), 1e-4);
  EXPECT_NEAR(at(reference, t).qdd[0], -4.0 * std::sin(2.0 * t), 1e-2);
}

TEST(LoggedReference, FindsTheIntervalOnAnyClock) {
  Vector t(6);
  t << 0.0, 0.001, 0.002, 5.0, 5.5, 9.0;
  const Matrix q_r = t.array().cube();
  const LoggedReference reference(t, q_r);
  for (double instant = 0.0; instant <= 9.0; instant += 0.0625) {
    // A cubic is its own spline.
    EXPECT_NEAR(at(reference, instant).q[0], instant * instant * instant, 1e-9);
    EXPECT_NEAR(at(reference, instant).qdd[0], 6.0 * instant, 1e-8);
  }
}

TEST(LinearReference, JoinsItsSamplesByLines) {
  const LinearReference reference(Eigen::Vector3d(1.0, 2.0, 4.0), Eigen::Vector3d(0.0, 1.0, -1.0));
  EXPECT_EQ(at(reference, 1.25).q[0], 0.25);
  EXPECT_EQ(at(reference, 1.25).qd[0], 1.0);
  EXPECT_EQ(at(reference, 2.0).q[0], 1.0);
  EXPECT_EQ(at(reference, 2.0).qd[0], -1.0);
  EXPECT_EQ(at(reference, 4.0).q[0], -1.0);
  EXPECT_EQ(at(reference, 4.0).qd[0], -1.0);
  EXPECT_EQ(at(reference, 3.0).qdd[0], 0.0);
}

TEST(LoggedReference, RefusesSamplesWithoutAMotion) {
  const auto complaint = [](const Vector& t, const Matrix& q_r) {
    return complaint_of([&] { const LoggedReference reference(t, q_r); });
  };
  const Matrix three = Matrix::Zero(3, 2);
  EXPECT_TRUE(says(complaint(Eigen::Vector2d(0.0, 1.0), three),
                   "LoggedReference: t has 2 instants, q_r has 3 rows; they must be as many"));
  EXPECT_TRUE(
      says(complaint(Eigen::Vector3d(0.0, 1.0, 1.0), three), "t must increase, but goes from 1 to 1 s"));
  EXPECT_TRUE(says(complaint(Vector::Zero(1), Matrix::Zero(1, 1)), "must have two samples"));
  Matrix broken = three;
  broken(1, 1) = std::nan("");
  EXPECT_TRUE(says(complaint(Eigen::Vector3d(0.0, 1.0, 2.0), broken),
                   "the reference of joint 2 is nan at index 1, must be finite"));
}

TEST(FourierReference, IsTheSeriesAndItsDerivatives) {
  const FourierSeries wanted = series();
  const FourierReference reference(wanted);
  EXPECT_DOUBLE_EQ(reference.duration(), 2.0 * std::numbers::pi / 0.8);
  for (double t = 0.1; t < 7.0; t += 0.37) {
    Vector q = wanted.q0;
    for (Index i = 0; i < 3; ++i) {
      for (Index l = 0; l < 5; ++l) {
        const double omega = wanted.omega_f * static_cast<double>(l + 1);
        q[i] += wanted.A(i, l) / omega * std::sin(omega * t) - wanted.B(i, l) / omega * std::cos(omega * t);
      }
    }
    EXPECT_LT((at(reference, t).q - q).norm(), rounding);
    expect_consistent(reference, t);
  }
}

TEST(FourierReference, RefusesWhatIsNoSeries) {
  const auto complaint = [](auto&& change) {
    FourierSeries spoiled = series();
    change(spoiled);
    return complaint_of([&] { const FourierReference reference(spoiled); });
  };
  EXPECT_TRUE(says(complaint([](FourierSeries& s) { s.omega_f = 0.0; }),
                   "FourierReference: omega_f is 0 rad/s, must be positive and finite"));
  EXPECT_TRUE(says(complaint([](FourierSeries& s) { s.B.resize(3, 4); }), "A is (3 x 5) and B is (3 x 4)"));
  EXPECT_TRUE(says(complaint([](FourierSeries& s) { s.q0.resize(2); }), "q0 has 2 entries for 3 joints"));
  EXPECT_TRUE(says(complaint([](FourierSeries& s) { s.A(1, 0) = std::nan(""); }), "joint 2 must be finite"));
  EXPECT_TRUE(says(complaint([](FourierSeries& s) { s.duration = -1.0; }), "duration is -1 s"));
}

TEST(FourierReference, RefusesAPeriodThatIsNotFinite) {
  EXPECT_EQ(complaint_of([] {
              return FourierReference({.omega_f = 5e-324, .A = Matrix::Ones(1, 1), .B = Matrix::Ones(1, 1)});
            }),
            "FourierReference: omega_f is 4.94065646e-324 rad/s, its period is not finite");
}

TEST(PointToPointReference, MeetsItsPointsAtRest) {
  for (const PointToPoint& moves : {quintic_moves(), limited_moves()}) {
    const PointToPointReference reference(moves);
    EXPECT_EQ(at(reference, 0.0).q, moves.via.row(0).transpose());
    EXPECT_EQ(at(reference, reference.duration()).q, moves.via.row(3).transpose());
  }
  const PointToPointReference reference(quintic_moves());
  EXPECT_DOUBLE_EQ(reference.duration(), 7.5);
  for (Index i = 0; i < 4; ++i) {
    const Instant here = at(reference, 2.5 * static_cast<double>(i));
    EXPECT_EQ(here.q, via_points().row(i).transpose());
    EXPECT_TRUE(here.qd.isZero(0.0));
    EXPECT_TRUE(here.qdd.isZero(0.0));
  }
  // Half way in half the time; the velocity of the quintic is then 15/8 of the mean.
  EXPECT_NEAR(at(reference, 1.25).q[0], 0.75, rounding);
  EXPECT_NEAR(at(reference, 1.25).qd[0], 15.0 / 8.0 * 1.5 / 2.5, rounding);
}

TEST(PointToPointReference, IsContinuousUpToTheAcceleration) {
  for (const PointToPoint& moves : {quintic_moves(), limited_moves()}) {
    const PointToPointReference reference(moves);
    const double h = 1e-5;
    Instant before = at(reference, 0.0);
    for (double t = h; t < reference.duration(); t += h) {
      const Instant here = at(reference, t);
      // No jerk exceeds 100 in these moves.
      ASSERT_LT((here.qdd - before.qdd).cwiseAbs().maxCoeff(), 100.0 * h) << "at " << t;
      ASSERT_LT((here.qd - before.qd).cwiseAbs().maxCoeff(), 20.0 * h) << "at " << t;
      before = here;
    }
  }
}

TEST(PointToPointReference, HasTheDerivativesOfItsPosition) {
  const PointToPointReference reference(quintic_moves());
  for (double t = 0.05; t < 7.4; t += 0.1) {
    expect_consistent(reference, t);
  }
  PointToPoint timed = quintic_moves();
  timed.profile = MoveProfile::trapezoidal_acceleration;
  const PointToPointReference seven_phases(timed);
  for (int phase = 0; phase < 7; ++phase) {
    expect_consistent(seven_phases, 2.5 * (phase + 0.5) / 7.0);
  }
}

// Largest velocity, acceleration and jerk of each joint, in units of the limits.
Matrix use_of_limits(const PointToPointReference& reference, const PointToPoint& moves) {
  Matrix out = Matrix::Zero(2, 3);
  const double h = 1e-4;
  Instant before = at(reference, 0.0);
  for (double t = h; t < reference.duration(); t += h) {
    const Instant here = at(reference, t);
    const auto limit = [](const Vector& limits) {
      return limits.size() > 0 ? limits : Vector::Constant(2, 1e9);
    };
    out.col(0) = out.col(0).cwiseMax(here.qd.cwiseAbs().cwiseQuotient(limit(moves.max_velocity)));
    out.col(1) = out.col(1).cwiseMax(here.qdd.cwiseAbs().cwiseQuotient(limit(moves.max_acceleration)));
    out.col(2) =
        out.col(2).cwiseMax((here.qdd - before.qdd).cwiseAbs().cwiseQuotient(h * limit(moves.max_jerk)));
    before = here;
  }
  return out;
}

TEST(PointToPointReference, IsAsFastAsTheLimitsAllow) {
  struct Case {
    double distance, velocity, acceleration, jerk;
    double used_velocity, used_acceleration, used_jerk;
  };
  // All phases; no constant velocity; no constant acceleration; jerk alone.
  for (const Case& c :
       {Case{4.0, 1.0, 2.0, 10.0, 1.0, 1.0, 1.0}, Case{1.0, 9.0, 2.0, 10.0, -1.0, 1.0, 1.0},
        Case{4.0, 1.0, 9.0, 10.0, 1.0, -1.0, 1.0}, Case{0.1, 9.0, 9.0, 10.0, -1.0, -1.0, 1.0}}) {
    PointToPoint moves{.via = Matrix::Zero(2, 2),
                       .profile = MoveProfile::trapezoidal_acceleration,
                       .max_velocity = Vector::Constant(2, c.velocity),
                       .max_acceleration = Vector::Constant(2, c.acceleration),
                       .max_jerk = Vector::Constant(2, c.jerk)};
    moves.via(1, 0) = -c.distance;
    moves.via(1, 1) = 0.5 * c.distance;
    const PointToPointReference reference(moves);
    const Matrix used = use_of_limits(reference, moves);
    EXPECT_LT(used.maxCoeff(), 1.0 + 1e-6);
    const Vector wanted = Eigen::Vector3d(c.used_velocity, c.used_acceleration, c.used_jerk);
    for (Index k = 0; k < 3; ++k) {
      if (wanted[k] > 0.0) {
        EXPECT_NEAR(used(0, k), 1.0, 1e-3) << "limit " << k << ", distance " << c.distance;
      } else {
        EXPECT_LT(used(0, k), 0.99);
      }
      EXPECT_NEAR(used(1, k), 0.5 * used(0, k), 1e-6);
    }
  }
}

TEST(PointToPointReference, OfQuinticsReachesTheTightestLimit) {
  PointToPoint moves{.via = via_points().topRows(2), .max_velocity = Eigen::Vector2d(0.5, 3.0)};
  EXPECT_NEAR(use_of_limits(PointToPointReference(moves), moves).col(0).maxCoeff(), 1.0, 1e-5);
  moves.max_acceleration = Eigen::Vector2d(0.2, 0.2);
  EXPECT_NEAR(use_of_limits(PointToPointReference(moves), moves).col(1).maxCoeff(), 1.0, 1e-5);
  moves.max_jerk = Eigen::Vector2d(0.01, 0.01);
  EXPECT_NEAR(use_of_limits(PointToPointReference(moves), moves).col(2).maxCoeff(), 1.0, 1e-2);
}

TEST(PointToPointReference, DwellsAndPassesPointsThatAreTheSame) {
  PointToPoint moves{
      .via = Matrix::Ones(3, 1), .max_velocity = Vector::Ones(1), .dwell = Vector::Constant(1, 0.5)};
  moves.via(2, 0) = 2.0;
  const PointToPointReference reference(moves);
  EXPECT_DOUBLE_EQ(reference.duration(), 3 * 0.5 + 15.0 / 8.0);
  for (const double t : {0.0, 0.5, 0.9, 1.0}) {
    EXPECT_EQ(at(reference, t).q[0], 1.0);
    EXPECT_EQ(at(reference, t).qd[0], 0.0);
  }
  EXPECT_EQ(at(reference, 1.0 + 15.0 / 8.0 + 0.1).q[0], 2.0);
}

TEST(PointToPointReference, RefusesWhatIsNoSequenceOfMoves) {
  const auto complaint = [](auto&& change) {
    PointToPoint spoiled = limited_moves();
    change(spoiled);
    return complaint_of([&] { const PointToPointReference reference(spoiled); });
  };
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.via = Matrix::Zero(1, 2); }),
                   "PointToPointReference: via is (1 x 2), must have two points"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.durations = Vector::Ones(1); }), ", not both"));
  EXPECT_TRUE(
      says(complaint([](PointToPoint& m) { m = {.via = via_points()}; }), "give either durations or limits"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.max_jerk.resize(0); }), "max_jerk is required"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.max_velocity[1] = 0.0; }),
                   "max_velocity of joint 2 is 0, must be positive and finite"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.max_velocity.resize(3); }),
                   "max_velocity has 3 entries for 2 joints"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.dwell[1] = -1.0; }), "the dwell at point 2 is -1 s"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) { m.dwell = Vector::Zero(3); }), "dwell has 3 entries"));
  EXPECT_TRUE(
      says(complaint([](PointToPoint& m) { m.via(2, 0) = std::nan(""); }), "via point 3 must be finite"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) {
                     m = quintic_moves();
                     m.durations = Eigen::Vector2d(1.0, 1.0);
                   }),
                   "durations has 2 entries for 3 moves"));
  EXPECT_TRUE(says(complaint([](PointToPoint& m) {
                     m = quintic_moves();
                     m.durations[0] = 0.0;
                   }),
                   "the duration of move 1 is 0 s, must be positive"));
}

TEST(References, HaveNoNumberAtNoInstantAndRefuseOtherSizes) {
  const Vector t = Vector::LinSpaced(5, 0.0, 1.0);
  const Matrix q = test::random_matrix(5, 2, 3);
  const LoggedReference logged(t, q);
  const LinearReference linear(t, q);
  const FourierReference fourier({.omega_f = 1.0, .A = Matrix::Ones(2, 3), .B = Matrix::Ones(2, 3)});
  const PointToPointReference moves({.via = q, .durations = Vector::Ones(1)});
  for (const Reference* const reference : std::initializer_list<const Reference*>{&logged, &linear}) {
    const Instant none = at(*reference, std::nan(""));
    EXPECT_TRUE(none.q.array().isNaN().all() && none.qd.array().isNaN().all());
  }
  for (const Reference* const reference :
       std::initializer_list<const Reference*>{&logged, &linear, &fourier, &moves}) {
    Vector two(2);
    Vector three(3);
    EXPECT_EQ(complaint_of([&] {
                reference->at(0.5, two, three, two);
                return 0;
              }),
              "Reference::at: a vector has 3 values, must have 2, one a joint");
  }
}

}  // namespace
}  // namespace rivid
