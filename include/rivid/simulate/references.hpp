#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Reference motion of n joints as a function of time. Velocity and acceleration are the derivatives of the
/// position.
class Reference {
 public:
  Reference() = default;
  Reference(const Reference&) = default;
  Reference& operator=(const Reference&) = default;
  virtual ~Reference() = default;

  [[nodiscard]] virtual Index joints() const = 0;
  [[nodiscard]] virtual double begin() const { return 0.0; }  ///< [s]
  /// Length of the motion from t = begin() [s].
  [[nodiscard]] virtual double duration() const = 0;

  /// Reference at one instant, (n) each; before the beginning and after the end it rests where it began or
  /// ended. Of those in this header the instant NaN has no number, and vectors of another size are an
  /// InputError. No allocation.
  virtual void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                  Eigen::Ref<Vector> qdd_r) const = 0;
};

/// A finite Fourier series for each joint, the usual form of exciting trajectories [Swevers 1997]:
///
///   q_i(t) = q0_i + Σ_{l=1…L} A_il / (ω_f l) sin(l ω_f t) − B_il / (ω_f l) cos(l ω_f t)
///
/// so that A and B are the amplitudes of the velocities.
struct FourierSeries {
  double omega_f = 0.0;   ///< fundamental frequency [rad/s]
  Matrix A = {};          ///< (n × L) [rad/s | m/s]
  Matrix B = {};          ///< (n × L) [rad/s | m/s]
  Vector q0 = {};         ///< (n), empty: zero [rad | m]
  double duration = 0.0;  ///< 0: one period, 2π / ω_f [s]

  [[nodiscard]] std::optional<std::string> complaint() const;

  static constexpr std::string_view word = "fourier";  ///< that files name it by
  template <typename S = FourierSeries>
  static constexpr auto fields() {
    return std::tuple(
        Field{"omega_f",
              &S::omega_f,
              "fundamental frequency",
              {.unit = "rad/s", .required = "must say omega_f, the fundamental frequency in rad/s"}},
        Field{"A",
              [](const S& s) -> const Matrix& { return s.A; },
              "one list a joint, one number a harmonic",
              {.otherwise = "–", .unit = "rad/s, m/s"}},
        Field{"B",
              [](const S& s) -> const Matrix& { return s.B; },
              "the same of the cosines",
              {.otherwise = "–", .unit = "rad/s, m/s"}},
        Field{"file",
              Key<std::filesystem::path>(),
              "instead of A and B: a CSV file with columns `A1` … `An`, `B1` … `Bn`, one row a harmonic",
              {.otherwise = "–"}},
        Field{"q0", &S::q0, "middle of the motion", {.otherwise = "0", .unit = "rad, m"}},
        Field{"duration",
              &S::duration,
              "of the motion",
              {.otherwise = "one period", .unit = "s", .range = Range::from(0.0, 1e9)}});
  }
};

/// A Fourier series as reference motion from t = 0. It does not in general begin or end at rest. Threads may
/// share one.
class FourierReference final : public Reference {
 public:
  /// @throws InputError  the series' complaint()
  explicit FourierReference(FourierSeries series);

  [[nodiscard]] Index joints() const override { return series_.A.rows(); }
  [[nodiscard]] double duration() const override { return series_.duration; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  FourierSeries series_;
};

/// The reference that a controller logged: a cubic spline through its samples, twice continuously
/// differentiable.
///
/// Velocity and acceleration are the derivatives of that spline. Where a reference velocity was logged as
/// well, it is not used: two columns that disagree, by a delay or by rounding, have no motion between their
/// samples, and the position is what the joint must follow. Who needs a controller's own velocity reference
/// writes a Reference.
///
/// Threads may share one.
class LoggedReference final : public Reference {
 public:
  /// @param t    instants, (n_m), increasing, n_m ≥ 2 [s]
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError  where the sizes differ, t does not increase or a value is not finite
  LoggedReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r);

  [[nodiscard]] Index joints() const override { return spline_.size(); }
  [[nodiscard]] double begin() const override { return spline_.begin(); }
  [[nodiscard]] double duration() const override { return spline_.end() - spline_.begin(); }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  CubicSpline spline_;
};

