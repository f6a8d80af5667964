#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "dense.hpp"
#include "identify/infer/infer.hpp"
#include "rivid/error.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Where twins count as standing at mirrored places [m, 1].
constexpr double same_place = 1e-6;
// Probability of calling one pair of twins different that is none, over their number.
constexpr double different_by_chance = 1e-3;

[[noreturn]] void refuse_twin(const Joint& joint, const std::string& what) {
  throw InputError("identify: joint \"" + joint.name + "\": same_as is \"" + joint.same_as + "\", " + what);
}

// Orientation and origin of a link's frame in that of the link that carries it, at q = 0.
struct Placed {
  Placed(const Chain& chain, int j) {
    const Chain::Link& link = chain.links[static_cast<std::size_t>(j)];
    const int i = chain.parent(static_cast<std::size_t>(j));
    const Eigen::Matrix3d before =
        i < 0 ? Eigen::Matrix3d::Identity() : link_axes(chain.links[static_cast<std::size_t>(i)]);
    R = before * link.R * link_axes(link).transpose();
    p = before * link.p;
    axis = link_axes(link).col(2);
  }
  Eigen::Matrix3d R;
  Eigen::Vector3d p;
  Eigen::Vector3d axis;  // of the joint, in the link's frame
};

// Looks for the reflections M of link frames, r_joint = M r_twin.
class Mirrors {
 public:
  explicit Mirrors(const Robot& robot) : robot_(robot) {}

  // The twin, counted from 0; −1 for none.
  [[nodiscard]] int twin(int j) const {
    if (j < 0 || j >= std::ssize(robot_.joints) || joint(j).same_as.empty()) {
      return -1;
    }
    const auto at = std::ranges::find(robot_.joints, joint(j).same_as, &Joint::name);
    if (at == robot_.joints.end()) {
      refuse_twin(joint(j), "which is no joint of the robot");
    }
    if (!at->same_as.empty() || at->type != joint(j).type) {
      refuse_twin(joint(j), at->same_as.empty()
                                ? "whose type is another"
                                : "which has a twin itself: name that one, \"" + at->same_as + "\"");
    }
    return static_cast<int>(at - robot_.joints.begin());
  }

  [[nodiscard]] Eigen::Matrix3d mirror(int j) const {
    const int k = twin(j);
    const std::vector<int>& stated = joint(j).mirror;
    if (!stated.empty()) {
      if (stated.size() != 3 || !std::ranges::all_of(stated, [](int s) { return s == 1 || s == -1; })) {
        refuse_twin(joint(j), "but mirror must be three signs, 1 or -1");
      }
      return Eigen::Vector3d(stated[0], stated[1], stated[2]).asDiagonal();
    }
    const Placed own(robot_.chain, j);
    const Placed other(robot_.chain, k);
    const int parent = robot_.chain.parent(static_cast<std::size_t>(j));
    const int other_parent = robot_.chain.parent(static_cast<std::size_t>(k));
    const auto fits = [&](const Eigen::Matrix3d& N) {
      const Eigen::Vector3d axis = own.R.transpose() * N * other.R * other.axis;
      return (N * other.p - own.p).norm() < same_place && axis.cross(own.axis).norm() < same_place;
    };
    std::vector<Eigen::Matrix3d> candidates;
    if (twin(parent) >= 0 && twin(parent) == other_parent) {
      candidates = {mirror(parent)};
    } else if (parent == other_parent) {
      // Those with the fewest reflections first.
      for (const int signs : {0, 1, 2, 4, 3, 5, 6, 7}) {
        const auto sign = [&](int axis) { return (signs >> axis & 1) != 0 ? -1.0 : 1.0; };
        candidates.emplace_back(Eigen::Vector3d(sign(0), sign(1), sign(2)).asDiagonal());
      }
    }
    const auto found = std::ranges::find_if(candidates, fits);
    if (found == candidates.end()) {
      refuse_twin(
          joint(j),
          "but the two do not stand at places that mirror each other; state mirror = [1, -1, 1] or alike");
    }
    return own.R.transpose() * *found * other.R;
  }

  // Whether motion of the twin looks like motion of the joint in the other direction.
  [[nodiscard]] bool turned(int j, const Eigen::Matrix3d& M) const {
    const double along = Placed(robot_.chain, j).axis.dot(M * Placed(robot_.chain, twin(j)).axis);
    return (joint(j).type == JointType::revolute ? M.col(0).cross(M.col(1)).dot(M.col(2)) * along : along) <
           0.0;
  }

 private:
  [[nodiscard]] const Joint& joint(int j) const { return robot_.joints[static_cast<std::size_t>(j)]; }

  const Robot& robot_;
};

