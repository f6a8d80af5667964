// What a result says of itself: friction that drives, a validation that contradicts the fit.

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/check/alternatives.hpp"
#include "identify/check/checks.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// A residual of a joint on another log that is so many times the expected one contradicts the fit.
constexpr double much_worse = 2.0;

// Rows for each parameter from which deviations can be estimated.
constexpr Index least_rows = 2;

}  // namespace

void check_rows(const Identification& result, Findings& out) {
  const Index rows = result.fit.rows;
  const Index b = result.base.size();
  if (rows < least_rows * b) {
    out.add("few_rows", "all joints",
            std::to_string(rows) + " rows for " + counted(b, "base parameter") + ", should be " +
                std::to_string(least_rows * b) + " at least: deviations mean nothing");
  }
}

void check_validation(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                      const Identification& result, Findings& out) {
  for (std::size_t l = 0; l < std::min(validation.size(), result.validation.size()); ++l) {
    const Validation& found = result.validation[l];
    const Fit& there = result.answer_fit(found);
    const auto suspicious = [&](std::size_t j) {
      return there.joints[j].sigma_rho > much_worse * result.answer_fit().joints[j].sigma_rho;
    };
    bool any = false;
    for (std::size_t j = 0; j < there.joints.size(); ++j) {
      any = any || suspicious(j);
    }
    const bool poor = looks_poor(there);
    if (!any && !poor) {
      continue;
    }
    // Of an arm that nothing else is wrong with.
    if (!out.any(Severity::error)) {
      check_together(robot, logs, validation[l], result, out);
    }
    const TorqueProbe probe(robot, result.base, validation.subspan(l, 1), result.estimation.signal);
    if (poor) {
      check_poor_validation(probe, robot, found, result, out);
    }
    const std::optional<ProbedRows> rows = any ? ProbedRows::fitted(probe, robot, result) : std::nullopt;
    if (!rows) {
      continue;
    }
    const Vector residual = rows->Y - rows->W * result.answer();
    for (const ProbedRows::Piece& piece : rows->pieces) {
      const auto j = static_cast<std::size_t>(piece.joint);
      if (piece.size() == 0 || !suspicious(j) || !rows->tested(piece.joint)) {
        continue;
      }
      // What errors of the parameters make of this motion.
      const auto of_joint = rows->W.middleRows(piece.first, piece.size());
      const double by_parameters =
          (of_joint * result.answer_covariance()).cwiseProduct(of_joint).rowwise().sum().mean();
      const auto mean_square = [&](const Vector& x) {
        return x.segment(piece.first, piece.size()).squaredNorm() / static_cast<double>(piece.size());
      };
      const double seen = std::sqrt(mean_square(residual)) / rows->weights[piece.joint];
      const double expected =
          std::sqrt(mean_square(rows->residual) + by_parameters) / rows->weights[piece.joint];
      if (seen > much_worse * expected) {
        const std::string& unit = result.fit.joints[j].unit;
        std::string text = found.file + ": the model leaves " + number(seen, 3) + " " + unit;
        text += " there; by a fit to that log and the uncertainty of the parameters " + number(expected, 3);
        text += " " + unit + " were to be expected";
        out.add("validation_worse", result.fit.joints[j].name, std::move(text));
      }
    }
  }
}

}  // namespace rivid::detail
