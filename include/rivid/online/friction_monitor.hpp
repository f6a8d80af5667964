#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_noise.hpp"
#include "rivid/online/row_triangle.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/text.hpp"

namespace rivid {

struct FrictionMonitorOptions {
  RowStreamOptions rows = {};
  double forgetting = 30.0;  ///< time constant of what is known of friction, while the robot moves [s]
  /// Whether friction follows a quantity θ of each joint too, such as its temperature or the time: F + F′ θ
  /// in place of each coefficient F of dry and viscous friction. Count it from its value during the
  /// identification.
  bool regressor = false;
  double regressor_scale =
      0.02;  ///< relative change of a coefficient by one unit of θ, as a standard deviation
  /// Root mean square of the torque error by drifted friction above which a new identification is advised,
  /// (n) [N·m | N]. Empty: the deviation of the residual that the model had, sigma_rho.
  Vector limit = {};

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    if (!(forgetting > 0.0) || !(regressor_scale > 0.0)) {
      return "forgetting is " + number(forgetting) + " s and regressor_scale " + number(regressor_scale) +
             ", must be positive";
    }
    if (limit.size() != 0 && (limit.size() != joints || !(limit.array() > 0.0).all())) {
      return "limit must have " + std::to_string(joints) + " positive values, one a joint";
    }
    return rows.complaint(joints);
  }
};

