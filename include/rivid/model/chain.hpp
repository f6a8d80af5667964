#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/linkage.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// Geometry of a serial chain, or of a tree on a fixed base, as the kernels read it.
///
/// Frame j is fixed to link j, its origin lies on the axis of joint j and its z axis along it: a revolute
/// joint turns frame j about z, a prismatic one moves it along z. Where the robot branches, "frame j−1" is
/// that of the link that carries link j. A URDF whose joint axis is x, y or a
/// negative axis is brought to this form by renaming axes, see Link::axes.
struct Chain {
  struct Link {
    JointType type = JointType::revolute;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< orientation of frame j in frame j−1 at q_j = 0
    Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< origin of frame j in frame j−1 at q_j = 0 [m]
    /// The user's link frame has the origin of frame j and its axes, renamed: component k of a vector in the
    /// link frame is signs[k] times component axes[k] in frame j. Standard parameters are given in the link
    /// frame.
    std::array<int, 3> axes = {0, 1, 2};
    std::array<int, 3> signs = {1, 1, 1};
  };

  /// A joint that follows others, as a mimic joint or a passive one of a parallelogram that has been cut:
  ///
  ///   q = offset + Σ_k factor_k q_k
  ///
  /// or by a curve over the joints of the terms, as of a four-bar linkage, or a table.
  struct Dependent {
    struct Term {
      int joint = 0;        ///< k, counted from 0, one of the n joints
      double factor = 1.0;  ///< [unit of this joint per unit of joint k]
    };
    std::string joint;  ///< its name
    std::string link;   ///< that it moves
    std::vector<Term> terms = {};
    double offset = 0.0;  ///< [rad | m]
    std::optional<Curve> curve = {};

    /// The joints that a curve goes over, and their positions between its ends; none of a sum.
    struct Reach {
      int joint = 0;
      double least = 0.0;
      double most = 0.0;
    };
    [[nodiscard]] std::vector<Reach> reach() const;
    /// All numbers that say how it follows.
    [[nodiscard]] std::vector<double> numbers() const;
  };

  std::vector<Link> links;  ///< links 1…n, base to tip; of a tree, depth first; then those of `dependents`
  Eigen::Vector3d gravity = {0.0, 0.0, -9.80665};  ///< acceleration of free fall in the base frame [m/s²]
  /// Of a tree: the link that carries each link, counted from 0, −1 for the base; empty: each is carried by
  /// the one before. Depth first: a link is carried by the one before it, by one of those that carry that
  /// one, or by the base. With `dependents` in any order.
  std::vector<int> parents;
  std::vector<Dependent> dependents;  ///< joints that follow others, of the last links

  /// Positions that all curves reach, of joint j; infinite ends where there are none.
  [[nodiscard]] std::array<double, 2> reach(int j) const;
  /// Turns positions between −π and π, of a prismatic joint between −1 and 1, into such that all curves
  /// reach.
  ///
  /// @param q  called as q(j): a reference to the position of joint j
  template <typename Positions>
  void into_reach(Positions&& q) const {
    for (int j = 0; !dependents.empty() && j < static_cast<int>(joints()); ++j) {
      if (const auto [least, most] = reach(j); std::isfinite(most - least)) {
        const bool turns = links[static_cast<std::size_t>(j)].type == JointType::revolute;
        auto&& x = q(j);
        x = 0.5 * (least + most) + x * (0.5 * (most - least) / (turns ? std::numbers::pi : 1.0));
      }
    }
  }
  /// n, without dependent ones.
  [[nodiscard]] Index joints() const { return std::ssize(links) - std::ssize(dependents); }
  /// The link that carries link j, −1 for the base.
  [[nodiscard]] int parent(std::size_t j) const {
    return parents.empty() ? static_cast<int>(j) - 1 : parents[j];
  }
  /// Whether some link is not carried by the one before.
  [[nodiscard]] bool branches() const;
  /// The links from the base to link j, which is the last, (depth + 1).
  [[nodiscard]] std::vector<std::size_t> path(std::size_t j) const;
  /// Of each link on which several hang its number among these, −1 of all others, (n).
  [[nodiscard]] std::vector<int> forks() const;
  /// The links on which none hangs, ascending; of a chain the last one.
  [[nodiscard]] std::vector<std::size_t> tips() const;
};

