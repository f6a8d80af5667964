#include "identify/physical/physical_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "dense.hpp"
#include "ranges.hpp"
#include "rivid/model/parameters.hpp"

namespace rivid::detail {

namespace {

using enum ParameterKind;

// Part of all squared columns of a root that roundings leave of a column without rows.
constexpr double roundings = 1e-20;

// Where a parameter is in base.standard.
class Places {
 public:
  explicit Places(const BaseParameters& base) {
    for (std::size_t i = 0; i < base.standard.size(); ++i) {
      places_[{base.standard[i].kind, base.standard[i].joint}] = static_cast<Index>(i);
    }
  }
  // −1 where the robot has no such parameter.
  [[nodiscard]] Index operator()(ParameterKind kind, int joint) const {
    const auto at = places_.find({kind, joint});
    return at == places_.end() ? -1 : at->second;
  }

 private:
  std::map<std::pair<ParameterKind, int>, Index> places_;
};

// What couplings take of a joint's own parameter: own ≥ Σ c² coupled.
LinearBound own_bound(const Robot& robot, const Places& place, const KindRow& own, int joint) {
  const auto coupled = std::ranges::find_if(
      kind_rows, [&](const KindRow& row) { return row.coupled && row.basis == own.basis; });
  LinearBound out{.terms = {{place(own.kind, joint), 1.0}}};
  for (const Coupling& coupling : robot.couplings) {
    if (coupling.terms != Coupling::Terms::cross) {
      continue;
    }
    const double c = coupling.row(robot.size())[joint];
    const bool tied = own.kind == Ia && coupling.inertia == Coupling::Inertia::tied;
    const Index at = place(tied ? Ia : coupled->kind, coupling.motor);
    if (at >= 0 && c != 0.0 && at != out.terms.front().first) {
      out.terms.emplace_back(at, -c * c);
    }
  }
  return out;
}

// One a body.
Vector bounds_of_masses(const Robot& robot, const Physical& options, double Physical::MassBounds::* which,
                        double otherwise) {
  const Index first = robot.first_body();
  Vector out = Vector::Constant(std::ssize(robot.chain.links) - first, otherwise);
  for (const Physical::MassBounds& bounds : options.masses) {
    for (Index k = 0; k < out.size(); ++k) {
      if (robot.link_name(static_cast<std::size_t>(first + k)) == bounds.link) {
        out[k] = bounds.*which;
      }
    }
  }
  return out;
}

Vector least_masses(const Robot& robot, const Physical& options) {
  return bounds_of_masses(robot, options, &Physical::MassBounds::least, 0.0);
}

Vector most_masses(const Robot& robot, const Physical& options) {
  return bounds_of_masses(robot, options, &Physical::MassBounds::most,
                          std::numeric_limits<double>::infinity());
}

void add_mass_bounds(const Robot& robot, const Physical& options, const Places& place,
                     std::vector<LinearBound>& out) {
  const Vector least = least_masses(robot, options);
  const Vector most = most_masses(robot, options);
  LinearBound total;
  LinearBound minus_total;
  for (Index j = 0; j < least.size(); ++j) {
    const Index at = place(M, static_cast<int>(robot.first_body() + j));
    if (least[j] > 0.0) {
      out.push_back({.terms = {{at, 1.0}}, .bound = least[j]});
    }
    if (std::isfinite(most[j])) {
      out.push_back({.terms = {{at, -1.0}}, .bound = -most[j]});
    }
    total.terms.emplace_back(at, 1.0);
    minus_total.terms.emplace_back(at, -1.0);
  }
  if (options.total_mass) {
    total.bound = (*options.total_mass)[0];
    minus_total.bound = -(*options.total_mass)[1];
    out.push_back(std::move(total));
    if (std::isfinite(minus_total.bound)) {
      out.push_back(std::move(minus_total));
    }
  }
}

// The prior of the bodies.
void add_prior(const Physical& options, const std::vector<Eigen::Matrix4d>& nominal, Index first_row,
               PhysicalProblem& out) {
  BarrierProblem& barrier = out.barrier;
  const double weight = options.weight;
  for (std::size_t j = 0; j < nominal.size(); ++j) {
    const Index at = barrier.bodies[j];
    const BodyMatrix G = whitened_parameters(nominal[j]);
    if (options.prior == Physical::Prior::log_det) {
      const Eigen::LLT<Eigen::Matrix4d> factor(nominal[j]);
      barrier.linear.segment<inertial_count>(at) = weight * G.transpose() * identity_moments();
      out.offset += weight * (2.0 * factor.matrixLLT().diagonal().array().log().sum() - 4.0);
      barrier.log_weight = weight;
    } else {
      const Index row = first_row + inertial_count * static_cast<Index>(j);
      barrier.rows.block<inertial_count, inertial_count>(row, at) = std::sqrt(weight) * G;
      barrier.target.segment<inertial_count>(row) =
          std::sqrt(weight) * G * inertial_from_pseudo_inertia(nominal[j]);
    }
  }
}

// A point inside near `wanted`.
Vector inside_near(const Robot& robot, const Physical& options, const BarrierProblem& barrier,
                   const std::vector<LinearBound>& signs, Vector wanted) {
  const std::vector<Inertial> inertials =
      made_of(barrier.bodies, [&](Index at) { return Inertial(wanted.segment<inertial_count>(at)); });
  const std::vector<Eigen::Matrix4d> bodies = nominal_bodies(robot, inertials).pseudo_inertias;
  Vector masses(std::ssize(bodies));
  for (std::size_t j = 0; j < bodies.size(); ++j) {
    masses[static_cast<Index>(j)] = bodies[j](3, 3);
  }
  const Vector allowed = masses_within(robot, options, masses);
  for (std::size_t j = 0; j < bodies.size(); ++j) {
    const auto k = static_cast<Index>(j);
    wanted.segment<inertial_count>(barrier.bodies[j]) =
        allowed[k] / masses[k] * inertial_from_pseudo_inertia(bodies[j]);
  }
  for (const LinearBound& bound : signs) {
    constexpr double at_least = 1e-6;  // in the unit of the bound; any small value: a start must lie inside
    const double slack = bound.slack(wanted);
    if (!(slack > at_least)) {
      wanted[bound.terms.front().first] += 1.0 - slack;
    }
  }
  return wanted;
}

}  // namespace

Matrix covariance_of_prior(const PhysicalProblem& problem, const BaseParameters& base, const Vector& x) {
  const BarrierProblem& barrier = problem.barrier;
  const auto pulls = barrier.rows.bottomRows(barrier.rows.rows() - problem.data_rows);
  std::array<Matrix, 2> priors = {pulls.transpose() * pulls, Matrix::Zero(x.size(), x.size())};
  for (const Index at : barrier.bodies) {
    constexpr Index n = inertial_count;
    const BodyMatrix G = whitened_parameters(pseudo_inertia(x.segment<n>(at)));
    priors[1].block<n, n>(at, at) = priors[0].block<n, n>(at, at) + barrier.log_weight * G.transpose() * G;
    priors[0].block<n, n>(at, at).setZero();
  }
  const auto data = barrier.rows.topRows(problem.data_rows);
  const Matrix H = data.transpose() * data + priors[0] + priors[1];
  const Vector scale = H.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix open =
      scale.asDiagonal() * inverse(scale.asDiagonal() * H * scale.asDiagonal()) * scale.asDiagonal();
  Matrix from_base = Matrix::Zero(x.size(), base.size());  // Aᵀ
  from_base(base.leading, Eigen::all).setIdentity();
  from_base(base.dependent, Eigen::all) = base.K.transpose();
  const Matrix by_base = open * from_base;
  const Vector away = x - problem.description;
  Matrix out = Matrix::Zero(base.size(), base.size());
  for (const Matrix& P : priors) {
    const double told =
        static_cast<double>((P.diagonal().array() > 0.0).count()) - open.cwiseProduct(P).sum();
    const double size = away.dot(P * away) / std::max(told, 1.0);
    out += size * by_base.transpose() * P * by_base;
  }
  // Of drives that no row shows nobody knows how far they are off.
  for (Index i = 0; i < base.size(); ++i) {
    const Index at = base.leading[static_cast<std::size_t>(i)];
    const bool drive = role(base.standard[static_cast<std::size_t>(at)].kind) != Role::inertial;
    if (drive && !(data.col(at).squaredNorm() > roundings * data.squaredNorm())) {
      out(i, i) = std::numeric_limits<double>::infinity();
    }
  }
  return out;
}

std::vector<LinearBound> sign_bounds(const Robot& robot, const BaseParameters& base) {
  const Places place(base);
  std::vector<LinearBound> out;
  const auto positive = [&](Index at) { out.push_back({.terms = {{at, 1.0}}}); };
  const auto single = [&](int motor) {
    return std::ranges::any_of(robot.couplings, [&](const Coupling& c) {
      return c.motor == motor && c.coulomb == Coupling::Coulomb::single;
    });
  };
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto [kind, joint] = base.standard[i];
    if (about(kind).coupled && !(role(kind) == Role::dry && single(joint))) {
      positive(static_cast<Index>(i));
    }
  }
  // Tied inertias are those of the motors' joints: first, for those of other joints are above them.
  for (const Coupling& coupling : robot.couplings) {
    if (coupling.inertia == Coupling::Inertia::tied) {
      positive(place(Ia, coupling.motor));
    }
  }
  for (int joint = 0; joint < static_cast<int>(robot.size()); ++joint) {
    for (const KindRow& row : kind_rows) {
      const bool shared = row.basis == Basis::acceleration || row.basis == Basis::speed;
      if (shared && !row.coupled && place(row.kind, joint) >= 0) {
        out.push_back(own_bound(robot, place, row, joint));
      }
    }
    for (const KindRow& row : kind_rows) {
      const Index at = place(row.kind, joint);
      if (at < 0 || row.coupled || row.basis == Basis::acceleration || row.basis == Basis::speed) {
        continue;
      }
      if (row.bound == Bound::zero) {
        positive(at);
      } else if (row.bound == Bound::mean_zero && row.direction == Direction::positive) {
        const auto other = std::ranges::find_if(kind_rows, [&](const KindRow& b) {
          return b.basis == row.basis && b.direction == Direction::negative;
        });
        out.push_back({.terms = {{at, 1.0}, {place(other->kind, joint), 1.0}}});
      }
    }
  }
  return out;
}