/// Friction in the control loop: the coefficients of each joint now, how far they have drifted since the
/// identification, and whether that matters.
///
/// All base parameters are estimated recursively from the rows of RowStream, with the model's estimate and
/// covariance as what is known beforehand, as RecursiveIdentifier does. Only what is known of friction fades:
/// R's rows of friction stand above those of the others, so that these keep their information while the
/// former forget. A drift of friction does not move inertias, and a load moves friction only if set_payload()
/// does not name it.
///
/// After the constructor no member allocates, throws or locks. A parameter's value is as many ticks old as
/// there are coefficients at most.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class FrictionMonitor {
 public:
  using Values = typename RowStream<Scalar>::Values;

  /// A coefficient of friction: a base parameter, or its slope by θ.
  struct Coefficient {
    Index joint = 0;
    ParameterKind kind = ParameterKind::Fc;
    bool slope = false;       ///< F′, by one unit of θ
    double identified = 0.0;  ///< its value in the model [SI, joint side]
    double identified_sigma = 0.0;
    [[nodiscard]] std::string name() const {
      return std::string(symbol(kind)) + std::to_string(joint + 1) + (slope ? "'" : "");
    }
  };

  /// @throws InputError  where model or options can not be used, or the model has no friction
  explicit FrictionMonitor(const OnlineModel& model, const FrictionMonitorOptions& options = {});

  [[nodiscard]] Index joints() const noexcept { return rows_.stream().size(); }
  [[nodiscard]] const std::vector<Coefficient>& coefficients() const noexcept { return coefficients_; }

  /// Takes a tick.
  ///
  /// @param q      positions, (n) [rad | m]
  /// @param tau    torques, joint side, (n) [N·m | N]
  /// @param theta  θ of each joint, (n); not looked at without FrictionMonitorOptions::regressor
  void update(const Values& q, const Values& tau, const Values& theta) noexcept;
  void update(const Values& q, const Values& tau) noexcept { update(q, tau, none_); }

  /// A body on the last link that the model does not have, XX … M in the frame of that link:
  /// PayloadEstimator::inertial().
  void set_payload(const Eigen::Matrix<Scalar, inertial_count, 1>& body) noexcept {
    body_ = body;
    rows_.set_body(body_, columns_.body);
  }

  /// Coefficient i now, with θ = 0 [SI, joint side]. Of a coefficient or joint that is none, these members
  /// give no number.
  [[nodiscard]] Scalar value(Index i) const noexcept { return entry(values_, i); }
  [[nodiscard]] Scalar sigma(Index i) const noexcept { return entry(sigmas_, i); }
  /// Distance from the identified value in standard deviations of both.
  [[nodiscard]] Scalar drift(Index i) const noexcept {
    using std::sqrt;
    if (i < 0 || i >= count()) {
      return std::numeric_limits<Scalar>::quiet_NaN();
    }
    const Coefficient& c = coefficients_[static_cast<std::size_t>(i)];
    const auto before = static_cast<Scalar>(c.identified_sigma);
    return (values_[i] - static_cast<Scalar>(c.identified)) / sqrt(sigmas_[i] * sigmas_[i] + before * before);
  }
  /// Root mean square of the torque error of joint j that the drift of its friction means for the motion of
  /// late [N·m | N].
  [[nodiscard]] Scalar torque_error(Index j) const noexcept;
  /// Whether the torque error of joint j exceeds its limit: identify anew, or take the values from here.
  [[nodiscard]] bool identify_anew(Index j) const noexcept {
    return j >= 0 && j < joints() && torque_error(j) > static_cast<Scalar>(limit_[j]);
  }

  /// All base parameters, (b) [SI, joint side], by back substitution: inertial ones as what is known
  /// beforehand and all rows say.
  [[nodiscard]] const Eigen::VectorX<Scalar>& chi() noexcept;

  /// All work that waits, and the solution: what the next ticks would do.
  void finish() noexcept {
    rows_.triangle().finish(taking());
    for (Index i = 0; i < count(); ++i) {
      solve_a_row();
    }
  }

  [[nodiscard]] auto state() noexcept {
    return std::tie(rows_, noise_, squares_, values_, sigmas_, body_, counters_);
  }
  [[nodiscard]] const detail::StateOwner& state_owner() const noexcept { return owner_; }

 private:
  using Row = typename RowStream<Scalar>::Row;
  using Outcome = typename detail::InformationTriangle<Scalar>::Outcome;
  struct Counters {
    Index prior_row = 0;
    Index solution_row = 0;
  };
  // Where a column of the rows goes; −1: nowhere.
  struct Place {
    Index column = -1;
    Index slope = -1;
    Index body = -1;
  };
  // Coefficients of one joint, in the order of its mean squares.
  struct Own {
    std::vector<Index> coefficients;
    std::size_t first = 0;  // of its mean squares
  };
  // A friction that nothing is known of has this many times its identified value as deviation.
  static constexpr double hardly_known = 1.0;

  [[nodiscard]] static std::vector<Coefficient> coefficients_of(const OnlineModel& model,
                                                                const FrictionMonitorOptions& options);
  void find_places();
  void make_prior(const OnlineModel& model);
  [[nodiscard]] Scalar entry(const Eigen::VectorX<Scalar>& of, Index i) const noexcept {
    return i >= 0 && i < of.size() ? of[i] : std::numeric_limits<Scalar>::quiet_NaN();
  }
  [[nodiscard]] Index count() const noexcept { return static_cast<Index>(coefficients_.size()); }
  void add(const Row& row, const Values& theta) noexcept;
  [[nodiscard]] auto taking() noexcept {
    return [this](const Outcome& outcome) { take(outcome); };
  }
  void take(const Outcome& outcome) noexcept {
    if (outcome.tag >= 0) {
      const auto kind = static_cast<std::size_t>(outcome.tag);
      noise_.take(kind, static_cast<double>(outcome.residual) * noise_.sigma(kind));
    }
  }
  void step() noexcept;
  void solve_a_row() noexcept;

  detail::BodyColumns columns_;
  Index b_;
  std::vector<Coefficient> coefficients_;
  Index slopes_;                      // of the coefficients, the last ones
  detail::RowTriangle<Scalar> rows_;  // into that of [friction, slopes, all else]
  std::vector<Index> place_of_chi_;
  std::vector<Place> places_;  // of the columns of the rows
  std::vector<Own> own_;
  detail::RowNoise noise_;
  Vector limit_;
  std::vector<Scalar> weak_;     // 1 / deviation of coefficients of which nothing is known
  std::vector<double> squares_;  // mean products of the columns of each joint's friction, with θ
  std::vector<Scalar> scratch_;
  std::vector<Scalar> phi_;
  Eigen::VectorX<Scalar> values_, sigmas_, chi_, solution_, none_;
  Eigen::Matrix<Scalar, inertial_count, 1> body_ = Eigen::Matrix<Scalar, inertial_count, 1>::Zero();
  Counters counters_;
  detail::StateOwner owner_;
};

template <typename Scalar>
auto FrictionMonitor<Scalar>::coefficients_of(const OnlineModel& model, const FrictionMonitorOptions& options)
    -> std::vector<Coefficient> {
  std::vector<Coefficient> out;
  for (const bool slope : {false, true}) {
    for (Index i = 0; i < model.base.size() && (!slope || options.regressor); ++i) {
      const StandardParameter& p = model.base.parameters[static_cast<std::size_t>(i)].leading;
      const Role what = role(p.kind);
      if (!is_friction(p.kind) || (slope && what != Role::dry && what != Role::viscous)) {
        continue;
      }
      out.push_back(
          {p.joint, p.kind, slope, slope ? 0.0 : model.chi[i],
           slope ? options.regressor_scale * std::abs(model.chi[i]) : std::sqrt(model.C_chi(i, i))});
    }
  }
  if (out.empty()) {
    throw InputError("FrictionMonitor: the model has no friction");
  }
  return out;
}

