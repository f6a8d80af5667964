#include "rivid/identify/friction_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <utility>

#include "accept.hpp"
#include "dense.hpp"
#include "identify/choose/friction_fits.hpp"
#include "identify/choose/row_choice.hpp"
#include "identify/rows/time_blocks.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// From simple to rich; the first is that of comparison.
constexpr std::array candidates = {Friction::symmetric, Friction::root, Friction::load, Friction::load_root};
// of time, each predicted by the fit to the others; a choice: more take a fit each
constexpr Index wanted_stretches = 8;
// By how much of its error, and by how many standard errors, a richer law has to be better than a simpler
// one.
constexpr double least_gain = 0.03;
constexpr double least_deviations = 2.0;
// A joint whose Fl has a larger deviation than this, is negative by more deviations than that, or larger than
// gears with which a robot moves, has friction that does not follow its load.
constexpr double most_open_load = 0.05;
constexpr double least_deviations_of_sign = 3.0;
constexpr double most_load = 0.8;
// Chance of being the better one from which on a law is named as hardly distinguished.
constexpr double close_chance = 0.05;
bool open_law(const Joint& joint) { return joint.friction == Friction::automatic; }

// Rows of some logs, joint by joint and stretch by stretch; all open joints have √|q̇|.
class Stretches {
 public:
  Stretches(const Robot& robot, const BaseParameters& base, const SignalOptions& signal,
            const std::vector<std::uint8_t>& open)
      : robot_(robot), base_(base), signal_(signal), open_(open), parameters_(base.columns()) {}

  // Of a log whose stretches `at` says, (fold, first row, count).
  template <typename Divide>
  void add(const Log& log, const Divide& divide) {
    const Rows made = rows(robot_, base_, log, signal_);
    for (std::size_t j = 0; j < made.Y.size(); ++j) {
      divide(made.samples[j],
             [&](Index fold, Index first, Index count) { add(made, j, fold, first, count); });
    }
  }

  [[nodiscard]] std::vector<detail::StretchRows> all() && { return std::move(all_); }

 private:
  void add(const Rows& made, std::size_t j, Index fold, Index first, Index count) {
    const JointRows& joint = made.W.joints[j];
    detail::StretchRows& piece = all_.emplace_back();
    piece.joint = j;
    piece.fold = static_cast<std::size_t>(fold);
    piece.columns = joint.columns;
    piece.W = joint.W.middleRows(first, count);
    piece.y = made.Y[j].segment(first, count);
    if (open_[j] == 0) {
      return;
    }
    piece.rigid = piece.W;
    for (std::size_t c = 0; c < joint.columns.size(); ++c) {
      const StandardParameter& p = parameters_[static_cast<std::size_t>(joint.columns[c])];
      if (p.kind == ParameterKind::Fc && p.joint == static_cast<int>(j)) {
        piece.sign = piece.W.col(static_cast<Index>(c));
      }
      if (is_friction(p.kind)) {
        piece.rigid.col(static_cast<Index>(c)).setZero();
      }
    }
  }

  const Robot& robot_;
  const BaseParameters& base_;
  const SignalOptions& signal_;
  const std::vector<std::uint8_t>& open_;
  std::vector<StandardParameter> parameters_;
  std::vector<detail::StretchRows> all_;
};

// By how much law b leaves less of the unseen torques than law a, of some joints together: mean over the
// stretches, and its standard error. Each joint counts by its own error, so that no unit matters.
struct Gain {
  double mean = 0.0;
  double sigma = 0.0;
  double part = 0.0;  // of the error, root of the mean of all joints

  [[nodiscard]] bool clear() const { return part > least_gain && mean > least_deviations * sigma; }

  // Chance that b is the better one on another log, by this scatter.
  [[nodiscard]] double chance() const {
    return sigma > 0.0 ? 0.5 * std::erfc(-mean / sigma / std::numbers::sqrt2) : (mean > 0.0 ? 1.0 : 0.0);
  }
};

Gain gain(const Matrix& a, const Matrix& b, const Matrix& torques, const std::vector<Index>& joints) {
  Vector by_stretch = Vector::Zero(a.cols());
  double counted = 0.0;
  for (const Index j : joints) {
    const double size = std::min(a.row(j).sum(), b.row(j).sum());
    // A joint that nothing is known of without one of the stretches says nothing of its friction.
    if (size > 0.0 && size < torques.row(j).sum()) {
      by_stretch += (a.row(j) - b.row(j)).transpose() / size;
      ++counted;
    }
  }
  const auto n = static_cast<double>(by_stretch.size());
  const double mean = by_stretch.mean();
  const double excess = counted > 0.0 ? by_stretch.sum() / counted : 0.0;
  return {.mean = mean,
          .sigma = std::sqrt((by_stretch.array() - mean).square().sum() / std::max(n - 1.0, 1.0) / n),
          .part = excess > 0.0 ? 1.0 - 1.0 / std::sqrt(1.0 + excess) : 0.0};
}