// A parameter of the twin's that is this one where the joints turn against each other.
ParameterKind opposite(ParameterKind kind) {
  using enum ParameterKind;
  constexpr std::array<std::array<ParameterKind, 2>, 4> pairs = {
      {{Fv_plus, Fv_minus}, {Fv_minus, Fv_plus}, {Fc_plus, Fc_minus}, {Fc_minus, Fc_plus}}};
  const auto at = std::ranges::find(pairs, kind, [](const auto& pair) { return pair[0]; });
  return at == pairs.end() ? kind : (*at)[1];
}

// Standard parameters of a joint and its link as those of the twin, in `T` of χ_st = T χ_st'; of friction
// where both have the same law.
void tie_standard(const Robot& robot, const std::vector<StandardParameter>& standard, const Mirrors& mirrors,
                  int j, Matrix& T) {
  const Eigen::Matrix3d M = mirrors.mirror(j);
  const bool turned = mirrors.turned(j, M);
  const int twin = mirrors.twin(j);
  const auto place = [&](ParameterKind kind) {
    return std::ranges::find_if(standard, [&](const auto& s) { return s.kind == kind && s.joint == twin; }) -
           standard.begin();
  };
  const Joint& own = robot.joints[static_cast<std::size_t>(j)];
  const Joint& other = robot.joints[static_cast<std::size_t>(twin)];
  for (std::size_t s = 0; s < standard.size(); ++s) {
    const ParameterKind kind = standard[s].kind;
    const bool shared = is_friction(kind)           ? own.friction == other.friction
                        : role(kind) == Role::rotor ? other.rotor_inertia
                                                    : true;
    if (standard[s].joint != j || !shared || about(kind).coupled || role(kind) == Role::constant) {
      continue;
    }
    const auto row = static_cast<Index>(s);
    T(row, row) = 0.0;
    if (role(kind) != Role::inertial) {
      T(row, place(turned ? opposite(kind) : kind)) = 1.0;
      continue;
    }
    for (int k = 0; k < inertial_count; ++k) {
      T(row, place(static_cast<ParameterKind>(k))) =
          transformed(Inertial::Unit(k), M, Eigen::Vector3d::Zero())[static_cast<int>(kind)];
    }
  }
}

// Directions of χ = (T's image in the base parameters) that are free, and those that are not.
SymmetricEigen directions(const BaseParameters& base, const Matrix& T, Index& tied) {
  const Matrix image = T(base.leading, Eigen::all) + base.K * T(base.dependent, Eigen::all);
  constexpr double none = 1e-10;  // of a square
  SymmetricEigen out = symmetric_eigen(image * image.transpose());
  tied = (out.values.array() < none * out.values.maxCoeff()).count();
  return out;
}

// Wald's statistic of A χ = 0, and by how many σ which parameter moves where it holds.
struct WaldTest {
  WaldTest(const Matrix& A, const Vector& chi, const Uncertainty& uncertainty) {
    const Matrix S = A * uncertainty.C * A.transpose();
    const Vector scale = S.diagonal().cwiseSqrt().cwiseInverse();
    const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * S * scale.asDiagonal());
    const Vector scaled = scale.cwiseProduct(A * chi);
    const Vector along = eigen.vectors.transpose() * scaled;
    Vector solved = Vector::Zero(along.size());
    // of the largest eigenvalue; below it a direction has no variance but for rounding
    constexpr double least = 1e-10;
    for (Index i = 0; i < along.size(); ++i) {
      if (eigen.values[i] > least * eigen.values.maxCoeff()) {
        solved[i] = along[i] / eigen.values[i];
        statistic += along[i] * solved[i];
        freedom += 1.0;
      }
    }
    // Of few blocks of time the covariance, whose scale all directions share, is an estimate itself.
    const int blocks = uncertainty.report.blocks;
    p = freedom == 0.0 ? 1.0
        : blocks > 1   ? f_tail(statistic / freedom, freedom, blocks - 1.0)
                       : chi_square_tail(statistic, freedom);
    moves = (uncertainty.C * A.transpose() * scale.cwiseProduct(eigen.vectors * solved))
                .cwiseQuotient(uncertainty.C.diagonal().cwiseSqrt())
                .cwiseAbs()
                .maxCoeff(&moved);
  }

  double statistic = 0.0;
  double freedom = 0.0;
  double p = 1.0;
  Index moved = 0;
  double moves = 0.0;
};