template <typename Scalar>
FrictionMonitor<Scalar>::FrictionMonitor(const OnlineModel& model, const FrictionMonitorOptions& options)
    : columns_(detail::usable("FrictionMonitor", model, options).robot, model.base),
      b_(model.base.size()),
      coefficients_(coefficients_of(model, options)),
      slopes_(std::ranges::count_if(coefficients_, [](const Coefficient& c) { return c.slope; })),
      rows_(model, columns_.all.columns(), detail::row_options(model, options), b_ + slopes_,
            options.forgetting, 1),
      own_(model.robot.joints.size()),
      noise_(model.sigma_rho, detail::row_options(model, options).velocity_threshold, rows_.seconds()),
      limit_(options.limit.size() > 0 ? options.limit : model.sigma_rho),
      scratch_(static_cast<std::size_t>(rows_.triangle().room_of_row()), Scalar(0)),
      phi_(coefficients_.size(), Scalar(0)),
      values_(Eigen::VectorX<Scalar>::Zero(count())),
      sigmas_(values_),
      chi_(Eigen::VectorX<Scalar>::Zero(b_)),
      solution_(Eigen::VectorX<Scalar>::Zero(b_ + slopes_)),
      none_(Eigen::VectorX<Scalar>::Zero(model.robot.size())),
      owner_(detail::owner_of<Scalar>("FrictionMonitor", model, options.rows, options.forgetting,
                                      options.regressor, options.regressor_scale, options.limit)) {
  std::size_t products = 0;
  for (Index i = 0; i < count(); ++i) {
    own_[static_cast<std::size_t>(coefficients_[static_cast<std::size_t>(i)].joint)].coefficients.push_back(
        i);
  }
  for (Own& own : own_) {
    own.first = products;
    products += own.coefficients.size() * own.coefficients.size();
  }
  squares_.assign(products, 0.0);
  find_places();
  make_prior(model);
  finish();
}

template <typename Scalar>
void FrictionMonitor<Scalar>::find_places() {
  const auto find = [&](const StandardParameter& p, bool slope) {
    const auto at = std::ranges::find_if(coefficients_, [&](const Coefficient& c) {
      return c.joint == p.joint && c.kind == p.kind && c.slope == slope;
    });
    return at == coefficients_.end() ? Index{-1} : static_cast<Index>(at - coefficients_.begin());
  };
  places_.resize(columns_.all.parameters.size());
  Index next = count();
  for (Index i = 0; i < static_cast<Index>(places_.size()); ++i) {
    const StandardParameter& p = columns_.all.parameters[static_cast<std::size_t>(i)].leading;
    Place& place = places_[static_cast<std::size_t>(i)];
    if (i < b_) {
      place.column = is_friction(p.kind) ? find(p, false) : next++;
      place.slope = is_friction(p.kind) ? find(p, true) : -1;
      place_of_chi_.push_back(place.column);
    }
    for (std::size_t k = 0; k < inertial_count; ++k) {
      place.body = columns_.body[k] == i ? static_cast<Index>(k) : place.body;
    }
  }
}

template <typename Scalar>
void FrictionMonitor<Scalar>::make_prior(const OnlineModel& model) {
  detail::add_prior(
      rows_.triangle(), model.C_chi, model.chi,
      [this](Index i) { return place_of_chi_[static_cast<std::size_t>(i)]; }, "FrictionMonitor");
  for (Index i = 0; i < count(); ++i) {
    const Coefficient& c = coefficients_[static_cast<std::size_t>(i)];
    // Offsets change with the dry friction of their joint.
    double size = std::abs(c.identified);
    for (const Coefficient& other : coefficients_) {
      if (other.joint == c.joint && !c.slope && about(c.kind).basis != Basis::load &&
          about(other.kind).basis == Basis::sign) {
        size = std::max(size, std::abs(other.identified));
      }
    }
    const double sigma = c.slope ? std::max(c.identified_sigma, 1e-12)
                                 : std::max(hardly_known * size, 10.0 * c.identified_sigma);
    weak_.push_back(static_cast<Scalar>(1.0 / sigma));
    if (c.slope) {
      rows_.triangle().room()[i] = weak_.back();
      rows_.triangle().commit(-1);
      rows_.triangle().finish([](const Outcome& /*outcome*/) {});
    }
  }
}

