#include "rivid/identify/essential.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "accept.hpp"
#include "dense.hpp"
#include "identify/infer/covariance.hpp"
#include "identify/infer/infer.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Positions of each motion that M(q) is looked at.
constexpr Index most_positions = 500;

// Whether M(q) is positive definite along motions.
bool moves(const Robot& robot, const BaseParameters& base, const Vector& chi,
           std::span<const Matrix> motions) {
  Dynamics<double> dynamics(DynamicModel(robot, base.to_standard(chi)));
  const std::vector<double> rest(static_cast<std::size_t>(robot.size()), 0.0);
  std::vector<double> at(rest);
  for (const Matrix& q : motions) {
    const Index stride = std::max<Index>(q.rows() / most_positions, 1);
    for (Index k = 0; k < q.rows(); k += stride) {
      for (std::size_t j = 0; j < at.size(); ++j) {
        at[j] = q(k, static_cast<Index>(j));
      }
      if (!dynamics.set_state(at, rest)) {
        return false;
      }
    }
  }
  return true;
}

// A fit of some of the parameters, the others zero.
struct Reduced {
  Vector chi;     // of those kept
  Matrix from;    // χ_kept = from χ̂
  Vector spread;  // standard deviations for independent errors
  double loss = 0.0;
};

Reduced reduced(const Eigen::Ref<const Matrix>& root, const Vector& chi, const std::vector<Index>& kept) {
  Reduced out;
  const Matrix columns = root(Eigen::all, kept);
  const auto m = static_cast<Index>(kept.size());
  const detail::ThinQr qr = detail::thin_qr(columns);
  const Matrix inverse = qr.R.triangularView<Eigen::Upper>().solve(Matrix::Identity(m, m));
  out.from = inverse * (qr.Q.transpose() * root);
  out.chi = out.from * chi;
  out.spread = inverse.rowwise().norm();
  const Vector left = root * chi - columns * out.chi;
  out.loss = left.squaredNorm();
  return out;
}

Vector widened(const Vector& chi, const std::vector<Index>& kept, Index b) {
  Vector out = Vector::Zero(b);
  out(kept) = chi;
  return out;
}

void require_sizes(const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
                   const Eigen::Ref<const Matrix>& C_chi, const Eigen::Ref<const Matrix>& root) {
  const Index b = base.size();
  if (chi.size() != b || C_chi.rows() != b || C_chi.cols() != b || root.cols() != b || root.rows() < b) {
    throw InputError("essential: " + counted(chi.size(), "value") + ", a covariance (" +
                     std::to_string(C_chi.rows()) + " x " + std::to_string(C_chi.cols()) + ") and a root (" +
                     std::to_string(root.rows()) + " x " + std::to_string(root.cols()) + ") for " +
                     counted(b, "base parameter"));
  }
}

// The elimination, step by step.
class Elimination {
 public:
  Elimination(const Robot& robot, const BaseParameters& base, const Vector& chi, const Matrix& root,
              double freedom, std::span<const Matrix> q, const Essential& options)
      : robot_(robot), base_(base), chi_(chi), root_(root), freedom_(freedom), q_(q), options_(options) {
    kept_.resize(static_cast<std::size_t>(base.size()));
    std::iota(kept_.begin(), kept_.end(), Index{0});
    const Vector leading = regular_start(robot, base);
    for (Index i = 0; i < base.size(); ++i) {
      stays_.push_back(leading[i] != 0.0);
    }
    physical_ = moves(robot, base, chi, q);
    fit_ = reduced(root, chi, kept_);
  }

  // Takes one parameter out; whether there was one.
  bool step(EssentialParameters& out) {
    for (;;) {
      const Index at = least_needed();
      if (at < 0) {
        return false;
      }
      const Index parameter = kept_[static_cast<std::size_t>(at)];
      std::vector<Index> fewer = kept_;
      fewer.erase(fewer.begin() + at);
      Reduced without = reduced(root_, chi_, fewer);
      const double F = std::max(without.loss - fit_.loss, 0.0);
      const double p = f_tail(F, 1.0, freedom_);
      const auto removed = static_cast<double>(base_.size() - static_cast<Index>(fewer.size()));
      const double F_all = without.loss / removed;
      const double p_all = f_tail(F_all, removed, freedom_);
      if (p < options_.significance || p_all < options_.significance) {
        return false;
      }
      const std::string& name = base_.parameters[static_cast<std::size_t>(parameter)].name;
      if (physical_ && !moves(robot_, base_, widened(without.chi, fewer, base_.size()), q_)) {
        stays_[static_cast<std::size_t>(parameter)] = true;
        out.held.push_back(name);
        continue;
      }
      out.eliminated.push_back({name, F, p});
      out.F = F_all;
      out.p = p_all;
      kept_ = std::move(fewer);
      fit_ = std::move(without);
      return true;
    }
  }

