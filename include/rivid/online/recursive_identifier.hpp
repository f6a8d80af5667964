#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "rivid/error.hpp"
#include "rivid/online/information_triangle.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/prior.hpp"
#include "rivid/online/row_stream.hpp"
#include "rivid/online/saved_state.hpp"

namespace rivid {

struct RecursiveIdentifierOptions {
  RowStreamOptions rows = {};
  /// Time constant of forgetting: information fades by exp(−t / forgetting) while the robot moves [s]. Infinite: nothing
  /// is forgotten.
  double forgetting = std::numeric_limits<double>::infinity();
  /// Whether the estimate begins with the model's parameters and covariance, else with nothing.
  bool prior = true;

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    if (std::isnan(forgetting) || forgetting <= 0.0) {
      return "forgetting is " + number(forgetting) + " s, must be positive";
    }
    return rows.complaint(joints);
  }
};

/// All base parameters of a robot, in its control loop: recursive least squares on the rows of RowStream, by orthogonal
/// transformations of a triangle, never by normal equations.
///
///   χ̂ = argmin ‖R₀ (χ − χ₀)‖² + Σ ((y − w χ) / σ_j)²,
///
/// with the model's parameters and covariance as R₀ χ₀, unless options say otherwise, and the model's sigma_rho as σ_j. Without
/// prior and forgetting it is the weighted batch estimate of the same rows, to rounding.
///
/// The triangle takes a row over several ticks, so that all ticks cost the same. After the constructor no member
/// allocates, throws or locks. A copy is a snapshot; save_state() writes the state without allocating.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class RecursiveIdentifier {
 public:
  using Values = typename RowStream<Scalar>::Values;

  /// @throws InputError  where model or options can not be used
  explicit RecursiveIdentifier(const OnlineModel& model, const RecursiveIdentifierOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return triangle_.size(); }
  [[nodiscard]] Index joints() const noexcept { return rows_.size(); }

  /// Takes a tick.
  ///
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, (n) [N·m | N]
  void update(const Values& q, const Values& tau) noexcept;

  /// Takes a row of joint j as it is: w χ = y with the deviation sigma [N·m | N].
  ///
  /// @param w  in the order of columns().of_joint(j)
  void add_row(std::size_t j, std::span<const Scalar> w, const Scalar& y, const Scalar& sigma) noexcept;

  /// Takes all rows that wait into the triangle: work that update() would do in the next `stride` ticks.
  void finish() noexcept {
    triangle_.finish([this](const Outcome& outcome) { take(outcome); });
  }

  /// The parameters, (b) [SI, joint side]: back substitution. No numbers while some are not determined.
  [[nodiscard]] const Eigen::VectorX<Scalar>& chi() noexcept {
    static_cast<void>(triangle_.solve(chi_.data()));
    return chi_;
  }

  /// Standard deviation of parameter i by the information of the triangle, for errors of rows that are independent and as
  /// large as sigma_rho says; not a number where it is not determined. consistency() shows whether they are.
  [[nodiscard]] Scalar sigma(Index i) noexcept {
    using std::sqrt;
    if (!triangle_.solve(chi_.data())) {
      return Scalar(std::numeric_limits<double>::quiet_NaN());
    }
    triangle_.inverse_row(i, scratch_.data());
    return sqrt(scratch_.head(size()).squaredNorm());
  }

  /// Mean square of the prediction errors of joint j over their variance, with forgetting (or over all rows): 1 where the rows are as the model says.
  [[nodiscard]] Scalar consistency(Index j) const noexcept {
    const Sums& sums = sums_[static_cast<std::size_t>(j)];
    return static_cast<Scalar>(sums.weight > 0.0 ? sums.squares / sums.weight : 1.0);
  }
  /// Rows that the triangle has taken.
  [[nodiscard]] Index rows() const noexcept { return taken_; }

  /// Adds what another identifier of the same robot has learned, its prior included: merge those that began without one.
  void merge(const RecursiveIdentifier& other) noexcept {
    RecursiveIdentifier* const self = this;
    triangle_.finish([self](const Outcome& outcome) { self->take(outcome); });
    triangle_.merge(other.triangle_, [self](const Outcome& outcome) { self->take(outcome); });
  }
  /// Adds a triangle R χ = z of whitened rows, such as StreamingQr's R() and qty() over a standard deviation.
  ///
  /// @param R  upper triangular, (b × b)
  /// @param z  (b)
  /// @return   whether the sizes are right
  bool merge(const Eigen::Ref<const Eigen::MatrixX<Scalar>>& R, const Values& z) noexcept;

  [[nodiscard]] const RegressorColumns& columns() const noexcept { return rows_.columns(); }

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    rows_.visit_state(visit);
    triangle_.visit_state(visit);
    visit(sums_.data(), sums_.size());
    visit(&taken_, 1);
    visit(&until_fading_, 1);
  }

 private:
  using Triangle = detail::InformationTriangle<Scalar>;
  using Outcome = typename Triangle::Outcome;
  struct Sums {
    double weight = 0.0;
    double squares = 0.0;
  };

  void take(const Outcome& outcome) noexcept {
    if (outcome.tag < 0) {
      return;
    }
    ++taken_;
    Sums& sums = sums_[static_cast<std::size_t>(outcome.tag)];
    const double keep = kept_of_sums_;
    sums.weight = keep * sums.weight + 1.0;
    sums.squares = keep * sums.squares + static_cast<double>(outcome.residual * outcome.residual);
  }
  void make_room() noexcept {
    while (triangle_.full()) {
      static_cast<void>(
          triangle_.work(triangle_.cost_of_row(), [this](const Outcome& outcome) { take(outcome); }));
    }
  }
  void fade() noexcept;

  RowStream<Scalar> rows_;
  Triangle triangle_;
  Vector sigma_rho_;
  double keep_ = 1.0;  // of R after one stride of motion
  double kept_of_sums_ = 1.0;
  Index operations_;  // of each tick
  Eigen::VectorX<Scalar> chi_;
  Eigen::VectorX<Scalar> scratch_;
  std::vector<Sums> sums_;
  Index taken_ = 0;
  Index until_fading_ = 0;
};