/// For what knows chains alone.
///
/// @param who  begins the message
/// @throws InputError  where the robot branches or a joint depends on others
void require_chain(const std::string& who, const Chain& chain);

/// For what can not follow dependent joints.
///
/// @param who  begins the message
/// @throws InputError  where a joint depends on others
void require_independent(const std::string& who, const Chain& chain);

/// Where one inertial parameter of the link frame stands among the columns of frame j.
struct InertialColumn {
  int index = 0;  ///< 0…9: XX XY XZ YY YZ ZZ MX MY MZ M of frame j
  int sign = 1;
};

/// Column of frame j that belongs to the link-frame parameter `kind` (one of the ten inertial ones).
[[nodiscard]] InertialColumn inertial_column(const Chain::Link& link, ParameterKind kind);

/// Orientation of frame j in the user's link frame, a signed permutation: v_link = link_axes(link) v_j.
[[nodiscard]] Eigen::Matrix3d link_axes(const Chain::Link& link);

namespace detail {

// Motion of joints, values of some samples; those of a joint lie a stride apart from the next one's. Null:
// zero.
template <typename Value>
struct JointMotion {
  const Value* q;
  const Value* qd;
  const Value* qdd;
  std::ptrdiff_t q_stride = 1;
  std::ptrdiff_t qd_stride = 1;
  std::ptrdiff_t qdd_stride = 1;
};

// q_all = g(q) of all links' joints, of which each is a sum or follows a curve, and by the balance of power
// τ = Gᵀ τ_all with the slopes G = ∂g/∂q.
struct Dependence {
  struct Term {
    int link = 0;  // its place in LinkTree::chain
    int joint = 0;
    double factor = 1.0;
    int curve = -1;  // place among these; its terms follow each other
  };
  std::vector<Term> terms;      // of G, ascending by link; empty: each joint is independent
  std::vector<double> offsets;  // g(0) of sums, (links); empty like the terms
  std::vector<Curve> curves;    // where G depends on q

  [[nodiscard]] bool empty() const noexcept { return terms.empty(); }
  [[nodiscard]] bool bends() const noexcept { return !curves.empty(); }

  // Values that expand() writes: q, q̇, q̈ of all links' joints, (count × links) each, and G, (count × terms).
  [[nodiscard]] std::size_t memory(std::size_t count) const noexcept {
    return (3 * offsets.size() + (bends() ? terms.size() : 0)) * count;
  }
  template <typename Value>
  void expand(const JointMotion<Value>& in, std::ptrdiff_t count, Value* all) const noexcept {
    const std::ptrdiff_t size = std::ssize(offsets) * count;
    const std::array<const Value*, 3> from = {in.q, in.qd, in.qdd};
    const std::array<std::ptrdiff_t, 3> strides = {in.q_stride, in.qd_stride, in.qdd_stride};
    for (std::ptrdiff_t j = 0; j < std::ssize(offsets); ++j) {
      std::fill_n(all + j * count, count, Value(offsets[static_cast<std::size_t>(j)]));
    }
    std::fill_n(all + size, 2 * size, Value(0.0));
    Value* slopes = all + 3 * size;
    for (std::size_t t = 0; t < terms.size();) {
      const Term& term = terms[t];
      if (term.curve >= 0) {
        t += follow(term, in, count, all, slopes + static_cast<std::ptrdiff_t>(t) * count);
        continue;
      }
      for (std::size_t part = 0; part < 3 && from[part] != nullptr; ++part) {
        for (std::ptrdiff_t k = 0; k < count; ++k) {
          Value& sum = all[static_cast<std::ptrdiff_t>(part) * size + term.link * count + k];
          sum = sum + Value(term.factor) * from[part][term.joint * strides[part] + k];
        }
      }
      if (bends()) {
        std::fill_n(slopes + static_cast<std::ptrdiff_t>(t) * count, count, Value(term.factor));
      }
      ++t;
    }
  }
  // Of a sample, G of a term after expand(… , count, all).
  template <typename Value>
  [[nodiscard]] Value slope(std::size_t term, std::ptrdiff_t count, std::ptrdiff_t sample,
                            const Value* all) const noexcept {
    return bends() ? all[(3 * std::ssize(offsets) + static_cast<std::ptrdiff_t>(term)) * count + sample]
                   : Value(terms[term].factor);
  }
  // tau = Gᵀ of_links, (joints), of one sample; `all` as expand() wrote it.
  template <typename Value>
  void fold(const Value* of_links, std::size_t joints, const Value* all, Value* tau) const noexcept {
    for (std::size_t j = 0; j < joints; ++j) {
      tau[j] = Value(0.0);
    }
    for (std::size_t t = 0; t < terms.size(); ++t) {
      tau[terms[t].joint] = tau[terms[t].joint] + slope(t, 1, 0, all) * of_links[terms[t].link];
    }
  }