/// A logged reference joined by straight lines, as simulators interpolate tables. Its velocity is the slope
/// of the line that begins at a sample, its acceleration is zero: for laws that use neither, or to repeat a
/// simulation that was made so. LoggedReference is the better motion.
///
/// Threads may share one.
class LinearReference final : public Reference {
 public:
  /// @param t    instants, (n_m), increasing, n_m ≥ 2 [s]
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError  where the sizes differ, t does not increase or a value is not finite
  LinearReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r);

  [[nodiscard]] Index joints() const override { return q_r_.cols(); }
  [[nodiscard]] double begin() const override { return t_[0]; }
  [[nodiscard]] double duration() const override { return t_[t_.size() - 1] - t_[0]; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  Vector t_;
  Matrix q_r_;
};

/// How a move from rest to rest gets on.
enum class MoveProfile {
  /// s = 10 u³ − 15 u⁴ + 6 u⁵ with u = t / T: the lowest polynomial without a jump of the acceleration
  quintic,
  /// Trapezoidal acceleration: jerk ±j, 0, so that the acceleration rises to a, stays, and falls, then the
  /// velocity stays at v, then the mirror image. Moves within limits reach them; moves of given durations
  /// have seven phases of equal length.
  trapezoidal_acceleration
};
template <>
inline constexpr std::array names_of<MoveProfile> =
    std::to_array<std::string_view>({"quintic", "trapezoidal_acceleration"});

/// Moves from rest to rest through via points. All joints move together, along a straight line in joint
/// space, either in given times or as fast as the slowest joint's limits allow.
struct PointToPoint {
  Matrix via = {};  ///< points, (k × n), k ≥ 2, one row a point [rad | m]
  MoveProfile profile = MoveProfile::quintic;
  Vector durations = {};         ///< of the moves, (k − 1), or one for all; empty where limits are given [s]
  Vector max_velocity = {};      ///< limits, (n); empty: none [rad/s | m/s]
  Vector max_acceleration = {};  ///< (n); empty: none [rad/s² | m/s²]
  Vector max_jerk = {};  ///< (n); empty: none, but a trapezoidal acceleration needs it [rad/s³ | m/s³]
  Vector dwell = {};     ///< rest at each point, (k), or one for all; empty: none [s]

  [[nodiscard]] std::optional<std::string> complaint() const;

  static constexpr std::string_view word = "point_to_point";  ///< that files name it by
  static constexpr Range times = Range::from(0.0, 1e9);       ///< of moves and rests
  template <typename P = PointToPoint>
  static constexpr auto fields() {
    return std::tuple(Field{"via",
                            [](const P& p) -> const Matrix& { return p.via; },
                            "points, one list each",
                            {.unit = "rad, m", .required = "must list the points, via"}},
                      Field{"profile", &P::profile, "`\"quintic\"`, or `\"trapezoidal_acceleration\"`"},
                      Field{"durations",
                            [](const P& p) -> const Vector& { return p.durations; },
                            "of the moves, or one for all",
                            {.otherwise = "–", .unit = "s", .range = times}},
                      Field{"max_velocity",
                            &P::max_velocity,
                            "limits, instead of durations",
                            {.otherwise = "none", .unit = "rad/s, m/s"}},
                      Field{"max_acceleration",
                            &P::max_acceleration,
                            "the same of the acceleration",
                            {.otherwise = "none", .unit = "rad/s², m/s²"}},
                      Field{"max_jerk",
                            &P::max_jerk,
                            "required with a trapezoidal acceleration by limits",
                            {.otherwise = "none", .unit = "rad/s³, m/s³"}},
                      Field{"dwell",
                            [](const P& p) -> const Vector& { return p.dwell; },
                            "rest at each point, or one for all",
                            {.otherwise = "0", .unit = "s", .range = times}});
  }
};

/// Point-to-point moves as reference motion from t = 0; position, velocity and acceleration are continuous.
/// Threads may share one.
class PointToPointReference final : public Reference {
 public:
  /// @throws InputError  the moves' complaint()
  explicit PointToPointReference(const PointToPoint& moves);

  [[nodiscard]] Index joints() const override { return via_.rows(); }
  [[nodiscard]] double duration() const override { return duration_; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  struct Move {
    double start = 0.0;
    double duration = 0.0;
    double jerk_time = 0.0;          // T_j: each of the four phases of jerk
    double acceleration_time = 0.0;  // T_a: each of the two of constant acceleration
  };

  MoveProfile profile_;
  Matrix via_;  // (n × k)
  std::vector<Move> moves_;
  double duration_ = 0.0;
};

}  // namespace rivid
