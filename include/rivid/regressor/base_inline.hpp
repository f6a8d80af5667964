#pragma once

#include <Eigen/Householder>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "rivid/error.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/regressor.hpp"
#include "rivid/text.hpp"

// What base.hpp declares, for users of rivid::headers; rivid::rivid has it in its archive.
namespace rivid {

namespace detail {

// Place of an inertial parameter in the scan: its rank among the ten columns of frame j, and the pass it
// belongs to.
struct ScanPlace {
  int pass;
  int joint;
  int rank;
  auto operator<=>(const ScanPlace&) const = default;
};

inline ScanPlace scan_place(const Robot& robot, const StandardParameter& p) {
  if (role(p.kind) != Role::inertial) {
    return {2 + (role(p.kind) == Role::rotor ? 0 : 2) + (about(p.kind).coupled ? 1 : 0), p.joint,
            static_cast<int>(p.kind)};
  }
  // By the axes of frame j, whose z is the joint's: the rules speak of those, whatever the link frame calls
  // them.
  const int column = inertial_column(robot.chain.links[static_cast<std::size_t>(p.joint)], p.kind).index;
  constexpr std::array<int, 10> pass = {0, 0, 0, 1, 0, 0, 0, 0, 1, 1};  // YY, MZ, M come later
  return {pass[static_cast<std::size_t>(column)], p.joint, column};
}

// IDM_st at random states, (n samples × N_s).
inline Matrix random_regressor(const Robot& robot, const BaseParametersOptions& options) {
  const RegressorColumns columns(robot, robot.standard_parameters());
  const auto n = static_cast<std::size_t>(robot.size());
  Matrix W = Matrix::Zero(options.samples * robot.size(), columns.size());
  RegressorWorkspace<double> workspace(columns);
  std::mt19937_64 random(options.seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  std::vector<double> q(n);
  std::vector<double> qd(n);
  std::vector<double> qdd(n);
  for (int k = 0; k < options.samples; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      q[j] = symmetric(random) * (robot.chain.links[j].type == JointType::revolute ? 3.14159 : 1.0);
      qd[j] = 3.0 * symmetric(random);
      qdd[j] = 10.0 * symmetric(random);
    }
    robot.chain.into_reach([&](int j) -> double& { return q[static_cast<std::size_t>(j)]; });
    columns.rows(State<double>{q, qd, qdd}, workspace, [&](std::size_t i, Index column, double value) {
      W(k * robot.size() + static_cast<Index>(i), columns.of_joint(i)[static_cast<std::size_t>(column)]) =
          value;
    });
  }
  // Friction that follows the load is independent of all else whatever the robot's parameters are: any will
  // do.
  const std::vector<StandardParameter> standard = robot.standard_parameters();
  for (std::size_t c = 0; c < standard.size(); ++c) {
    if (about(standard[c].kind).basis != Basis::load) {
      continue;
    }
    for (int k = 0; k < options.samples; ++k) {
      const Index row = k * robot.size() + standard[c].joint;
      double load = 0.0;
      for (std::size_t r = 0; r < standard.size(); ++r) {
        load += is_friction(standard[r].kind) ? 0.0 : W(row, static_cast<Index>(r));
      }
      W(row, static_cast<Index>(c)) *= std::abs(load);
    }
  }
  return W;
}

struct Scan {
  std::vector<Index> kept;     // columns in scan order
  std::vector<Index> dropped;  // columns in scan order
  Matrix K;                    // (kept × dropped)
  std::vector<double> left;    // norms of what no kept column explains of a dropped one
  double smallest_kept = 1.0;
  double largest_dropped = 0.0;
  Index weakest_kept = -1;
  Index strongest_dropped = -1;
};

// The largest column of the same unit. A column's own norm says nothing: a joint that should stand still has
// a velocity column of noise, all of which is independent; so has an axis that is vertical but for the digits
// of 1.5708 a gravity column of 4e-6.
inline Vector unit_norms(const Matrix& W, const Robot& robot, std::span<const StandardParameter> standard) {
  const auto unit_of = [&](std::size_t c) {
    return unit(standard[c].kind, robot.chain.links[static_cast<std::size_t>(standard[c].joint)].type);
  };
  const Vector norms = W.colwise().norm();
  Vector out = norms;
  for (std::size_t a = 0; a < standard.size(); ++a) {
    for (std::size_t b = 0; b < standard.size(); ++b) {
      if (unit_of(a) == unit_of(b)) {
        out[static_cast<Index>(a)] = std::max(out[static_cast<Index>(a)], norms[static_cast<Index>(b)]);
      }
    }
  }
  return (out.array() > 0.0).select(out, std::numeric_limits<double>::infinity());
}

// Householder QR that passes over columns which depend on those before them. Plain QR would spend a reflector
// on the rounding noise of such a column, and column pivoting would choose the parameters by their norms.
// Independent parts are relative to `scales`.
inline Scan scan_columns(const Matrix& W, std::span<const Index> order, const Vector& scales,
                         double tolerance) {
  Scan scan;
  Matrix R_kept = Matrix::Zero(W.cols(), W.cols());
  Matrix R_dropped = Matrix::Zero(W.cols(), W.cols());
  std::vector<Vector> reflectors;
  std::vector<double> taus;
  for (const Index c : order) {
    Vector column = W.col(c);
    double workspace = 0.0;
    for (std::size_t r = 0; r < reflectors.size(); ++r) {
      column.tail(column.size() - static_cast<Index>(r))
          .applyHouseholderOnTheLeft(reflectors[r], taus[r], &workspace);
    }
    const auto rank = static_cast<Index>(reflectors.size());
    const double left = rank < column.size() ? column.tail(column.size() - rank).norm() : 0.0;
    const double independent = left / scales[c];
    if (independent > tolerance) {
      if (scan.weakest_kept < 0 || independent < scan.smallest_kept) {
        scan.smallest_kept = independent;
        scan.weakest_kept = c;
      }
      double tau = 0.0;
      double beta = 0.0;
      Vector essential(column.size() - rank - 1);
      column.tail(column.size() - rank).makeHouseholder(essential, tau, beta);
      R_kept.col(rank).head(rank) = column.head(rank);
      R_kept(rank, rank) = beta;
      reflectors.push_back(std::move(essential));
      taus.push_back(tau);
      scan.kept.push_back(c);
    } else {
      if (scan.strongest_dropped < 0 || independent > scan.largest_dropped) {
        scan.largest_dropped = independent;
        scan.strongest_dropped = c;
      }
      R_dropped.col(static_cast<Index>(scan.dropped.size())).head(rank) = column.head(rank);
      scan.dropped.push_back(c);
      scan.left.push_back(left);
    }
  }
  const auto b = static_cast<Index>(scan.kept.size());
  const auto d = static_cast<Index>(scan.dropped.size());
  scan.K = R_kept.topLeftCorner(b, b).triangularView<Eigen::Upper>().solve(R_dropped.topLeftCorner(b, d));
  return scan;
}

// K without the coefficients of which too little is seen: what they stand for moves the torques by at most
// `unseen`, the norm of a column, of each dropped parameter.
inline Matrix without_unseen(const Scan& scan, const Vector& norms, std::span<const double> unseen) {
  Matrix K = scan.K;
  for (Index d = 0; d < K.cols(); ++d) {
    for (Index i = 0; i < K.rows(); ++i) {
      if (std::abs(K(i, d)) * norms[scan.kept[static_cast<std::size_t>(i)]] <=
          unseen[static_cast<std::size_t>(d)]) {
        K(i, d) = 0.0;
      }
    }
  }
  return K;
}

// ZZ1 + Ia1 + 0.25 M2: a regrouping as a person writes it.
inline std::string written(const std::vector<std::pair<std::string, double>>& terms) {
  std::string out = terms.front().first;
  for (std::size_t i = 1; i < terms.size(); ++i) {
    const auto& [name, k] = terms[i];
    out += k < 0.0 ? " - " : " + ";
    const std::string factor = number(std::abs(k), 6);
    if (factor != "1") {
      out += factor + " ";
    }
    out += name;
  }
  return out;
}

// Columns in the order of the scan.
inline std::vector<Index> scan_order(const Robot& robot, std::span<const StandardParameter> standard) {
  std::vector<Index> order(standard.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, {},
                           [&](Index c) { return scan_place(robot, standard[static_cast<std::size_t>(c)]); });
  return order;
}

// Base parameters back from the order of the scan to that of the standard parameters, named and written out
// with the coefficients that are shown, (kept × dropped).
inline BaseParameters named(const Robot& robot, std::vector<StandardParameter> standard, const Scan& scan,
                            const Matrix& shown) {
  BaseParameters base;
  base.standard = std::move(standard);
  base.smallest_kept = scan.smallest_kept;
  base.largest_dropped = scan.largest_dropped;
  base.weakest_kept = scan.weakest_kept;
  base.strongest_dropped = scan.strongest_dropped;
  const auto ascending = [](const std::vector<Index>& columns) {
    std::vector<Index> places(columns.size());
    std::iota(places.begin(), places.end(), Index{0});
    std::ranges::sort(places, {}, [&](Index i) { return columns[static_cast<std::size_t>(i)]; });
    return places;
  };
  const std::vector<Index> kept = ascending(scan.kept);
  const std::vector<Index> dropped = ascending(scan.dropped);
  for (const Index i : kept) {
    base.leading.push_back(scan.kept[static_cast<std::size_t>(i)]);
  }
  for (const Index i : dropped) {
    base.dependent.push_back(scan.dropped[static_cast<std::size_t>(i)]);
  }
  base.K = shown(kept, dropped);  // for regrouping(), which the texts come from
  for (Index i = 0; i < base.K.rows(); ++i) {
    const StandardParameter& leading =
        base.standard[static_cast<std::size_t>(base.leading[static_cast<std::size_t>(i)])];
    const auto terms = base.regrouping(i);
    const JointType type = robot.chain.links[static_cast<std::size_t>(leading.joint)].type;
    base.parameters.push_back({leading, leading.name() + (terms.size() > 1 ? "R" : ""), written(terms),
                               std::string(unit(leading.kind, type))});
  }
  base.K = scan.K(kept, dropped);
  return base;
}

RIVID_INLINE BaseParameters base_of(const Robot& robot, const Matrix& W, double tolerance,
                                    SmallCoefficients small) {
  std::vector<StandardParameter> standard = robot.standard_parameters();
  const Vector scales = unit_norms(W, robot, standard);
  Scan scan = scan_columns(W, scan_order(robot, standard), scales, tolerance);
  const Vector norms = W.colwise().norm();
  std::vector<double> tolerated;
  for (const Index c : scan.dropped) {
    tolerated.push_back(tolerance * scales[c]);
  }
  const Matrix shown = without_unseen(scan, norms, tolerated);
  if (small == SmallCoefficients::dropped) {
    scan.K = shown;
  } else {
    // Rounding noise of the factorisation is not a regrouping.
    constexpr double noise = 1e-9;
    scan.K = (scan.K.array().abs() < noise).select(0.0, scan.K);
    // Nor is what a column that depends but for the digits of 1.5708 has of others: it follows the states
    // that were drawn, and moves the torques by less than what is left out anyway.
    scan.K = without_unseen(scan, norms, scan.left);
  }
  return named(robot, std::move(standard), scan, shown);
}

}  // namespace detail

RIVID_INLINE std::vector<std::pair<std::string, double>> BaseParameters::regrouping(Index i) const {
  const auto at = [](const std::vector<Index>& list, Index k) { return list[static_cast<std::size_t>(k)]; };
  const auto standard_name = [&](Index c) { return standard[static_cast<std::size_t>(c)].name(); };
  std::vector<std::pair<std::string, double>> out = {{standard_name(at(leading, i)), 1.0}};
  for (Index c = 0; c < K.cols(); ++c) {
    if (K(i, c) != 0.0) {
      out.emplace_back(standard_name(at(dependent, c)), K(i, c));
    }
  }
  return out;
}

RIVID_INLINE std::vector<StandardParameter> BaseParameters::columns() const {
  std::vector<StandardParameter> out;
  out.reserve(parameters.size());
  for (const BaseParameter& p : parameters) {
    out.push_back(p.leading);
  }
  return out;
}

RIVID_INLINE Vector BaseParameters::from_standard(const Eigen::Ref<const Vector>& chi_st) const {
  if (chi_st.size() != static_cast<Index>(standard.size())) {
    throw InputError("from_standard: chi_st has " + std::to_string(chi_st.size()) + " entries, must have " +
                     std::to_string(standard.size()));
  }
  return chi_st(leading) + K * chi_st(dependent);
}

RIVID_INLINE Vector BaseParameters::to_standard(const Eigen::Ref<const Vector>& chi) const {
  if (chi.size() != size()) {
    throw InputError("to_standard: chi has " + std::to_string(chi.size()) + " entries, must have " +
                     std::to_string(size()));
  }
  Vector chi_st = Vector::Zero(static_cast<Index>(standard.size()));
  chi_st(leading) = chi;
  return chi_st;
}

RIVID_INLINE Matrix BaseParameters::null_space() const {
  Matrix Z = Matrix::Zero(static_cast<Index>(standard.size()), K.cols());
  Z(leading, Eigen::all) = -K;
  Z(dependent, Eigen::all) = Matrix::Identity(K.cols(), K.cols());
  return Z;
}

RIVID_INLINE double BaseParameters::rank_gap() const {
  return smallest_kept / std::max(largest_dropped, std::numeric_limits<double>::epsilon());
}

RIVID_INLINE std::optional<std::string> BaseParameters::doubt() const {
  constexpr double clear_gap = 100.0;           // smallest pivot kept over largest dropped; a choice
  constexpr double clearly_independent = 0.01;  // arms have 0.07 and more
  if (weakest_kept < 0) {
    return std::nullopt;
  }
  const auto name_of = [&](Index c) { return standard[static_cast<std::size_t>(c)].name(); };
  if (rank_gap() >= clear_gap) {
    if (smallest_kept >= clearly_independent) {
      return std::nullopt;
    }
    return "only " + number(smallest_kept, 2) + " of the torques of " + name_of(weakest_kept) +
           " tell it from the other parameters; if the digits of an angle make that difference (1.57 for "
           "1.570796327), write more of them, or set base_tolerance of the robot above it";
  }
  std::string out = "the number of base parameters is not clear: of " + name_of(weakest_kept) + ", kept, " +
                    number(smallest_kept, 3) + " is independent of the other parameters";
  if (strongest_dropped >= 0) {
    out += ", of " + name_of(strongest_dropped) + ", regrouped, " + number(largest_dropped, 3);
  }
  return out + "; between the two should lie a factor of 100 at least";
}

RIVID_INLINE std::optional<std::string> BaseParameters::complaint(const Robot& robot) const {
  const auto same = [](const StandardParameter& a, const StandardParameter& b) {
    return a.kind == b.kind && a.joint == b.joint;
  };
  const auto leads_none = [&](const BaseParameter& p) {
    return std::ranges::none_of(standard, [&](const StandardParameter& s) { return same(s, p.leading); });
  };
  if (!std::ranges::equal(standard, robot.standard_parameters(), same) ||
      std::ranges::any_of(parameters, leads_none)) {
    return "the base parameters are those of another robot than \"" + robot.name +
           "\", or of other friction laws; take base_parameters(robot)";
  }
  return std::nullopt;
}

RIVID_INLINE std::optional<std::string> BaseParametersOptions::complaint() const {
  if (samples < 20) {
    return "samples is " + std::to_string(samples) + ", must be at least 20";
  }
  return std::nullopt;
}

RIVID_INLINE BaseParameters base_parameters(const Robot& robot, const BaseParametersOptions& options) {
  if (const auto complaint = robot.complaint()) {
    throw InputError("base_parameters: " + *complaint);
  }
  if (const auto complaint = options.complaint()) {
    throw InputError("base_parameters: " + *complaint);
  }
  BaseParameters base = detail::base_of(robot, detail::random_regressor(robot, options), robot.base_tolerance,
                                        detail::SmallCoefficients::kept);
  if (base.size() == 0) {
    throw InputError("base_parameters: robot \"" + robot.name +
                     "\" has no parameter that shows in its torques; check its axes and units");
  }
  return base;
}

}  // namespace rivid