// Whether all rows show how the friction of a joint follows its load, and do not contradict any gear.
std::vector<std::uint8_t> show_load(detail::FrictionFits& fits, const std::vector<Friction>& laws) {
  const detail::LawFit fit = fits.fit(laws);
  const Vector sigma = fits.load_sigma(fit);
  std::vector<std::uint8_t> out;
  for (Index j = 0; j < sigma.size(); ++j) {
    const double Fl = fit.theta.tail(sigma.size())[j];
    const bool shown =
        sigma[j] < most_open_load && Fl > -least_deviations_of_sign * sigma[j] && Fl < most_load;
    out.push_back(shown ? 1 : 0);
  }
  return out;
}

// The law without friction that follows the load.
Friction without_load(Friction law) {
  return law == Friction::load_root ? Friction::root : law == Friction::load ? Friction::symmetric : law;
}

// Laws of all joints, where the open ones have a candidate, without the load where that is not shown. Motors
// of several joints with dry friction of their own do not go with every law, nor does a prefilter: such
// joints keep the first.
std::vector<Friction> laws_with(const Robot& linear, const Estimation& asked,
                                const std::vector<std::uint8_t>& open,
                                const std::vector<std::uint8_t>& shows_load, Friction law) {
  const Iv* const iv = std::get_if<Iv>(&asked.method);
  const bool prefiltered = iv != nullptr && iv->prefilter && has(law, Basis::load);
  std::vector<Friction> out;
  for (std::size_t j = 0; j < open.size(); ++j) {
    Robot with = linear;
    const Friction own = shows_load[j] == 0 ? without_load(law) : law;
    with.joints[j].friction = own;
    const bool goes = !with.complaint() && !prefiltered;
    out.push_back(open[j] == 0 ? linear.joints[j].friction : goes ? own : candidates.front());
  }
  return out;
}

// The law for some joints, with what is unseen of each candidate; the chance that each of them is better.
struct Chosen {
  std::size_t law = 0;
  std::vector<double> chances;
};

Chosen chosen_law(std::span<const Matrix> errors, const Matrix& torques, const std::vector<Index>& joints) {
  Chosen out;
  for (std::size_t k = 1; k < candidates.size(); ++k) {
    const Gain by = gain(errors[out.law], errors[k], torques, joints);
    out.law = by.clear() ? k : out.law;
  }
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    out.chances.push_back(k == out.law ? 0.0 : gain(errors[out.law], errors[k], torques, joints).chance());
  }
  return out;
}

Matrix positive_part(const Matrix& C) {
  const detail::SymmetricEigen of_C = detail::symmetric_eigen(C);
  return of_C.vectors * of_C.values.cwiseMax(0.0).asDiagonal() * of_C.vectors.transpose();
}

// ‖Y − Ŷ‖ / ‖Y‖ of some joints.
double relative_error(const Matrix& squares, const Matrix& torques, const std::vector<Index>& joints) {
  const double size = torques(joints, Eigen::all).sum();
  return size > 0.0 ? std::sqrt(squares(joints, Eigen::all).sum() / size) : 0.0;
}

void require_joints(std::string_view who, const Robot& robot, const FrictionChoice& choice) {
  for (const int joint : choice.joints) {
    if (joint < 0 || joint >= robot.size()) {
      throw InputError(std::string(who) + ": joint is " + std::to_string(joint) + ", must be one of the " +
                       std::to_string(robot.size()) + " joints of robot \"" + robot.name +
                       "\", counted from 0");
    }
  }
}

std::string names_of_joints(const Robot& robot, const std::vector<int>& joints) {
  if (std::ssize(joints) == robot.size() && joints.size() > 1) {
    return "all joints";
  }
  return listed(
      detail::made_of(joints, [&](int joint) { return robot.joints[static_cast<std::size_t>(joint)].name; }));
}

std::string percent(double part) { return number(100.0 * part, 3) + " %"; }

}  // namespace

std::string FrictionChoice::text(const Robot& robot) const {
  require_joints("FrictionChoice::text", robot, *this);
  std::string symbols;
  for (const ParameterKind kind : parameters(law)) {
    symbols.append(symbols.empty() ? "" : " ").append(symbol(kind));
  }
  const auto instead = [&](double of_symmetric) {
    return law == Friction::symmetric ? "" : " instead of " + percent(of_symmetric) + " with symmetric";
  };
  std::string out = names_of_joints(robot, joints) + ": " + std::string(name(law)) + " friction (" + symbols +
                    ") by cross-validation, error of unseen torques " + percent(error) +
                    instead(symmetric_error);
  if (validation_error && symmetric_validation_error) {
    out += "; of the validation logs " + percent(*validation_error) + instead(*symmetric_validation_error);
  }
  std::string others;
  for (const Friction other : close) {
    others += (others.empty() ? "" : ", ") + std::string(name(other));
  }
  return others.empty() ? out
                        : out + "; hardly distinguished from " + others +
                              ", by whose estimates the intervals are widened";
}

