// What could be seen of the simulated pick-ups at all: by a test that knows the noise, the arm as well as
// fifteen seconds of all ticks tell it, velocities and accelerations without error, and the instant; only
// mass and centre of mass are left to it.

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <utility>
#include <vector>

#include "rivid/online/row_stream.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

constexpr std::array<double, 6> delays = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};  // s
constexpr double hours = 10.0;                                            // to a false alarm
constexpr double tests = 40.0;         // a second, one a row of the estimator
constexpr double hardly_seen = 100.0;  // pick-ups that are worth more at asked_delay are not printed

// Covariance of χ before the motion: that of the identification, and what friction has changed since.
Matrix covariance_of(const Arm& arm) {
  Matrix C = arm.model.C_chi;
  for (Index i = 0; i < C.rows(); ++i) {
    const StandardParameter& p = arm.model.base.parameters[static_cast<std::size_t>(i)].leading;
    if (role(p.kind) == Role::dry || role(p.kind) == Role::viscous) {
      const double change = friction_error * arm.model.chi[i];
      C(i, i) += change * change;
    }
  }
  return C;
}

// Weighted normal equations of τ = W χ + L λ, λ the first moments and mass of a body on the last link: A [χ
// λ] = a.
struct Normal {
  Matrix A;
  Vector a;
};

// All ticks from first to last, with velocities and accelerations that nobody measures.
Normal of_ticks(const Arm& arm, const PickUp& scene, Index first, Index last) {
  const Index b = arm.model.base.size();
  const auto part = [&](const Matrix& x) { return Matrix(x.middleRows(first, last - first)); };
  const Motion motion = {part(scene.motion.q), part(scene.motion.qd), part(scene.motion.qdd)};
  const Matrix tau = part(scene.tau.transpose());
  const Vector none = Vector::Zero(arm.chi_st.size());
  std::array<Matrix, 4> L;
  for (Index k = 0; k < 4; ++k) {
    L[static_cast<std::size_t>(k)] =
        torques_of(arm.robot, test::loaded(arm.robot, none, Inertial::Unit(6 + k)), motion);
  }
  Normal out{Matrix::Zero(b + 4, b + 4), Vector::Zero(b + 4)};
  const Observation W = observation(arm.robot, arm.model.base, motion);
  for (std::size_t j = 0; j < W.joints.size(); ++j) {
    const auto at = static_cast<Index>(j);
    std::vector<Index> columns = W.joints[j].columns;
    const auto own = static_cast<Index>(columns.size());
    Matrix rows(motion.samples(), own + 4);
    rows.leftCols(own) = W.joints[j].W;
    for (Index k = 0; k < 4; ++k) {
      rows.col(own + k) = L[static_cast<std::size_t>(k)].col(at);
      columns.push_back(b + k);
    }
    const double weight = 1.0 / (arm.torque_noise[at] * arm.torque_noise[at]);
    out.A(columns, columns) += weight * rows.transpose() * rows;
    out.a(columns) += weight * rows.transpose() * tau.col(at);
  }
  return out;
}

// The rows that the estimator takes of noisy positions and torques, which are finished from tick first to
// last.
Normal of_rows(const Arm& arm, const PickUp& scene, Index first, Index last) {
  const detail::BodyColumns columns(arm.model.robot, arm.model.base);
  const Index b = arm.model.base.size();
  RowStream<double> stream(
      arm.model.robot, columns.all.columns(),
      {.f_m = f_m, .torque_held = false, .velocity_threshold = arm.model.velocity_threshold});
  // Neighbouring windows of Hann overlap: their errors have a correlation of 1/6.
  const double overlap = 1.0 + 2.0 / 6.0;
  Normal out{Matrix::Zero(b + 4, b + 4), Vector::Zero(b + 4)};
  Vector w(b + 4);
  for (Index k = 0; k < last; ++k) {
    if (!stream.update(scene.q.col(k), scene.tau.col(k)) || k < first) {
      continue;
    }
    stream.for_each_row([&](const RowStream<double>::Row& row) {
      w.setZero();
      const std::vector<Index>& own = stream.columns().of_joint(row.joint);
      for (std::size_t c = 0; c < own.size(); ++c) {
        if (own[c] < b) {
          w[own[c]] = row.values[c];
        }
        for (Index i = 0; i < 4; ++i) {
          if (columns.body[static_cast<std::size_t>(6 + i)] == own[c]) {
            w[b + i] = row.values[c];
          }
        }
      }
      const double sigma = arm.model.sigma_rho[static_cast<Index>(row.joint)];
      const double weight = 1.0 / (overlap * sigma * sigma);
      out.A += weight * w * w.transpose();
      out.a += weight * row.y * w;
    });
  }
  return out;
}

// P(χ²₄ > x) = e^(−x/2) (1 + x/2) once in `hours`.
double threshold() {
  const double p = 1.0 / (3600.0 * hours * tests);
  double x = 40.0;
  for (int k = 0; k < 60; ++k) {
    x = 2.0 * (std::log1p(0.5 * x) - std::log(p));
  }
  return x;
}

// The likelihood-ratio test of λ ≠ 0, and what it is on average beside its four degrees of freedom.
struct Test {
  double value = 0.0;
  double mean = 0.0;
};

Test test_of(const PickUp& scene, const Normal& before, const Normal& after) {
  const Index b = before.a.size() - 4;
  // χ is eliminated.
  const Eigen::LLT<Matrix> chi(before.A.topLeftCorner(b, b) + after.A.topLeftCorner(b, b));
  const Matrix coupling = chi.solve(after.A.topRightCorner(b, 4));
  const Matrix S = after.A.bottomRightCorner(4, 4) - after.A.topRightCorner(b, 4).transpose() * coupling;
  const Vector s = after.a.tail(4) - coupling.transpose() * (before.a.head(b) + after.a.head(b));
  const Vector lambda = scene.body.tail<4>();
  return {s.dot(S.llt().solve(s)), lambda.dot(S * lambda)};
}

}  // namespace

void bound_study(const std::string& data, int pick_ups, const std::string& only) {
  std::cout << std::setprecision(3) << "threshold " << threshold() << '\n';
  for (const Arm& arm : arms(data, only)) {
    const Index b = arm.model.base.size();
    const Matrix information = covariance_of(arm).inverse();
    for (int k = 0; k < pick_ups; ++k) {
      const PickUp scene(arm, static_cast<std::uint64_t>(k) + 1);
      for (const auto& [what, normal] : {std::pair{"ticks", &of_ticks}, std::pair{"rows", &of_rows}}) {
        Normal before = normal(arm, scene, 0, scene.change);
        before.A.topLeftCorner(b, b) += information;
        before.a.head(b) += information * arm.model.chi;
        const auto after = [&](double seconds) {
          return test_of(scene, before,
                         normal(arm, scene, scene.change, scene.change + static_cast<Index>(seconds * f_m)));
        };
        if (after(asked_delay).mean > hardly_seen) {
          break;
        }
        std::cout << arm.name << ", " << scene.body[9] << " kg, by " << what << ": test (its mean) after";
        for (const double seconds : delays) {
          const Test test = after(seconds);
          std::cout << "  " << seconds << " s " << test.value << " (" << test.mean << ")";
        }
        std::cout << std::endl;
      }
    }
  }
}

}  // namespace rivid::benchmarks