template <typename Scalar>
RecursiveIdentifier<Scalar>::RecursiveIdentifier(const OnlineModel& model,
                                                 const RecursiveIdentifierOptions& options)
    : rows_(model.robot, model.base.columns(), detail::row_options("RecursiveIdentifier", model, options)),
      triangle_(model.base.size(), 2 * model.robot.size()),
      sigma_rho_(model.sigma_rho),
      chi_(Eigen::VectorX<Scalar>::Zero(model.base.size())),
      scratch_(Eigen::VectorX<Scalar>::Zero(triangle_.room_of_row())),
      sums_(static_cast<std::size_t>(model.robot.size())) {
  const double seconds = static_cast<double>(rows_.stride()) / options.rows.f_m;
  keep_ = std::exp(-0.5 * seconds / options.forgetting);
  kept_of_sums_ = keep_ * keep_;
  operations_ = rows_.size() * triangle_.cost_of_row() / rows_.stride() + triangle_.size();
  if (options.prior) {
    const Matrix whitening = detail::whitening_of(model.C_chi, "RecursiveIdentifier");
    for (Index i = 0; i < size(); ++i) {
      finish();
      Scalar* const w = triangle_.room();
      double y = 0.0;
      for (Index c = 0; c <= i; ++c) {
        w[c] = static_cast<Scalar>(whitening(i, c));
        y += whitening(i, c) * model.chi[c];
      }
      w[size()] = static_cast<Scalar>(y);
      triangle_.commit(-1);
    }
    finish();
  }
}

template <typename Scalar>
void RecursiveIdentifier<Scalar>::update(const Values& q, const Values& tau) noexcept {
  if (rows_.update(q, tau)) {
    rows_.for_each_row([this](const typename RowStream<Scalar>::Row& row) {
      add_row(row.joint, {row.values, columns().of_joint(row.joint).size()}, row.y,
              static_cast<Scalar>(sigma_rho_[static_cast<Index>(row.joint)]));
    });
    fade();
  }
  static_cast<void>(triangle_.work(operations_, [this](const Outcome& outcome) { take(outcome); }));
  until_fading_ = std::max<Index>(until_fading_ - 1, 0);
}

// Joints finish their rows at ticks of their own; information fades once a stride while any of them moves.
template <typename Scalar>
void RecursiveIdentifier<Scalar>::fade() noexcept {
  if (keep_ < 1.0 && until_fading_ == 0) {
    triangle_.fade(0, size(), static_cast<Scalar>(keep_));
    until_fading_ = rows_.stride();
  }
}

template <typename Scalar>
void RecursiveIdentifier<Scalar>::add_row(std::size_t j, std::span<const Scalar> w, const Scalar& y,
                                          const Scalar& sigma) noexcept {
  make_room();
  Scalar* const row = triangle_.room();
  const std::vector<Index>& own = columns().of_joint(j);
  for (std::size_t c = 0; c < own.size(); ++c) {
    row[own[c]] = w[c] / sigma;
  }
  row[size()] = y / sigma;
  triangle_.commit(static_cast<int>(j));
}

template <typename Scalar>
bool RecursiveIdentifier<Scalar>::merge(const Eigen::Ref<const Eigen::MatrixX<Scalar>>& R,
                                        const Values& z) noexcept {
  if (R.rows() != size() || R.cols() != size() || z.size() != size()) {
    return false;
  }
  for (Index i = 0; i < size(); ++i) {
    make_room();
    Scalar* const row = triangle_.room();
    for (Index c = i; c < size(); ++c) {
      row[c] = R(i, c);
    }
    row[size()] = z[i];
    triangle_.commit(-1);
  }
  finish();
  return true;
}

}  // namespace rivid