 private:
  // Returns how many terms the curve has, of which `first` is one.
  template <typename Value>
  std::size_t follow(const Term& first, const JointMotion<Value>& in, std::ptrdiff_t count, Value* all,
                     Value* slopes) const noexcept {
    const std::ptrdiff_t size = std::ssize(offsets) * count;
    const Curve& curve = curves[static_cast<std::size_t>(first.curve)];
    const auto* const bar = std::get_if<FourBarAngle>(&curve);
    const auto* const spline = std::get_if<JointSpline>(&curve);
    const std::size_t d = spline != nullptr ? spline->pieces.size() : 1;
    std::array<Value, JointSpline::most_joints> q{};
    std::array<Value, JointSpline::most_values> x{};  // value, slopes, curvatures
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      const auto moved = [&](const Value* part, std::ptrdiff_t stride, std::size_t a) {
        return part[(&first + a)->joint * stride + k];
      };
      for (std::size_t a = 0; a < d; ++a) {
        q[a] = moved(in.q, in.q_stride, a);
      }
      if (bar != nullptr) {
        std::ranges::copy(bar->at(q[0]), x.begin());
      } else {
        spline->at(q.data(), x.data());
      }
      Value* const link = all + first.link * count + k;
      link[0] = link[0] + x[0];
      for (std::size_t a = 0; a < d; ++a) {
        const Value& slope = slopes[static_cast<std::ptrdiff_t>(a) * count + k] = x[1 + a];
        if (in.qd != nullptr) {
          const Value speed = moved(in.qd, in.qd_stride, a);
          link[size] = link[size] + slope * speed;
          for (std::size_t b = 0; b < d; ++b) {
            link[2 * size] = link[2 * size] + x[1 + d + a * d + b] * speed * moved(in.qd, in.qd_stride, b);
          }
        }
        if (in.qdd != nullptr) {
          link[2 * size] = link[2 * size] + slope * moved(in.qdd, in.qdd_stride, a);
        }
      }
    }
    return d;
  }
};

// The links as kernels walk them: depth first, each with a joint of its own.
struct LinkTree {
  Chain chain;
  std::vector<std::size_t> order;  // place of each link among those of the robot
  Dependence dependence;
};
[[nodiscard]] LinkTree link_tree(const Chain& chain);

template <typename Square>
struct JacobiEigen {
  using Scalar = typename Square::Scalar;
  Eigen::Vector<Scalar, Square::RowsAtCompileTime> values;
  Square vectors;  // one column a value
};

