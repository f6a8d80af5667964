#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/regressor/pack.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// Largest inertia that each joint's drive sees along a motion, Eq. (38) of [RIV]:
///
///   J_j = ZZ_j + Ia_j + max_q (M_jj(q) − ZZ_j − Ia_j) = max_q M_jj(q)
///
/// [RIV] takes the maximum over all q; here it is over the samples of `q`, every one of them, which is what
/// the loop meets.
///
/// @param q  joint positions, (n_m × n), n_m ≥ 1 [rad | m]
/// @return   J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     where q does not fit the robot or is not finite
/// @throws NumericsError  where M_jj is not positive at a sample, with joint, sample and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q);

/// How the largest M_jj is searched among all positions.
struct InertiaSearch {
  Index samples = 1024;  ///< positions of the global search, a quasi-random sequence, the same in every run
  Index starts = 4;      ///< the best positions of each joint, from which it is refined

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Largest inertia that each joint's drive sees at all, the J_j of Eq. (38) of [RIV] over all q.
///
/// M_jj depends on the joints behind j only, unless joints depend on others. It is searched over a box of
/// their positions: within the limits of each joint, a revolute joint without limits through one turn. From
/// the best of the positions sampled, M_jj climbs along one coordinate at a time until none gives more. That
/// is a lower bound of the true maximum: it is a local one, in practice the global one, without a proof.
///
/// @return  J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     the search's complaint(); where a prismatic joint beyond the first has no limits
/// @throws NumericsError  where M_jj is not positive at a position that was sampled, with joint and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const InertiaSearch& search = {});

#ifdef RIVID_DEFINITIONS

namespace detail {

template <typename Scalar>
inline void add_link(Composite<Scalar>& body, const DynamicsLink& link) {
  Scalar* const entries[] = {&body.XX, &body.XY,  &body.XZ,  &body.YY,  &body.YZ,
                             &body.ZZ, &body.h.x, &body.h.y, &body.h.z, &body.m};
  for (std::size_t k = 0; k < std::size(entries); ++k) {
    *entries[k] = *entries[k] + Scalar(link.inertial[k]);
  }
}

// The same body, in the frame before joint j.
template <typename Scalar>
inline void carry_back(Composite<Scalar>& body, const DynamicsLink& link, const Scalar& q) {
  Scalar c(link.cos_theta);
  Scalar s(link.sin_theta);
  Vec3<Scalar> p = constant<Scalar>(link.p);
  if (link.revolute) {
    Scalar sin_q;
    Scalar cos_q;
    sin_cos(q, sin_q, cos_q);
    c = cos_q * Scalar(link.cos_theta) - sin_q * Scalar(link.sin_theta);
    s = sin_q * Scalar(link.cos_theta) + cos_q * Scalar(link.sin_theta);
  } else {
    p = p + turned_back<Turn::any>(link.R, Vec3<Scalar>{Scalar(0.0), Scalar(0.0), q});
  }
  carry_composite<Turn::any, 7, true>(link, body, c, s, p);
}

// The diagonal of M alone, which needs no more than composite bodies: a third of what Dynamics takes.
class AxisInertias {
 public:
  explicit AxisInertias(const DynamicModel& model)
      : model_(model), tables_(model), rotor_(model.rotor().diagonal()) {}

  // The first joint that M_jj can depend on.
  [[nodiscard]] Index first_felt(Index j) const { return tables_.dependence.empty() ? j + 1 : 0; }

  // Calls visit(j, M_jj) for the joints n … first.
  template <typename Scalar, typename Position, typename Visit>
  void at(Index first, const Position& position, const Visit& visit) const {
    if (!tables_.dependence.empty()) {
      const Index n = rotor_.size();
      std::vector<Scalar> q;
      for (Index j = 0; j < n; ++j) {
        q.push_back(Scalar(position(j)));
      }
      Dynamics<Scalar> dynamics(model_);
      static_cast<void>(dynamics.set_state(q, std::vector<Scalar>(q.size(), Scalar(0.0))));
      for (Index j = n; j-- > first;) {
        visit(j, dynamics.M(j, j));
      }
      return;
    }
    Composite<Scalar> body = nothing_behind<Scalar>().composite;
    std::vector<Composite<Scalar>> forks(tables_.forks, body);
    for (Index j = rotor_.size() - 1;; --j) {
      const DynamicsLink& link = tables_.links[static_cast<std::size_t>(j)];
      if (link.fork >= 0) {
        add(body, forks[static_cast<std::size_t>(link.fork)]);
      }
      add_link(body, link);
      visit(j, Scalar(rotor_[j]) + (link.revolute ? body.ZZ : body.m));
      if (j == first) {
        return;
      }
      carry_back(body, link, Scalar(position(j)));
      if (link.from != -1) {  // its link's before is no part of it
        if (link.from != on_base) {
          add(forks[static_cast<std::size_t>(link.from)], body);
        }
        body = nothing_behind<Scalar>().composite;
      }
    }
  }