Vector masses_within(const Robot& robot, const Physical& options, Vector masses) {
  // of the room of a mass; any part: a start must lie inside, away from its bounds
  constexpr double margin = 0.1;
  const Vector least = least_masses(robot, options);
  const Vector most = most_masses(robot, options);
  Index unbounded = 0;
  for (Index j = 0; j < masses.size(); ++j) {
    const bool bounded = std::isfinite(most[j]);
    unbounded += bounded ? 0 : 1;
    const double room = margin * (bounded ? most[j] - least[j] : least[j]);
    masses[j] = std::max(masses[j], least[j] + room);
    masses[j] = bounded ? std::min(masses[j], most[j] - room) : masses[j];
  }
  if (!options.total_mass) {
    return masses;
  }
  const auto [total_least, total_most] = *options.total_mass;
  const double total = masses.sum();
  if (total >= total_most) {
    const double wanted = 0.5 * (std::max(total_least, least.sum()) + total_most);
    const double shrink = (wanted - least.sum()) / (total - least.sum());
    masses = least + shrink * (masses - least);
  } else if (total <= total_least && unbounded > 0) {
    const double wanted =
        std::isfinite(total_most) ? 0.5 * (total_least + total_most) : (1.0 + margin) * total_least;
    const double share = (wanted - total) / static_cast<double>(unbounded);
    masses = most.array().isFinite().select(masses, masses.array() + share);
  } else if (total <= total_least) {
    const double wanted = 0.5 * (total_least + std::min(total_most, most.sum()));
    masses = most - (most.sum() - wanted) / (most.sum() - total) * (most - masses);
  }
  return masses;
}

