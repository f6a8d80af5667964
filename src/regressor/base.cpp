#include "rivid/regressor/base.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "rivid/error.hpp"
#include "rivid/regressor/columns.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Place of an inertial parameter in the scan: its rank among the ten columns of frame j, and the pass it belongs to.
struct ScanPlace {
  int pass;
  int joint;
  int rank;
  auto operator<=>(const ScanPlace&) const = default;
};

ScanPlace scan_place(const Robot& robot, const StandardParameter& p) {
  if (p.kind == ParameterKind::Ia) {
    return {2, p.joint, 0};
  }
  if (p.kind > ParameterKind::Ia) {
    return {3, p.joint, static_cast<int>(p.kind)};
  }
  // By the axes of frame j, whose z is the joint's: the rules speak of those, whatever the link frame calls them.
  const int column = inertial_column(robot.chain.links[static_cast<std::size_t>(p.joint)], p.kind).index;
  constexpr std::array<int, 10> pass = {0, 0, 0, 1, 0, 0, 0, 0, 1, 1};
  return {pass[static_cast<std::size_t>(column)], p.joint, column};
}

// IDM_st at random states, (n samples × N_s).
Matrix random_regressor(const Robot& robot, std::span<const StandardParameter> standard,
                        const BaseParametersOptions& options) {
  const RegressorColumns columns(robot, standard);
  const auto n = static_cast<std::size_t>(robot.size());
  Matrix W = Matrix::Zero(options.samples * robot.size(), columns.size());
  RegressorWorkspace<double> workspace(robot.chain);
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
    columns.rows(
        robot.chain, State<double>{q, qd, qdd}, workspace, [&](std::size_t i, Index column, double value) {
          W(k * robot.size() + static_cast<Index>(i), columns.of_joint(i)[static_cast<std::size_t>(column)]) =
              value;
        });
  }
  return W;
}

struct Scan {
  std::vector<Index> kept;     // columns in scan order
  std::vector<Index> dropped;  // columns in scan order
  Matrix K;                    // (kept × dropped)
  double smallest_kept = 1.0;
  double largest_dropped = 0.0;
};

// Householder QR that passes over columns which depend on those before them. Plain QR would spend a reflector on
// the rounding noise of such a column, and column pivoting would choose the parameters by their norms.
Scan scan_columns(const Matrix& W, std::span<const Index> order, double tolerance) {
  Scan scan;
  Matrix R_kept = Matrix::Zero(W.cols(), W.cols());
  Matrix R_dropped = Matrix::Zero(W.cols(), W.cols());
  std::vector<Vector> reflectors;
  std::vector<double> taus;
  // What would cancel to zero on paper leaves a column of rounding noise, which must not count as independent.
  constexpr double noise_norm = 1e-12;
  const double least_norm = noise_norm * W.colwise().norm().maxCoeff();
  for (const Index c : order) {
    Vector column = W.col(c);
    const double norm = column.norm();
    double workspace = 0.0;
    for (std::size_t r = 0; r < reflectors.size(); ++r) {
      column.tail(column.size() - static_cast<Index>(r))
          .applyHouseholderOnTheLeft(reflectors[r], taus[r], &workspace);
    }
    const auto rank = static_cast<Index>(reflectors.size());
    const double independent =
        norm > least_norm && rank < column.size() ? column.tail(column.size() - rank).norm() / norm : 0.0;
    if (independent > tolerance) {
      scan.smallest_kept = std::min(scan.smallest_kept, independent);
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
      scan.largest_dropped = std::max(scan.largest_dropped, independent);
      R_dropped.col(static_cast<Index>(scan.dropped.size())).head(rank) = column.head(rank);
      scan.dropped.push_back(c);
    }
  }
  const auto b = static_cast<Index>(scan.kept.size());
  const auto d = static_cast<Index>(scan.dropped.size());
  scan.K = R_kept.topLeftCorner(b, b).triangularView<Eigen::Upper>().solve(R_dropped.topLeftCorner(b, d));
  return scan;
}

