#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "rivid/error.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_triangle.hpp"
#include "rivid/online/saved_state.hpp"

namespace rivid {

struct RecursiveIdentifierOptions {
  RowStreamOptions rows = {};
  /// Time constant of forgetting: information fades by exp(−t / forgetting) while the robot moves [s].
  /// Infinite: nothing is forgotten.
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

/// All base parameters of a robot, in its control loop: recursive least squares on the rows of RowStream, by
/// orthogonal transformations of a triangle, never by normal equations.
///
///   χ̂ = argmin ‖R₀ (χ − χ₀)‖² + Σ ((y − w χ) / σ_j)²,
///
/// with the model's parameters and covariance as R₀ χ₀, unless options say otherwise, and the model's
/// sigma_rho as σ_j. Without prior and forgetting it is the weighted batch estimate of the same rows, to
/// rounding.
///
/// Friction that follows the load is made linear at the model's parameters, see detail::LoadTangent.
///
/// The triangle takes a row over several ticks, so that all ticks cost the same. After the constructor no
/// member allocates, throws or locks. A copy is a snapshot; save_state() writes the state without allocating.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class RecursiveIdentifier {
 public:
  using Values = typename RowStream<Scalar>::Values;

  /// @throws InputError  where model or options can not be used
  explicit RecursiveIdentifier(const OnlineModel& model, const RecursiveIdentifierOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return rows_.triangle().size(); }
  [[nodiscard]] Index joints() const noexcept { return rows_.stream().size(); }

  /// Takes a tick.
  ///
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, (n) [N·m | N]
  void update(const Values& q, const Values& tau) noexcept;

  /// Takes a row of joint j as it is: w χ = y with the deviation sigma [N·m | N]. A joint that is none, or a
  /// row of another size, is left out.
  ///
  /// @param w  in the order of columns().of_joint(j)
  void add_row(std::size_t j, std::span<const Scalar> w, const Scalar& y, const Scalar& sigma) noexcept;

  /// Takes all rows that wait into the triangle: work that update() would do in the next `stride` ticks.
  void finish() noexcept { rows_.triangle().finish(taking()); }

  /// The parameters, (b) [SI, joint side]: back substitution. No numbers while some are not determined.
  [[nodiscard]] const Eigen::VectorX<Scalar>& chi() noexcept {
    static_cast<void>(rows_.triangle().solve(chi_.data()));
    return chi_;
  }

  /// Standard deviation of parameter i by the information of the triangle, for errors of rows that are
  /// independent and as large as sigma_rho says; not a number where it is not determined or there is none.
  /// consistency() shows whether they are.
  [[nodiscard]] Scalar sigma(Index i) noexcept {
    using std::sqrt;
    if (i < 0 || i >= size() || !rows_.triangle().solve(chi_.data())) {
      return Scalar(std::numeric_limits<double>::quiet_NaN());
    }
    return sqrt(rows_.triangle().estimate(i, scratch_.data()).variance);
  }

  /// Mean square of the prediction errors of joint j over their variance, with forgetting (or over all rows):
  /// 1 where the rows are as the model says.
  [[nodiscard]] Scalar consistency(Index j) const noexcept {
    if (j < 0 || j >= joints()) {
      return Scalar(std::numeric_limits<double>::quiet_NaN());
    }
    const Sums& sums = sums_[static_cast<std::size_t>(j)];
    return static_cast<Scalar>(sums.weight > 0.0 ? sums.squares / sums.weight : 1.0);
  }
  /// Rows that the triangle has taken.
  [[nodiscard]] Index rows() const noexcept { return taken_; }

  /// Adds what another identifier of the same robot has learned, its prior included: merge those that began
  /// without one.
  void merge(const RecursiveIdentifier& other) noexcept {
    rows_.triangle().merge(other.rows_.triangle(), taking());
  }
  /// Adds a triangle R χ = z of whitened rows, such as StreamingQr's R() and qty() over a standard deviation.
  ///
  /// @param R  upper triangular, (b × b)
  /// @param z  (b)
  /// @return   whether the sizes are right
  bool merge(const Eigen::Ref<const Eigen::MatrixX<Scalar>>& R, const Values& z) noexcept;