FrictionChoices choose_friction(const Robot& robot, std::span<const Log> logs, const Estimation& asked,
                                std::span<const Log> validation) {
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
  detail::accept("choose_friction", estimation.complaint(linear));
  if (estimation.signal.automatic()) {
    static_cast<void>(detail::choose_rows(linear, logs, estimation));
  }
  for (std::size_t j = 0; j < open.size(); ++j) {
    linear.joints[j].friction = open[j] != 0 ? Friction::root : linear.joints[j].friction;
  }
  const BaseParameters base = base_parameters(linear);
  const detail::TimeBlocks blocks(detail::durations(logs), wanted_stretches);
  const auto folds = static_cast<std::size_t>(blocks.count());
  Stretches stretches(linear, base, estimation.signal, open);
  for (std::size_t l = 0; l < logs.size(); ++l) {
    stretches.add(logs[l],
                  [&](std::span<const Index> samples, const auto& take) { blocks.divide(l, samples, take); });
  }
  for (const Log& log : validation) {
    stretches.add(log, [&](std::span<const Index> samples, const auto& take) {
      take(blocks.count(), 0, std::ssize(samples));
    });
  }
  detail::FrictionFits fits(linear, base, std::move(stretches).all(), folds);
  std::vector<std::vector<Friction>> laws;
  std::vector<Matrix> errors;
  const std::vector<std::uint8_t> shows_load = show_load(
      fits, laws_with(linear, asked, open, std::vector<std::uint8_t>(open.size(), 1), Friction::load));
  for (const Friction law : candidates) {
    laws.push_back(laws_with(linear, asked, open, shows_load, law));
    errors.push_back(fits.unseen_errors(laws.back()));
  }
  const Matrix all_torques = fits.torques();
  const Matrix torques = all_torques.leftCols(blocks.count());
  std::vector<Friction> best = laws.front();
  std::vector<std::pair<std::vector<Index>, Chosen>> kinds;
  for (const JointType type : {JointType::revolute, JointType::prismatic}) {
    const std::vector<Index> joints = detail::places_where(std::ssize(open), [&](Index j) {
      const auto at = static_cast<std::size_t>(j);
      return open[at] != 0 && robot.joints[at].type == type;
    });
    if (!joints.empty()) {
      kinds.emplace_back(joints, chosen_law(errors, torques, joints));
      for (const Index j : joints) {
        best[static_cast<std::size_t>(j)] = laws[kinds.back().second.law][static_cast<std::size_t>(j)];
      }
    }
  }
  const auto same = std::ranges::find(laws, best);
  const Matrix unseen =
      same != laws.end() ? errors[static_cast<std::size_t>(same - laws.begin())] : fits.unseen_errors(best);
  const detail::LawFit of_best = fits.fit(best);
  FrictionChoices out;
  Robot with = linear;
  for (std::size_t j = 0; j < best.size(); ++j) {
    with.joints[j].friction = best[j];
  }
  const BaseParameters to = base_parameters(with);
  out.C = Matrix::Zero(to.size(), to.size());
  const Matrix own_C = fits.covariance(of_best, base, to);
  for (const auto& [joints, chosen] : kinds) {
    double sum = 1.0;
    for (const double chance : chosen.chances) {
      sum += chance;
    }
    std::vector<Friction> close;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (chosen.chances[k] > close_chance) {
        close.push_back(candidates[k]);
      }
      std::vector<Friction> others = best;
      for (const Index j : joints) {
        others[static_cast<std::size_t>(j)] = laws[k][static_cast<std::size_t>(j)];
      }
      if (others != best) {
        const detail::LawFit of_others = fits.fit(others);
        const Vector shift = fits.values(of_others.theta - of_best.theta, base, to);
        out.C += chosen.chances[k] / sum *
                 (shift * shift.transpose() + positive_part(fits.covariance(of_others, base, to) - own_C));
      }
    }
    // Joints of the law, and those that have a simpler one.
    for (const Friction law : candidates) {
      FrictionChoice choice{.joints = {}, .law = law};
      std::vector<Index> own;
      std::ranges::copy_if(joints, std::back_inserter(own),
                           [&](Index j) { return best[static_cast<std::size_t>(j)] == law; });
      if (own.empty()) {
        continue;
      }
      choice.joints.assign(own.begin(), own.end());
      choice.error = relative_error(unseen, torques, own);
      choice.symmetric_error = relative_error(errors.front(), torques, own);
      if (!validation.empty()) {
        const Matrix last = all_torques.rightCols(1);
        choice.validation_error = relative_error(fits.validation_errors(of_best.theta), last, own);
        choice.symmetric_validation_error =
            relative_error(fits.validation_errors(fits.fit(laws.front()).theta), last, own);
      }
      choice.close = close;
      out.kinds.push_back(std::move(choice));
    }
  }
  return out;
}

Robot with_friction(Robot robot, std::span<const FrictionChoice> choices) {
  for (const FrictionChoice& choice : choices) {
    require_joints("with_friction", robot, choice);
    for (const int joint : choice.joints) {
      robot.joints[static_cast<std::size_t>(joint)].friction = choice.law;
    }
    robot.notes.push_back(choice.text(robot));
  }
  return robot;
}

}  // namespace rivid