// Rounding noise of the factorisation is not a regrouping: entries below this are zero.
constexpr double coefficient_noise = 1e-9;

// ZZ1 + Ia1 + 0.25 M2: a regrouping as a person writes it.
std::string written(const std::vector<std::pair<std::string, double>>& terms) {
  std::string out = terms.front().first;
  for (std::size_t i = 1; i < terms.size(); ++i) {
    const auto& [name, k] = terms[i];
    out += k < 0.0 ? " - " : " + ";
    out += std::abs(std::abs(k) - 1.0) < coefficient_noise ? name : number(std::abs(k), 6) + " " + name;
  }
  return out;
}

}  // namespace

std::vector<std::pair<std::string, double>> BaseParameters::regrouping(Index i) const {
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

std::vector<StandardParameter> BaseParameters::columns() const {
  std::vector<StandardParameter> out;
  out.reserve(parameters.size());
  for (const BaseParameter& p : parameters) {
    out.push_back(p.leading);
  }
  return out;
}

Vector BaseParameters::from_standard(const Eigen::Ref<const Vector>& chi_st) const {
  if (chi_st.size() != static_cast<Index>(standard.size())) {
    throw InputError("from_standard: chi_st has " + std::to_string(chi_st.size()) + " entries, must have " +
                     std::to_string(standard.size()));
  }
  return chi_st(leading) + K * chi_st(dependent);
}

Vector BaseParameters::to_standard(const Eigen::Ref<const Vector>& chi) const {
  if (chi.size() != size()) {
    throw InputError("to_standard: chi has " + std::to_string(chi.size()) + " entries, must have " +
                     std::to_string(size()));
  }
  Vector chi_st = Vector::Zero(static_cast<Index>(standard.size()));
  chi_st(leading) = chi;
  return chi_st;
}

std::optional<std::string> BaseParametersOptions::complaint() const {
  if (samples < 20) {
    return "samples is " + std::to_string(samples) + ", must be at least 20";
  }
  if (std::isnan(tolerance) || tolerance <= 0.0 || tolerance >= 1.0) {
    return "tolerance is " + std::to_string(tolerance) + ", must lie between 0 and 1";
  }
  return std::nullopt;
}

BaseParameters base_parameters(const Robot& robot, const BaseParametersOptions& options) {
  if (const auto complaint = robot.complaint()) {
    throw InputError("base_parameters: " + *complaint);
  }
  if (const auto complaint = options.complaint()) {
    throw InputError("base_parameters: " + *complaint);
  }
  BaseParameters base;
  base.standard = robot.standard_parameters();
  std::vector<Index> order(base.standard.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(
      order, {}, [&](Index c) { return scan_place(robot, base.standard[static_cast<std::size_t>(c)]); });

  const Scan scan = scan_columns(random_regressor(robot, base.standard, options), order, options.tolerance);
  if (scan.kept.empty()) {
    throw InputError("base_parameters: robot \"" + robot.name +
                     "\" has no parameter that shows in its torques; check its axes and units");
  }
  base.smallest_kept = scan.smallest_kept;
  base.largest_dropped = scan.largest_dropped;

  // Back from the order of the scan to that of the standard parameters.
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
  base.K = scan.K(kept, dropped);
  base.K = (base.K.array().abs() < coefficient_noise).select(0.0, base.K);
  for (Index i = 0; i < base.K.rows(); ++i) {
    const StandardParameter& leading =
        base.standard[static_cast<std::size_t>(base.leading[static_cast<std::size_t>(i)])];
    const auto terms = base.regrouping(i);
    const JointType type = robot.joints[static_cast<std::size_t>(leading.joint)].type;
    base.parameters.push_back({leading, leading.name() + (terms.size() > 1 ? "R" : ""), written(terms),
                               std::string(unit(leading.kind, type))});
  }
  return base;
}

}  // namespace rivid