PhysicalProblem physical_problem(const Robot& robot, const BaseParameters& base, const Vector& chi,
                                 const Matrix& root, const Physical& options) {
  PhysicalProblem out;
  BarrierProblem& barrier = out.barrier;
  const Vector description = robot.chi_st();
  const auto size = static_cast<Index>(base.standard.size());
  std::vector<Index> others;
  for (Index i = 0; i < size; ++i) {
    const ParameterKind kind = base.standard[static_cast<std::size_t>(i)].kind;
    if (kind == XX) {
      barrier.bodies.push_back(i);
    } else if (role(kind) != Role::inertial) {
      others.push_back(i);
    }
  }
  NominalBodies nominal = nominal_bodies(
      robot, std::vector<Inertial>(robot.inertials.begin() + robot.first_body(), robot.inertials.end()));
  out.notes = std::move(nominal.notes);
  out.description = description;
  for (std::size_t j = 0; j < barrier.bodies.size(); ++j) {
    out.description.segment<inertial_count>(barrier.bodies[j]) =
        inertial_from_pseudo_inertia(nominal.pseudo_inertias[j]);
  }

  const Index ridge_rows =
      options.prior == Physical::Prior::ridge ? inertial_count * std::ssize(barrier.bodies) : 0;
  const Index rows = root.rows() + ridge_rows + static_cast<Index>(others.size());
  out.data_rows = root.rows();
  barrier.rows = Matrix::Zero(rows, size);
  barrier.target = Vector::Zero(rows);
  barrier.linear = Vector::Zero(size);
  barrier.rows(Eigen::seqN(0, root.rows()), base.leading) = root;
  barrier.rows(Eigen::seqN(0, root.rows()), base.dependent) = root * base.K;
  barrier.target.head(root.rows()) = root * chi;
  // Friction and rotors are pulled to the description as if one were known that makes as much torque as all
  // parameters do together: it decides what the data leave open, in rows that hardly tell it too.
  const double torques = std::max(barrier.target.head(root.rows()).squaredNorm(), 1.0);
  const double unseen = roundings * root.squaredNorm();
  for (std::size_t k = 0; k < others.size(); ++k) {
    const Index row = root.rows() + ridge_rows + static_cast<Index>(k);
    const double seen = barrier.rows.col(others[k]).head(root.rows()).squaredNorm();
    const double pull = std::sqrt(seen > unseen ? seen / torques : 1.0);
    barrier.rows(row, others[k]) = pull;
    barrier.target[row] = pull * description[others[k]];
  }
  add_prior(options, nominal.pseudo_inertias, root.rows(), out);

  const std::vector<LinearBound> signs = sign_bounds(robot, base);
  barrier.bounds = signs;
  add_mass_bounds(robot, options, Places(base), barrier.bounds);
  out.start =
      inside_near(robot, options, barrier, signs, options.start.size() > 0 ? options.start : description);
  return out;
}

}  // namespace rivid::detail