// Eigenvalues of a symmetric matrix by Jacobi's rotations: those of a diagonal matrix are its entries
// themselves. (Eigen's solver costs as much to compile as all the rest.) Nothing is allocated for a matrix of
// fixed size.
template <typename Square>
[[nodiscard]] JacobiEigen<Square> jacobi_eigen(Square A) {
  using Scalar = typename Square::Scalar;
  using std::abs;
  using std::sqrt;
  const Index n = A.rows();
  Square V = Square::Identity(n, n);
  const Scalar one(1);
  const Scalar negligible = Eigen::NumTraits<Scalar>::epsilon() * A.norm();
  constexpr int most_sweeps = 60;  // far above what any matrix takes: it ends a loop on numbers that are none
  bool diagonal = false;
  for (int sweep = 0; sweep < most_sweeps && !diagonal; ++sweep) {
    diagonal = true;
    for (Index p = 0; p < n; ++p) {
      for (Index q = p + 1; q < n; ++q) {
        const Scalar off = A(p, q);
        if (off == Scalar(0)) {
          continue;
        }
        diagonal = diagonal && abs(off) <= negligible;
        const Scalar theta = (A(q, q) - A(p, p)) / (Scalar(2) * off);
        const Scalar t = (theta < Scalar(0) ? -one : one) / (abs(theta) + sqrt(theta * theta + one));
        const Scalar c = one / sqrt(t * t + one);
        const Scalar s = t * c;
        for (Index k = 0; k < n; ++k) {
          const Scalar first = A(k, p);
          A(k, p) = c * first - s * A(k, q);
          A(k, q) = s * first + c * A(k, q);
        }
        for (Index k = 0; k < n; ++k) {
          const Scalar first = A(p, k);
          A(p, k) = c * first - s * A(q, k);
          A(q, k) = s * first + c * A(q, k);
          const Scalar of_vector = V(k, p);
          V(k, p) = c * of_vector - s * V(k, q);
          V(k, q) = s * of_vector + c * V(k, q);
        }
        A(p, q) = Scalar(0);
        A(q, p) = Scalar(0);
      }
    }
  }
  return {A.diagonal(), V};
}

// Whether RᵀR is the identity and R no reflection; what is written with few digits is still a rotation.
[[nodiscard]] inline bool is_rotation(const Eigen::Matrix3d& R) {
  constexpr double rounding = 1e-6;  // six digits, as in files written by hand
  for (Index i = 0; i < 3; ++i) {
    for (Index k = 0; k <= i; ++k) {
      if (!(std::abs(R.col(i).dot(R.col(k)) - (i == k ? 1.0 : 0.0)) <= rounding)) {  // a NaN, too
        return false;
      }
    }
  }
  return R.col(0).dot(Eigen::Vector3d(R(1, 1) * R(2, 2) - R(2, 1) * R(1, 2),
                                      R(2, 1) * R(0, 2) - R(0, 1) * R(2, 2),
                                      R(0, 1) * R(1, 2) - R(1, 1) * R(0, 2))) > 0.0;
}

}  // namespace detail

#ifdef RIVID_DEFINITIONS