  [[nodiscard]] const std::vector<Index>& kept() const { return kept_; }
  [[nodiscard]] const Reduced& fit() const { return fit_; }

 private:
  // The place, among those kept, of the largest relative standard deviation; −1 where all must stay.
  [[nodiscard]] Index least_needed() const {
    Index out = -1;
    double least = 0.0;
    for (Index k = 0; k < fit_.chi.size() && kept_.size() > 1; ++k) {
      const double t = std::abs(fit_.chi[k]) / fit_.spread[k];
      if (!stays_[static_cast<std::size_t>(kept_[static_cast<std::size_t>(k)])] && (out < 0 || t < least)) {
        out = k;
        least = t;
      }
    }
    return out;
  }

  const Robot& robot_;
  const BaseParameters& base_;
  const Vector& chi_;
  const Matrix& root_;
  double freedom_;
  std::span<const Matrix> q_;
  const Essential& options_;
  std::vector<Index> kept_;
  std::vector<bool> stays_;
  bool physical_ = false;
  Reduced fit_;
};

}  // namespace

std::optional<std::string> Essential::complaint() const {
  const bool sensible = significance > 0.0 && significance < 1.0;
  if (!sensible) {
    return "significance is " + number(significance) + ", must lie between 0 and 1";
  }
  return std::nullopt;
}

EssentialParameters essential(const Robot& robot, const BaseParameters& base,
                              const Eigen::Ref<const Vector>& chi, const Eigen::Ref<const Matrix>& C_chi,
                              const Eigen::Ref<const Matrix>& root, double freedom, std::span<const Matrix> q,
                              const Essential& options) {
  detail::accept("essential", options.complaint());
  require_sizes(base, chi, C_chi, root);
  detail::accept("essential", base.complaint(robot));
  if (!chi.allFinite() || !C_chi.allFinite() || !root.allFinite()) {
    throw InputError("essential: chi, C_chi and root must be finite");
  }
  if (!std::isfinite(freedom) || freedom <= 0.0) {
    throw InputError("essential: freedom is " + number(freedom) + ", must be positive");
  }
  for (const Matrix& motion : q) {
    if (motion.cols() != robot.size() || !motion.allFinite()) {
      throw InputError("essential: q is " + std::to_string(motion.rows()) + " × " +
                       std::to_string(motion.cols()) + ", must be finite with a column for each of the " +
                       counted(robot.size(), "joint"));
    }
  }
  EssentialParameters out;
  const Vector full = chi;
  const Matrix information_root = root;
  Elimination elimination(robot, base, full, information_root, freedom, q, options);
  while (elimination.step(out)) {
  }
  out.kept = elimination.kept();
  const Reduced& fit = elimination.fit();
  out.chi = widened(fit.chi, out.kept, base.size());
  out.from = Matrix::Zero(base.size(), base.size());
  out.from(out.kept, Eigen::all) = fit.from;
  out.C_chi = out.from * C_chi * out.from.transpose();
  return out;
}

void detail::add_essential(const EstimationProblem& problem, const Estimate& estimate, Inference& out) {
  const std::optional<Essential>& options = problem.estimation.essential;
  if (!options) {
    return;
  }
  if (!out.uncertainty.C.allFinite() || estimate.freedom() <= 0.0) {
    out.notes.push_back("essential parameters were not looked for: the data do not determine all parameters");
    return;
  }
  const std::vector<Matrix> q = detail::made_of(problem.logs, &Log::q);
  const Matrix root = decimation_factor(estimate.signals.front()) / estimate.sigma * estimate.root;
  EssentialModel& model = out.essential.emplace();
  model.options = *options;
  model.parameters = essential(problem.robot, problem.base, out.chi, out.uncertainty.C, root,
                               estimate.freedom(), q, *options);
  model.fit = fit_to(problem.robot, problem.rows_to_judge(), model.parameters.chi,
                     static_cast<Index>(model.parameters.kept.size()), problem.estimation.signal.convention);
}

}  // namespace rivid