template <typename Scalar>
void FrictionMonitor<Scalar>::update(const Values& q, const Values& tau, const Values& theta) noexcept {
  if (theta.size() != joints() || !theta.allFinite()) {
    return;
  }
  rows_.tick(q, tau, [&](const Row& row) { add(row, theta); }, [this] { step(); }, taking());
  solve_a_row();
}

template <typename Scalar>
void FrictionMonitor<Scalar>::add(const Row& row, const Values& theta) noexcept {
  Scalar* const w = rows_.room(taking());
  const std::vector<Index>& columns = rows_.stream().columns().of_joint(row.joint);
  const std::size_t kind = noise_.kind(row.joint, static_cast<double>(row.speed));
  const Scalar weight = Scalar(1) / static_cast<Scalar>(noise_.sigma(kind));
  Scalar y = row.y;
  std::ranges::fill(phi_, Scalar(0));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto at = static_cast<std::size_t>(columns[c]);
    const Place& place = places_[at];
    const Scalar value = row.values[c];
    if (place.body >= 0) {
      y = y - value * body_[place.body];
    }
    if (place.column >= 0) {
      w[place.column] = value * weight;
      if (place.column < count()) {
        phi_[static_cast<std::size_t>(place.column)] = value;
      }
    }
    if (place.slope >= 0) {
      const Scalar by_theta = value * theta[coefficients_[static_cast<std::size_t>(place.slope)].joint];
      w[place.slope] = by_theta * weight;
      phi_[static_cast<std::size_t>(place.slope)] = by_theta;
    }
  }
  w[rows_.triangle().size()] = y * weight;
  rows_.triangle().commit(static_cast<int>(kind));
  const double share = 1.0 - rows_.keep() * rows_.keep();
  const Own& own = own_[row.joint];
  const std::size_t size = own.coefficients.size();
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < size; ++k) {
      double& mean = squares_[own.first + i * size + k];
      const Scalar product = phi_[static_cast<std::size_t>(own.coefficients[i])] *
                             phi_[static_cast<std::size_t>(own.coefficients[k])];
      mean += share * (static_cast<double>(product) - mean);
    }
  }
}

// Once a stride while anything moves: what is known of friction fades, and the little that is always known
// comes back.
template <typename Scalar>
void FrictionMonitor<Scalar>::step() noexcept {
  rows_.triangle().fade(0, count() - slopes_, static_cast<Scalar>(rows_.keep()));
  const Index i = counters_.prior_row;
  const Coefficient& c = coefficients_[static_cast<std::size_t>(i)];
  if (!c.slope) {
    Scalar* const w = rows_.room(taking());
    w[i] = weak_[static_cast<std::size_t>(i)] * static_cast<Scalar>(rows_.repeated(count()));
    w[rows_.triangle().size()] = w[i] * static_cast<Scalar>(c.identified);
    rows_.triangle().commit(-1);
  }
  counters_.prior_row = (i + 1) % count();
}

template <typename Scalar>
void FrictionMonitor<Scalar>::solve_a_row() noexcept {
  using std::sqrt;
  const Index i = counters_.solution_row;
  const auto [value, variance] = rows_.triangle().estimate(i, scratch_.data());
  values_[i] = value;
  sigmas_[i] = sqrt(variance);
  counters_.solution_row = (i + 1) % count();
}

template <typename Scalar>
Scalar FrictionMonitor<Scalar>::torque_error(Index j) const noexcept {
  using std::sqrt;
  if (j < 0 || j >= joints()) {
    return std::numeric_limits<Scalar>::quiet_NaN();
  }
  const Own& own = own_[static_cast<std::size_t>(j)];
  const std::size_t size = own.coefficients.size();
  double sum = 0.0;
  const auto off = [&](std::size_t i) {
    const Index c = own.coefficients[i];
    return static_cast<double>(values_[c]) - coefficients_[static_cast<std::size_t>(c)].identified;
  };
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < size; ++k) {
      sum += off(i) * squares_[own.first + i * size + k] * off(k);
    }
  }
  return static_cast<Scalar>(std::sqrt(std::max(sum, 0.0)));
}

template <typename Scalar>
const Eigen::VectorX<Scalar>& FrictionMonitor<Scalar>::chi() noexcept {
  static_cast<void>(rows_.triangle().solve(solution_.data()));
  for (Index i = 0; i < b_; ++i) {
    chi_[i] = solution_[place_of_chi_[static_cast<std::size_t>(i)]];
  }
  return chi_;
}

#ifdef RIVID_LIBRARY
extern template class FrictionMonitor<double>;
#endif

}  // namespace rivid