namespace detail {

// Row and column of each inertia entry XX XY XZ YY YZ ZZ, and the way back.
inline constexpr std::array<std::array<int, 2>, 6> tensor_entry = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

inline int tensor_index(int row, int column) {
  const std::array<int, 2> wanted = {std::min(row, column), std::max(row, column)};
  return static_cast<int>(std::find(tensor_entry.begin(), tensor_entry.end(), wanted) - tensor_entry.begin());
}

// No robot comes near; the squares of what lies far beyond overflow.
inline constexpr double largest_length = 1e6;
inline constexpr double largest_gravity = 1e6;
inline std::optional<std::string> gravity_complaint(const Eigen::Vector3d& gravity) {
  if (!gravity.allFinite()) {
    return "gravity must be finite";
  }
  if (gravity.cwiseAbs().maxCoeff() > largest_gravity) {
    return "gravity is " + number(gravity.cwiseAbs().maxCoeff()) + " m/s², must be at most " +
           number(largest_gravity);
  }
  return std::nullopt;
}

inline std::optional<std::string> frame_complaint(const Chain::Link& link) {
  if (link.type != JointType::revolute && link.type != JointType::prismatic) {
    return "its type is none of JointType";
  }
  if (!link.R.allFinite() || !link.p.allFinite()) {
    return "its frame is not finite";
  }
  if (!is_rotation(link.R)) {
    return "R of its frame must be a rotation: columns of length 1, at right angles, right-handed";
  }
  if (link.p.cwiseAbs().maxCoeff() > largest_length) {
    return "its frame lies " + number(link.p.cwiseAbs().maxCoeff()) +
           " m from the one before, must be at most " + number(largest_length) + " m";
  }
  std::array<int, 3> sorted = link.axes;
  std::ranges::sort(sorted);
  const auto listed = [](const std::array<int, 3>& values) {
    return std::to_string(values[0]) + ", " + std::to_string(values[1]) + ", " + std::to_string(values[2]);
  };
  if (sorted != std::array{0, 1, 2}) {
    return "axes of its link are " + listed(link.axes) + ", must be 0, 1, 2 in some order";
  }
  if (!std::ranges::all_of(link.signs, [](int sign) { return sign == 1 || sign == -1; })) {
    return "signs of its link are " + listed(link.signs) + ", must be 1 or -1 each";
  }
  return std::nullopt;
}

// Places of the links of a chain depth first; without those that nothing carries.
inline std::vector<std::size_t> depth_first(const Chain& chain) {
  std::vector<std::size_t> out;
  std::vector<int> open = {-1};
  while (!open.empty()) {
    const int at = open.back();
    open.pop_back();
    if (at >= 0) {
      out.push_back(static_cast<std::size_t>(at));
    }
    for (std::size_t j = chain.links.size(); j-- > 0;) {
      if (chain.parent(j) == at) {
        open.push_back(static_cast<int>(j));
      }
    }
  }
  return out;
}

inline bool curve_fits(const Curve& curve, std::size_t joints) {
  const auto* const spline = std::get_if<JointSpline>(&curve);
  if (spline == nullptr) {
    return joints == 1;
  }
  std::size_t count = 1;
  for (const int pieces : spline->pieces) {
    count *= static_cast<std::size_t>(std::max(pieces, 0)) + 3;
  }
  bool fit = joints <= JointSpline::most_joints && spline->coefficients.size() == count &&
             std::ranges::all_of(spline->coefficients, [](double x) { return std::isfinite(x); });
  for (const std::size_t size : {spline->pieces.size(), spline->least.size(), spline->most.size()}) {
    fit = fit && size == joints;
  }
  for (std::size_t a = 0; fit && a < joints; ++a) {
    fit = spline->pieces[a] > 0 && std::isfinite(spline->most[a] - spline->least[a]) &&
          spline->most[a] > spline->least[a];
  }
  return fit;
}

// Of dependent joints and their place in the tree.
inline std::optional<std::string> dependence_complaint(const Chain& chain) {
  const Index n = chain.joints();
  if (n < 1) {
    return "every joint depends on others, at least one must move by itself";
  }
  for (const Chain::Dependent& dependent : chain.dependents) {
    const std::string who = "dependent joint \"" + dependent.joint + "\": ";
    if (dependent.terms.empty() || !std::isfinite(dependent.offset)) {
      return who + (dependent.terms.empty() ? "it follows no joint" : "its offset is not finite");
    }
    if (dependent.curve && !curve_fits(*dependent.curve, dependent.terms.size())) {
      return who + "its curve is not over the " + counted(std::ssize(dependent.terms), "joint") +
             " that it follows";
    }
    for (const Chain::Dependent::Term& term : dependent.terms) {
      if (term.joint < 0 || term.joint >= n) {
        return who + "it follows joint " + std::to_string(term.joint + 1) + " of " + std::to_string(n);
      }
      if (!std::isfinite(term.factor) || term.factor == 0.0 || (dependent.curve && term.factor != 1.0)) {
        return who + "a factor is " + number(term.factor) + ", must be finite and not zero" +
               (dependent.curve ? ", 1 of a curve" : "");
      }
    }
  }
  for (const int parent : chain.parents) {
    if (parent < -1 || parent >= std::ssize(chain.links)) {
      return "a link is carried by link " + std::to_string(parent + 1) + " of " +
             std::to_string(chain.links.size());
    }
  }
  return depth_first(chain).size() == chain.links.size()
             ? std::nullopt
             : std::optional<std::string>("parents lead round in a cycle");
}

// Of the order of a tree.
inline std::optional<std::string> order_complaint(const Chain& chain) {
  const std::vector<int>& parents = chain.parents;
  if (!parents.empty() && parents.size() != chain.links.size()) {
    return "parents of the chain has " + std::to_string(parents.size()) + " entries, must have " +
           std::to_string(chain.links.size()) + ", one a link";
  }
  if (!chain.dependents.empty()) {
    return dependence_complaint(chain);
  }
  for (std::size_t j = 0; j < parents.size(); ++j) {
    int before = static_cast<int>(j) - 1;
    while (before >= 0 && before != parents[j]) {
      before = parents[static_cast<std::size_t>(before)];
    }
    if (before != parents[j]) {
      return "parents[" + std::to_string(j) + "] is " + std::to_string(parents[j]) +
             ", must be -1, the link before or one that carries it: depth first";
    }
  }
  return std::nullopt;
}

RIVID_INLINE LinkTree link_tree(const Chain& chain) {
  LinkTree out;
  if (chain.dependents.empty()) {
    out.chain = chain;
    out.order.resize(chain.links.size());
    std::iota(out.order.begin(), out.order.end(), std::size_t{0});
    return out;
  }
  out.order = depth_first(chain);
  out.chain.gravity = chain.gravity;
  std::vector<int> places(chain.links.size());
  const auto n = static_cast<std::size_t>(chain.joints());
  for (const std::size_t j : out.order) {
    const int place = static_cast<int>(out.chain.links.size());
    places[j] = place;
    out.chain.links.push_back(chain.links[j]);
    out.chain.parents.push_back(chain.parent(j) < 0 ? -1 : places[static_cast<std::size_t>(chain.parent(j))]);
    if (j < n) {
      out.dependence.terms.push_back({place, static_cast<int>(j), 1.0});
      out.dependence.offsets.push_back(0.0);
      continue;
    }
    const Chain::Dependent& dependent = chain.dependents[j - n];
    for (const auto& [joint, factor] : dependent.terms) {
      out.dependence.terms.push_back(
          {place, joint, factor, dependent.curve ? static_cast<int>(out.dependence.curves.size()) : -1});
    }
    if (dependent.curve) {
      out.dependence.curves.push_back(*dependent.curve);
    }
    out.dependence.offsets.push_back(dependent.offset);
  }
  return out;
}

}  // namespace detail