 private:
  const DynamicModel& model_;
  DynamicsTables tables_;
  Vector rotor_;
};

[[noreturn]] inline void refuse_inertia(const DynamicModel& model, Index j, double value,
                                        const std::string& where) {
  const Joint& joint = model.joints()[static_cast<std::size_t>(j)];
  const std::string index = std::to_string(j + 1);
  throw NumericsError("design_inertia: M(" + index + "," + index + ") of joint \"" + joint.name + "\" is " +
                      number(value, 4) + (joint.type == JointType::revolute ? " kg·m²" : " kg") + " " +
                      where + ", must be positive; these parameters move no robot");
}

// The largest of many values, none of which may be negative or zero.
class LargestInertias {
 public:
  explicit LargestInertias(Index n) : J_(Vector::Zero(n)) {}

  template <typename Where>
  void add(const DynamicModel& model, Index j, double value, const Where& where) {
    if (!(value > 0.0)) {
      refuse_inertia(model, j, value, where());
    }
    J_[j] = std::max(J_[j], value);
  }
  [[nodiscard]] const Vector& J() const { return J_; }

 private:
  Vector J_;
};

struct JointRange {
  double low = 0.0, high = 0.0;
};

// Positions of a joint that its M_ii can depend on.
inline JointRange joint_range(const DynamicModel& model, Index j) {
  const Joint& joint = model.joints()[static_cast<std::size_t>(j)];
  const JointRange limits{joint.lower, joint.upper};
  if (joint.type == JointType::revolute && !(limits.high - limits.low < 2.0 * std::numbers::pi)) {
    return {-std::numbers::pi, std::numbers::pi};
  }
  if (!std::isfinite(limits.low) || !std::isfinite(limits.high) || limits.low > limits.high) {
    throw InputError("design_inertia: the limits of joint \"" + joint.name + "\" are " + number(limits.low) +
                     " and " + number(limits.high) +
                     ", must be finite and in order: the inertia grows without bound with the position of a "
                     "prismatic joint");
  }
  return limits;
}

// Root of x^(d+1) = x + 1: its powers give the steps of a sequence that fills the unit cube of d dimensions
// evenly.
inline double generalised_golden_ratio(Index d) {
  double x = 2.0;
  for (int i = 0; i < 60; ++i) {
    x = std::pow(1.0 + x, 1.0 / static_cast<double>(d + 1));
  }
  return x;
}

// Climbs from q to a place where no single coordinate gives more; returns M_jj there.
class InertiaAscent {
 public:
  InertiaAscent(const AxisInertias& inertias, const std::vector<JointRange>& ranges, Index joint)
      : inertias_(inertias), ranges_(ranges), joint_(joint) {}

  [[nodiscard]] double from(Vector q) const {
    constexpr int most_rounds = 50;       // over all joints; a choice that ends what does not settle
    constexpr double negligible = 1e-12;  // relative gain of a round that ends it, 4500 ε
    double best = inertia(q);
    for (int round = 0; round < most_rounds; ++round) {
      const double before = best;
      for (Index k = inertias_.first_felt(joint_); k < q.size(); ++k) {
        best = std::max(best, along(k, q, best));
      }
      if (best <= before * (1.0 + negligible)) {
        break;
      }
    }
    return best;
  }

 private:
  [[nodiscard]] double inertia(const Vector& q) const {
    double out = 0.0;
    inertias_.at<double>(
        joint_, [&](Index k) { return q[k]; },
        [&](Index, double value) { out = value; });  // that of `joint_` comes last
    return out;
  }

  // Moves coordinate k of q to where the inertia is largest, if that is more than `best`.
  double along(Index k, Vector& q, double best) const {
    // Along a revolute joint M_jj has the second harmonic at most: no more than two maxima, on a grid of 15
    // degrees.
    constexpr int grid = 24;
    const auto [low, high] = ranges_[static_cast<std::size_t>(k)];
    const double start = q[k];
    const double step = (high - low) / grid;
    const auto value = [&](double at) {
      q[k] = at;
      return inertia(q);
    };
    double top = start;
    double most = best;
    for (int i = 0; i <= grid; ++i) {
      const double at = low + step * i;
      if (const double here = value(at); here > most) {
        most = here;
        top = at;
      }
    }
    // Golden section around the best place.
    constexpr int sections = 45;
    constexpr double golden = std::numbers::phi - 1.0;
    double a = std::max(low, top - step);
    double b = std::min(high, top + step);
    for (int i = 0; i < sections; ++i) {
      const double left = b - golden * (b - a);
      const double right = a + golden * (b - a);
      if (value(left) > value(right)) {
        b = right;
      } else {
        a = left;
      }
    }
    const double middle = 0.5 * (a + b);
    if (const double here = value(middle); here > most) {
      most = here;
      top = middle;
    }
    q[k] = top;
    return most;
  }

