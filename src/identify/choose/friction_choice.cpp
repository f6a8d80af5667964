#include "rivid/identify/friction_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "dense.hpp"
#include "identify/choose/row_choice.hpp"
#include "identify/rows/time_blocks.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// From simple to rich; the first is that of comparison.
constexpr std::array candidates = {Friction::symmetric, Friction::root, Friction::load, Friction::load_root};
constexpr Index wanted_stretches = 8;
// A richer law has to be better by this part of the error, and by so many standard errors.
constexpr double least_gain = 0.03;
constexpr double least_deviations = 2.0;
// Gauss-Newton of the load, and of the weights of the joints.
constexpr int passes = 4;
// Pivots of scaled columns below this part of the largest belong to parameters that the rows do not show.
constexpr double not_seen = 3e-6;

// The rows of one joint in one stretch of time.
struct Stretch {
  std::size_t joint = 0;
  std::size_t fold = 0;
  std::vector<Index> columns;  // of the linear robot's base parameters
  Matrix W;
  Vector y;
  Vector sign;   // of the velocity; empty where the joint's law is not to be chosen
  Matrix rigid;  // columns of M q̈ + N, zeros elsewhere
};

// A law for each joint, and the unknowns [χ, Fl] of a fit with it: those that a law does not have are zero.
class Fits {
 public:
  Fits(const Robot& robot, const BaseParameters& base, std::vector<Stretch> stretches, std::size_t folds)
      : b_(base.size()),
        stretches_(std::move(stretches)),
        folds_(folds),
        weights_(Vector::Ones(robot.size())) {
    const std::vector<StandardParameter> columns = base.columns();
    root_at_.assign(robot.joints.size(), -1);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (about(columns[c].kind).basis == Basis::root) {
        root_at_[static_cast<std::size_t>(columns[c].joint)] = static_cast<Index>(c);
      }
    }
  }

  // Squared error of each joint in each stretch of time that was left out of the fit, (n × folds).
  [[nodiscard]] Matrix unseen_errors(const std::vector<Friction>& laws) {
    Matrix out = Matrix::Zero(weights_.size(), static_cast<Index>(folds_));
    for (std::size_t fold = 0; fold < folds_; ++fold) {
      const Vector theta = solution(laws, fold);
      for (const Stretch& s : stretches_) {
        if (s.fold == fold) {
          out(static_cast<Index>(s.joint), static_cast<Index>(fold)) += residual(s, theta).squaredNorm();
        }
      }
    }
    return out;
  }

  // The same of the torques themselves.
  [[nodiscard]] Matrix torques() const {
    Matrix out = Matrix::Zero(weights_.size(), static_cast<Index>(folds_));
    for (const Stretch& s : stretches_) {
      out(static_cast<Index>(s.joint), static_cast<Index>(s.fold)) += s.y.squaredNorm();
    }
    return out;
  }

 private:
  [[nodiscard]] Vector residual(const Stretch& s, const Vector& theta) const {
    const Vector own = theta(s.columns);
    Vector out = s.y - s.W * own;
    if (s.sign.size() > 0) {
      out -= theta[b_ + static_cast<Index>(s.joint)] * s.sign.cwiseProduct((s.rigid * own).cwiseAbs());
    }
    return out;
  }

  [[nodiscard]] Vector solution(const std::vector<Friction>& laws, std::size_t without) {
    const Index p = b_ + weights_.size();
    Vector theta = Vector::Zero(p);
    Vector wanted = Vector::Ones(p);
    bool linear = true;
    for (std::size_t j = 0; j < laws.size(); ++j) {
      const bool load = has(laws[j], Basis::load);
      linear = linear && !load;
      wanted[b_ + static_cast<Index>(j)] = load ? 1.0 : 0.0;
      if (root_at_[j] >= 0 && !has(laws[j], Basis::root)) {
        wanted[root_at_[j]] = 0.0;
      }
    }
    weights_.setOnes();
    for (int pass = 0; pass < passes; ++pass) {
      StreamingQr qr(p);
      Vector squares = Vector::Zero(weights_.size());
      Vector counts = Vector::Zero(weights_.size());
      for (const Stretch& s : stretches_) {
        if (s.fold != without) {
          const Vector rho = residual(s, theta);
          const double weight = weights_[static_cast<Index>(s.joint)];
          qr.add(weight * slopes(s, theta, wanted), weight * rho);
          squares[static_cast<Index>(s.joint)] += rho.squaredNorm();
          counts[static_cast<Index>(s.joint)] += static_cast<double>(rho.size());
        }
      }
      const Matrix R = qr.R();
      const Vector scale = R.colwise().norm().unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
      theta += scale.cwiseProduct(detail::minimum_norm_solution(R * scale.asDiagonal(), qr.qty(), not_seen));
      if (pass > 0) {
        weights_ = squares.cwiseQuotient(counts.cwiseMax(1.0)).unaryExpr([](double x) {
          return x > 0.0 ? 1.0 / std::sqrt(x) : 1.0;
        });
      }
      if (linear && pass == 2) {
        break;
      }
    }
    return theta;
  }

  // Slopes of the torque by all unknowns, zero for those that are not wanted.
  [[nodiscard]] Matrix slopes(const Stretch& s, const Vector& theta, const Vector& wanted) const {
    Matrix out = Matrix::Zero(s.y.size(), theta.size());
    out(Eigen::all, s.columns) = s.W;
    if (s.sign.size() > 0) {
      const Index Fl = b_ + static_cast<Index>(s.joint);
      const Vector load = s.rigid * theta(s.columns);
      const Vector turned =
          s.sign.cwiseProduct(load.unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; }));
      out(Eigen::all, s.columns) += (theta[Fl] * turned).asDiagonal() * s.rigid;
      out.col(Fl) = turned.cwiseProduct(load);
    }
    return out * wanted.asDiagonal();
  }

  Index b_;
  std::vector<Stretch> stretches_;
  std::size_t folds_;
  Vector weights_;
  std::vector<Index> root_at_;
};