RIVID_INLINE std::vector<Chain::Dependent::Reach> Chain::Dependent::reach() const {
  std::vector<Reach> out;
  if (const auto* const bar = curve ? std::get_if<FourBarAngle>(&*curve) : nullptr) {
    constexpr double all_round = 6.28;  // [rad] just below 2π: the crank turns all round
    const bool ends = bar->most - bar->least < all_round;
    constexpr double none = std::numeric_limits<double>::infinity();
    out.push_back({terms.front().joint, ends ? bar->least : -none, ends ? bar->most : none});
  } else if (curve) {
    const auto& spline = std::get<JointSpline>(*curve);
    for (std::size_t a = 0; a < std::min(terms.size(), spline.pieces.size()); ++a) {
      out.push_back({terms[a].joint, spline.least[a], spline.most[a]});
    }
  }
  return out;
}

RIVID_INLINE std::vector<double> Chain::Dependent::numbers() const {
  std::vector<double> out = {offset};
  for (const auto& [k, factor] : terms) {
    out.insert(out.end(), {static_cast<double>(k), factor});
  }
  if (const auto* const bar = curve ? std::get_if<FourBarAngle>(&*curve) : nullptr) {
    out.insert(out.end(), {bar->ground, bar->crank, bar->coupler, bar->rocker, bar->crank_angle, bar->zero,
                           bar->mirrored ? 1.0 : 0.0});
  } else if (curve) {
    const auto& spline = std::get<JointSpline>(*curve);
    for (const std::vector<double>* const x : {&spline.least, &spline.most, &spline.coefficients}) {
      out.insert(out.end(), x->begin(), x->end());
    }
  }
  return out;
}