  const AxisInertias& inertias_;
  const std::vector<JointRange>& ranges_;
  Index joint_;
};

}  // namespace detail

RIVID_INLINE Vector design_inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q) {
  if (q.cols() != model.size() || q.rows() < 1) {
    throw InputError("design_inertia: q is (" + std::to_string(q.rows()) + " x " + std::to_string(q.cols()) +
                     "), must have one row a sample and one column for each of " +
                     counted(model.size(), "joint"));
  }
  if (!q.allFinite()) {
    throw InputError("design_inertia: q must be finite");
  }
  const detail::AxisInertias inertias(model);
  detail::LargestInertias largest(model.size());
  const auto add = [&](Index j, double value, Index sample) {
    largest.add(model, j, value, [&] { return "at sample " + std::to_string(sample); });
  };
  constexpr int lanes = Pack::lanes;
  Index sample = 0;
  for (; sample + lanes <= q.rows(); sample += lanes) {
    inertias.at<Pack>(
        0, [&](Index j) { return Pack::load(q.col(j).data() + sample); },
        [&](Index j, const Pack& value) {
          for (int lane = 0; lane < lanes; ++lane) {
            add(j, value[lane], sample + lane);
          }
        });
  }
  for (; sample < q.rows(); ++sample) {
    inertias.at<double>(
        0, [&](Index j) { return q(sample, j); }, [&](Index j, double value) { add(j, value, sample); });
  }
  return largest.J();
}

RIVID_INLINE std::optional<std::string> InertiaSearch::complaint() const {
  constexpr Index most_samples = 10'000'000;  // a choice that bounds time and memory
  if (samples < 1 || samples > most_samples) {
    return "samples is " + std::to_string(samples) + ", must be between 1 and " +
           std::to_string(most_samples);
  }
  if (starts < 1 || starts > samples) {
    return "starts is " + std::to_string(starts) +
           ", must be between 1 and samples = " + std::to_string(samples);
  }
  return std::nullopt;
}

RIVID_INLINE Vector design_inertia(const DynamicModel& model, const InertiaSearch& search) {
  if (const auto complaint = search.complaint()) {
    throw InputError("design_inertia: " + *complaint);
  }
  const Index n = model.size();
  const detail::AxisInertias inertias(model);
  const Index least = inertias.first_felt(0);
  std::vector<detail::JointRange> ranges(
      static_cast<std::size_t>(n));  // the first joint moves nothing relative to itself
  for (Index j = least; j < n; ++j) {
    ranges[static_cast<std::size_t>(j)] = detail::joint_range(model, j);
  }
  Matrix q = Matrix::Zero(search.samples, n);
  const double ratio = detail::generalised_golden_ratio(std::max<Index>(1, n - 1));
  for (Index j = least; j < n; ++j) {
    const auto [low, high] = ranges[static_cast<std::size_t>(j)];
    const double step = std::pow(ratio, -static_cast<double>(j));
    for (Index i = 0; i < search.samples; ++i) {
      const double place = 0.5 + step * static_cast<double>(i);
      q(i, j) = low + (high - low) * (place - std::floor(place));
    }
  }
  Matrix sampled(search.samples, n);
  detail::LargestInertias largest(n);
  for (Index i = 0; i < search.samples; ++i) {
    inertias.at<double>(
        0, [&](Index j) { return q(i, j); },
        [&](Index j, double value) {
          largest.add(model, j, value, [] { return std::string("at a position within the limits"); });
          sampled(i, j) = value;
        });
  }
  Vector J(n);
  std::vector<Index> order(static_cast<std::size_t>(search.samples));
  for (Index j = 0; j < n; ++j) {
    std::iota(order.begin(), order.end(), Index{0});
    std::partial_sort(order.begin(), order.begin() + search.starts, order.end(),
                      [&](Index a, Index b) { return sampled(a, j) > sampled(b, j); });
    const detail::InertiaAscent ascent(inertias, ranges, j);
    J[j] = largest.J()[j];
    for (Index i = 0; i < search.starts; ++i) {
      J[j] = std::max(J[j], ascent.from(q.row(order[static_cast<std::size_t>(i)])));
    }
  }
  return J;
}

#endif

}  // namespace rivid