// Each pair by what it says with all behind it; a pair is not blamed for those behind.
void test_twins(const EstimationProblem& problem, const Twins& twins, Inference& out) {
  const double level = different_by_chance / static_cast<double>(twins.pairs.size());
  std::vector<int> differ;
  double least = 1.0;
  for (std::size_t i = twins.pairs.size(); i-- > 0;) {
    const Twins::Pair& pair = twins.pairs[i];
    if (pair.A.rows() == 0) {
      continue;
    }
    const WaldTest test(pair.A, out.chi, out.uncertainty);
    least = std::min(least, test.p);
    const auto behind = [&](int j) {
      const std::vector<std::size_t> path = problem.robot.chain.path(static_cast<std::size_t>(j));
      return std::ranges::find(path, static_cast<std::size_t>(pair.joint)) != path.end();
    };
    if (test.p >= level || std::ranges::any_of(differ, behind)) {
      continue;
    }
    differ.push_back(pair.joint);
    const Joint& joint = problem.robot.joints[static_cast<std::size_t>(pair.joint)];
    out.warnings.push_back(
        Finding{"twins_differ",
                joint.name,
                "the data do not agree that it is like \"" + joint.same_as + "\": Wald's statistic is " +
                    number(test.statistic, 3) + " of " + number(test.freedom) + ", p = " + number(test.p, 2) +
                    "; the tie moves " + problem.base.parameters[static_cast<std::size_t>(test.moved)].name +
                    " by " + number(test.moves, 2) + " σ",
                {{"robot.same_as", joint.name, {}, ""}}});
  }
  if (differ.empty()) {
    out.notes.push_back(counted(std::ssize(twins.pairs), "joint") +
                        " tied to twins, and the data agree: the smallest p of Wald's tests is " +
                        number(least, 2));
  }
}

}  // namespace

Twins twins_of(const Robot& robot, const BaseParameters& base) {
  const Mirrors mirrors(robot);
  Twins out;
  for (int j = 0; j < std::ssize(robot.joints); ++j) {
    if (const int twin = mirrors.twin(j); twin >= 0) {
      out.pairs.push_back({j, twin, {}});
    }
  }
  const auto n = std::ssize(base.standard);
  Matrix all = Matrix::Identity(n, n);
  Index tied = 0;
  for (Twins::Pair& pair : out.pairs) {
    tie_standard(robot, base.standard, mirrors, pair.joint, all);
    Matrix T = Matrix::Identity(n, n);
    for (const Twins::Pair& other : out.pairs) {
      const std::vector<std::size_t> path = robot.chain.path(static_cast<std::size_t>(other.joint));
      if (std::ranges::find(path, static_cast<std::size_t>(pair.joint)) != path.end()) {
        tie_standard(robot, base.standard, mirrors, other.joint, T);
      }
    }
    const SymmetricEigen found = directions(base, T, tied);
    pair.A = found.vectors.leftCols(tied).transpose();
  }
  const SymmetricEigen found = directions(base, all, tied);
  out.free = found.vectors.rightCols(base.size() - tied);
  return out;
}

void tie_twins(const EstimationProblem& problem, const Estimate& estimate, Inference& out) {
  const Twins twins = twins_of(problem.robot, problem.base);
  if (twins.pairs.empty()) {
    return;
  }
  if (estimate.rank < problem.base.size() || !out.uncertainty.C.allFinite()) {
    out.notes.push_back("twins were not tied: the data do not determine all parameters without it");
    return;
  }
  test_twins(problem, twins, out);
  if (problem.estimation.essential) {
    out.notes.push_back("essential parameters were not looked for: joints are tied to twins");
  }
  const ThinQr qr = thin_qr(estimate.root * twins.free);
  const Matrix& P = out.tie =
      twins.free * qr.R.triangularView<Eigen::Upper>().solve(qr.Q.transpose() * estimate.root);
  const Vector before = out.uncertainty.C.diagonal().cwiseSqrt();
  out.chi = P * out.chi;
  out.gain_slopes = P * out.gain_slopes;
  for (Matrix* const C : {&out.uncertainty.C, &out.of_choice, &out.of_geometry}) {
    *C = C->size() > 0 ? Matrix(P * *C * P.transpose()) : *C;
  }
  if (Vector& plain = out.uncertainty.plain_sigma; plain.size() > 0) {
    plain = plain.cwiseQuotient(before).cwiseProduct(out.uncertainty.C.diagonal().cwiseSqrt());
  }
  if (out.noise_bias.size() > 0) {
    out.noise_bias = P * out.noise_bias;
  }
  const double sigma_rho = out.fit.sigma_rho;
  out.fit = fit_to(problem.robot, problem.rows_to_judge(), out.chi, twins.free.cols(),
                   problem.estimation.signal.convention);
  out.fit.sigma_rho = sigma_rho;
}

Estimate tied(Estimate estimate, const Matrix& tie) {
  // any large value: ties hold to 1e-8 of a variance, at four of the 16 digits of R
  constexpr double stiff = 1e4;
  const Index b = tie.rows();
  // Of what the ties forbid the information for independent errors, so much larger.
  Matrix both(2 * b, b);
  both << estimate.root, stiff * estimate.root * (Matrix::Identity(b, b) - tie);
  estimate.root = triangular_factor(both).topRows(b);
  estimate.chi = tie * estimate.chi;
  return estimate;
}

}  // namespace rivid::detail