// Motors of several joints with dry friction of their own do not go with every law.
bool allowed(Robot robot, std::size_t joint, Friction law) {
  robot.joints[joint].friction = law;
  return !robot.complaint();
}

bool open_law(const Joint& joint) { return joint.friction == Friction::automatic; }

// Rows of all logs, joint by joint and stretch by stretch; all open joints have √|q̇|.
std::vector<Stretch> stretches_of(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                                  const SignalOptions& signal, const std::vector<std::uint8_t>& open,
                                  std::size_t& folds) {
  const std::vector<StandardParameter> parameters = base.columns();
  const detail::TimeBlocks blocks(detail::durations(logs), wanted_stretches);
  folds = static_cast<std::size_t>(blocks.count());
  std::vector<Stretch> out;
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const Rows made = rows(robot, base, logs[l], signal);
    for (std::size_t j = 0; j < made.Y.size(); ++j) {
      const JointRows& joint = made.W.joints[j];
      blocks.divide(l, made.samples[j], [&](Index fold, Index first, Index count) {
        Stretch& piece = out.emplace_back();
        piece.joint = j;
        piece.fold = static_cast<std::size_t>(fold);
        piece.columns = joint.columns;
        piece.W = joint.W.middleRows(first, count);
        piece.y = made.Y[j].segment(first, count);
        if (open[j] != 0) {
          piece.rigid = piece.W;
          for (std::size_t c = 0; c < joint.columns.size(); ++c) {
            const StandardParameter& p = parameters[static_cast<std::size_t>(joint.columns[c])];
            if (p.kind == ParameterKind::Fc && p.joint == static_cast<int>(j)) {
              piece.sign = piece.W.col(static_cast<Index>(c));
            }
            if (is_friction(p.kind)) {
              piece.rigid.col(static_cast<Index>(c)).setZero();
            }
          }
        }
      });
    }
  }
  return out;
}

// Whether errors b, one a stretch, are clearly below a.
bool clearly_below(const Vector& b, const Vector& a) {
  const double root_a = std::sqrt(a.sum());
  if (std::sqrt(b.sum()) > (1.0 - least_gain) * root_a) {
    return false;
  }
  const Vector gain = a - b;
  const auto n = static_cast<double>(gain.size());
  const double spread = std::sqrt((gain.array() - gain.mean()).square().sum() / std::max(n - 1.0, 1.0) / n);
  return gain.mean() > least_deviations * spread;
}

}  // namespace

