#include "identify/robust_report.hpp"

#include <cmath>
#include <string>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Part of a joint's rows with less than half their weight from which these are no outliers any more: normal errors have
// 0.7 % of them (Huber) or 1.1 % (bisquare).
constexpr double too_many = 0.1;

}  // namespace

void tell_robust(const Robot& robot, const Robust& options, const RowLoss& loss,
                 std::span<const RobustSums> sums, int rounds, bool settled, const Vector& chi,
                 Identification& out) {
  out.title += options.kind == RobustKind::huber ? ", Huber" : ", bisquare";
  RobustReport& report = out.robust.emplace();
  report.options = options;
  report.rounds = rounds;
  report.chi = chi;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    report.joints.push_back({.name = robot.joints[j].name,
                             .scale = loss.scales[j],
                             .rows = sums[j].rows,
                             .below_one = sums[j].below_one,
                             .below_half = sums[j].below_half,
                             .rejected = sums[j].rejected});
  }
  if (!settled && out.status == Status::identified) {
    out.status = Status::not_converged;
    out.reasons.push_back("the weights of the rows and the parameters do not settle on each other in " +
                          counted(options.max_rounds, "round"));
  }
}

void judge_robust(Identification& out) {
  if (!out.robust) {
    return;
  }
  RobustReport& report = *out.robust;
  std::string moved;
  for (Index i = 0; i < out.base.size(); ++i) {
    const ParameterEstimate& p = out.parameters[static_cast<std::size_t>(i)];
    const double shift = std::abs(out.chi[i] - report.chi[i]) / p.sigma;
    if (shift > report.largest_shift) {
      report.largest_shift = shift;
      report.parameter = p.name;
    }
    if (shift > out.covariance.quantile_975) {
      moved += (moved.empty() ? "" : ", ") + p.name + " (" + number(report.chi[i], 4) + " to " +
               number(p.value, 4) + ")";
    }
  }
  if (!moved.empty()) {
    out.warnings.push_back(Finding{
        "outliers_decide",
        {},
        "outliers decide: weights on the rows move " + moved +
            " by more than the 95 % intervals; rows of little weight may be outliers, or what the model "
            "misses, friction at low speed say: look at them before either estimate is trusted"});
  }
  for (const RobustJoint& joint : report.joints) {
    const double share = static_cast<double>(joint.below_half) / static_cast<double>(joint.rows);
    if (share > too_many) {
      out.warnings.push_back(
          Finding{"many_outliers",
                  {},
                  "joint \"" + joint.name + "\": " + number(100.0 * share, 3) +
                      " % of its rows have less than half their weight, which is more than outliers: "
                      "the model misses something there, or a decimation smears each outlier over "
                      "many rows"});
    }
  }
}

}  // namespace rivid::detail