RIVID_INLINE std::array<double, 2> Chain::reach(int j) const {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::array<double, 2> out = {-none, none};
  for (const Dependent& dependent : dependents) {
    for (const auto& [joint, least, most] : dependent.reach()) {
      if (joint == j) {
        out = {std::max(out[0], least), std::min(out[1], most)};
      }
    }
  }
  return out;
}

RIVID_INLINE bool Chain::branches() const {
  for (std::size_t j = 0; j < parents.size(); ++j) {
    if (parents[j] + 1 != static_cast<int>(j)) {
      return true;
    }
  }
  return false;
}

RIVID_INLINE std::vector<std::size_t> Chain::path(std::size_t j) const {
  std::vector<std::size_t> out = {j};
  while (parent(out.back()) >= 0) {
    out.push_back(static_cast<std::size_t>(parent(out.back())));
  }
  std::ranges::reverse(out);
  return out;
}

RIVID_INLINE std::vector<int> Chain::forks() const {
  std::vector<int> out(links.size(), -1);
  int count = 0;
  for (std::size_t j = 0; j < parents.size(); ++j) {
    if (parents[j] >= 0 && parents[j] + 1 != static_cast<int>(j)) {
      int& fork = out[static_cast<std::size_t>(parents[j])];
      fork = fork < 0 ? count++ : fork;
    }
  }
  return out;
}

RIVID_INLINE std::vector<std::size_t> Chain::tips() const {
  std::vector<bool> carries(links.size(), false);
  for (std::size_t j = 0; j < links.size(); ++j) {
    if (parent(j) >= 0) {
      carries[static_cast<std::size_t>(parent(j))] = true;
    }
  }
  std::vector<std::size_t> out;
  for (std::size_t j = 0; j < links.size(); ++j) {
    if (!carries[j]) {
      out.push_back(j);
    }
  }
  return out;
}

RIVID_INLINE void require_independent(const std::string& who, const Chain& chain) {
  if (!chain.dependents.empty()) {
    throw InputError(who + ": joint \"" + chain.dependents.front().joint +
                     "\" depends on others, every joint must move by itself");
  }
}

RIVID_INLINE void require_chain(const std::string& who, const Chain& chain) {
  require_independent(who, chain);
  if (chain.branches()) {
    throw InputError(who + ": the robot branches, must be a chain; name its last link as tip");
  }
}

RIVID_INLINE InertialColumn inertial_column(const Chain::Link& link, ParameterKind kind) {
  const int k = static_cast<int>(kind);
  const auto axis = [&](int i) { return link.axes[static_cast<std::size_t>(i)]; };
  const auto sign = [&](int i) { return link.signs[static_cast<std::size_t>(i)]; };
  if (k < 6) {
    const auto [row, column] = detail::tensor_entry[static_cast<std::size_t>(k)];
    return {detail::tensor_index(axis(row), axis(column)), sign(row) * sign(column)};
  }
  if (k < 9) {
    return {6 + axis(k - 6), sign(k - 6)};
  }
  return {9, 1};
}

RIVID_INLINE Eigen::Matrix3d link_axes(const Chain::Link& link) {
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    C(static_cast<Index>(k), link.axes[k]) = link.signs[k];
  }
  return C;
}

#endif

}  // namespace rivid