namespace {

void require_joint(std::string_view who, const Robot& robot, const FrictionChoice& choice) {
  if (choice.joint < 0 || choice.joint >= robot.size()) {
    throw InputError(std::string(who) + ": joint is " + std::to_string(choice.joint) +
                     ", must be one of the " + std::to_string(robot.size()) + " joints of robot \"" +
                     robot.name + "\", counted from 0");
  }
}

}  // namespace

std::string FrictionChoice::text(const Robot& robot) const {
  require_joint("FrictionChoice::text", robot, *this);
  std::string symbols;
  for (const ParameterKind kind : parameters(law)) {
    symbols.append(symbols.empty() ? "" : " ").append(symbol(kind));
  }
  const std::string percent = number(100.0 * error, 3) + " %";
  return robot.joints[static_cast<std::size_t>(joint)].name + ": " + std::string(name(law)) + " friction (" +
         symbols + ") by cross-validation, " +
         (law == Friction::symmetric ? "error of unseen torques " + percent
                                     : percent + " of unseen torques instead of " +
                                           number(100.0 * symmetric_error, 3) + " % with symmetric");
}

std::vector<FrictionChoice> choose_friction(const Robot& robot, std::span<const Log> logs,
                                            const Estimation& asked) {
  std::vector<std::uint8_t> open;
  std::ranges::transform(robot.joints, std::back_inserter(open),
                         [](const Joint& joint) { return open_law(joint) ? 1 : 0; });
  if (std::ranges::count(open, 1) == 0) {
    return {};
  }
  if (logs.empty()) {
    throw InputError("choose_friction: no log is given");
  }
  Robot linear = without_load(robot);
  Estimation estimation = asked;
  estimation.method = Wls{};
  if (const auto fault = estimation.complaint(linear)) {
    throw InputError("choose_friction: " + *fault);
  }
  if (estimation.signal.automatic()) {
    static_cast<void>(detail::choose_rows(linear, logs, estimation));
  }
  for (std::size_t j = 0; j < open.size(); ++j) {
    linear.joints[j].friction = open[j] != 0 ? Friction::root : linear.joints[j].friction;
  }
  const BaseParameters base = base_parameters(linear);
  std::size_t folds = 0;
  std::vector<Stretch> stretches = stretches_of(linear, base, logs, estimation.signal, open, folds);
  Fits fits(linear, base, std::move(stretches), folds);
  const auto laws_with = [&](Friction law) {
    std::vector<Friction> laws;
    for (std::size_t j = 0; j < open.size(); ++j) {
      laws.push_back(open[j] != 0 ? law : linear.joints[j].friction);
    }
    return laws;
  };
  std::vector<Matrix> errors;
  errors.reserve(candidates.size());
  for (const Friction law : candidates) {
    errors.push_back(fits.unseen_errors(laws_with(law)));
  }
  const Matrix torques = fits.torques();
  std::vector<FrictionChoice> out;
  std::vector<Friction> chosen = laws_with(Friction::symmetric);
  for (std::size_t j = 0; j < open.size(); ++j) {
    if (open[j] == 0) {
      continue;
    }
    const auto at = static_cast<Index>(j);
    std::size_t best = 0;
    for (std::size_t k = 1; k < candidates.size(); ++k) {
      if (allowed(linear, j, candidates[k]) && clearly_below(errors[k].row(at), errors[best].row(at))) {
        best = k;
      }
    }
    chosen[j] = candidates[best];
    const double size = torques.row(at).sum();
    const auto relative = [&](const Matrix& of) {
      return size > 0.0 ? std::sqrt(of.row(at).sum() / size) : 0.0;
    };
    out.push_back({static_cast<int>(j), candidates[best], relative(errors[best]), relative(errors[0])});
  }
  // What each joint chose while all others had the same law.
  const Matrix together = fits.unseen_errors(chosen);
  for (FrictionChoice& choice : out) {
    const auto at = static_cast<Index>(choice.joint);
    const double size = torques.row(at).sum();
    choice.error = size > 0.0 ? std::sqrt(together.row(at).sum() / size) : 0.0;
  }
  return out;
}

Robot with_friction(Robot robot, std::span<const FrictionChoice> choices) {
  for (const FrictionChoice& choice : choices) {
    require_joint("with_friction", robot, choice);
    robot.joints[static_cast<std::size_t>(choice.joint)].friction = choice.law;
    robot.notes.push_back(choice.text(robot));
  }
  return robot;
}

}  // namespace rivid