  [[nodiscard]] const RegressorColumns& columns() const noexcept { return rows_.stream().columns(); }

  [[nodiscard]] auto state() noexcept { return std::tie(rows_, sums_, taken_); }
  [[nodiscard]] const detail::StateOwner& state_owner() const noexcept { return owner_; }

 private:
  using Row = typename RowStream<Scalar>::Row;
  using Outcome = typename detail::InformationTriangle<Scalar>::Outcome;
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
    const double keep = rows_.keep() * rows_.keep();
    sums.weight = keep * sums.weight + 1.0;
    sums.squares = keep * sums.squares + static_cast<double>(outcome.residual * outcome.residual);
  }
  [[nodiscard]] auto taking() noexcept {
    return [this](const Outcome& outcome) { take(outcome); };
  }
  void step() noexcept {
    if (rows_.keep() < 1.0) {
      rows_.triangle().fade(0, size(), static_cast<Scalar>(rows_.keep()));
    }
  }

  detail::RowTriangle<Scalar> rows_;
  Vector sigma_rho_;
  Eigen::VectorX<Scalar> chi_;
  Eigen::VectorX<Scalar> scratch_;
  std::vector<Sums> sums_;
  Index taken_ = 0;
  detail::StateOwner owner_;
};

template <typename Scalar>
RecursiveIdentifier<Scalar>::RecursiveIdentifier(const OnlineModel& model,
                                                 const RecursiveIdentifierOptions& options)
    : rows_(detail::usable("RecursiveIdentifier", model, options), model.base.columns(),
            detail::row_options(model, options), model.base.size(), options.forgetting),
      sigma_rho_(model.sigma_rho),
      chi_(Eigen::VectorX<Scalar>::Zero(model.base.size())),
      scratch_(Eigen::VectorX<Scalar>::Zero(rows_.triangle().room_of_row())),
      sums_(static_cast<std::size_t>(model.robot.size())),
      owner_(detail::owner_of<Scalar>("RecursiveIdentifier", model, options.rows, options.forgetting,
                                      options.prior)) {
  if (options.prior) {
    detail::add_prior(
        rows_.triangle(), model.C_chi, model.chi, [](Index i) { return i; }, "RecursiveIdentifier");
  }
}

template <typename Scalar>
void RecursiveIdentifier<Scalar>::update(const Values& q, const Values& tau) noexcept {
  rows_.tick(
      q, tau,
      [this](const Row& row) {
        add_row(row.joint, {row.values, columns().of_joint(row.joint).size()}, row.y,
                static_cast<Scalar>(sigma_rho_[static_cast<Index>(row.joint)]));
      },
      [this] { step(); }, taking());
}

template <typename Scalar>
void RecursiveIdentifier<Scalar>::add_row(std::size_t j, std::span<const Scalar> w, const Scalar& y,
                                          const Scalar& sigma) noexcept {
  if (j >= columns().joints() || w.size() != columns().of_joint(j).size()) {
    return;
  }
  Scalar* const row = rows_.room(taking());
  const std::vector<Index>& own = columns().of_joint(j);
  for (std::size_t c = 0; c < own.size(); ++c) {
    row[own[c]] = w[c] / sigma;
  }
  row[size()] = y / sigma;
  rows_.triangle().commit(static_cast<int>(j));
}

template <typename Scalar>
bool RecursiveIdentifier<Scalar>::merge(const Eigen::Ref<const Eigen::MatrixX<Scalar>>& R,
                                        const Values& z) noexcept {
  if (R.rows() != size() || R.cols() != size() || z.size() != size()) {
    return false;
  }
  for (Index i = 0; i < size(); ++i) {
    Scalar* const row = rows_.room(taking());
    for (Index c = i; c < size(); ++c) {
      row[c] = R(i, c);
    }
    row[size()] = z[i];
    rows_.triangle().commit(-1);
  }
  finish();
  return true;
}

#ifdef RIVID_LIBRARY
extern template class RecursiveIdentifier<double>;
#endif

}  // namespace rivid
