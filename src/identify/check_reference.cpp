#include <algorithm>
#include <cmath>
#include <string>

#include "identify/check_parts.hpp"
#include "identify/series.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double alike = Likeness::alike;
// A motion this many times larger or smaller than its reference is not a matter of gains.
constexpr double other_unit = 5.0;
// Search for delays of the motion behind its reference [s].
constexpr double longest_lead = 0.5;
constexpr double longest_delay = 5.0;
constexpr Index compared_samples = 1500;

// The reference, and by how much the motion is behind it.
struct Following {
  double delay = 0.0;  // [s]
  Likeness at_delay;   // q = factor q_r
};

Following following(const Log& log, Index j) {
  const Index stride = std::max<Index>(1, log.samples() / compared_samples);
  const Index count = log.samples() / stride;
  const Eigen::Map<const Vector, 0, Eigen::InnerStride<>> q(log.q.col(j).data(), count,
                                                            Eigen::InnerStride<>(stride));
  const Eigen::Map<const Vector, 0, Eigen::InnerStride<>> q_r(log.q_r.col(j).data(), count,
                                                              Eigen::InnerStride<>(stride));
  const double step = static_cast<double>(stride) / log.f_m;
  const auto lead = std::min(static_cast<Index>(longest_lead / step), count / 4);
  const auto delay = std::min(static_cast<Index>(longest_delay / step), count / 4);
  constexpr double shortness = 2e-3;  // correlation that a second less is worth [1/s]
  Following best;
  Following opposite;
  double most = -2.0;
  for (Index d = -lead; d <= delay; ++d) {
    const Index overlap = count - std::abs(d);
    const Likeness found =
        likeness(q_r.segment(std::max<Index>(-d, 0), overlap), q.segment(std::max<Index>(d, 0), overlap));
    // Of the delays that a periodic motion allows, the shortest.
    const double merit = found.correlation - shortness * static_cast<double>(std::abs(d)) * step;
    if (merit > most) {
      most = merit;
      best = {static_cast<double>(d) * step, found};
    }
    if (-found.correlation > -opposite.at_delay.correlation) {
      opposite = {static_cast<double>(d) * step, found};
    }
  }
  return best.at_delay.correlation < alike && -opposite.at_delay.correlation > alike ? opposite : best;
}

}  // namespace

void check_reference(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out) {
  if (log.q_r.cols() != robot.size() || log.q_r.rows() != log.q.rows()) {
    return;
  }
  bool leads = true;
  std::string delays;
  for (Index j = 0; j < robot.size(); ++j) {
    if (stands_still(log.q.col(j)) && stands_still(log.q_r.col(j))) {
      continue;
    }
    const Following found = following(log, j);
    const double factor = found.at_delay.factor;
    const std::string subject = place(robot, logs, log, j);
    leads = leads && found.delay < -2.0 / log.f_m;
    delays += (delays.empty() ? "" : ", ") + robot.joints[static_cast<std::size_t>(j)].name + " " +
              number(found.delay, 3) + " s";
    if (std::abs(found.at_delay.correlation) < alike) {
      out.add("reference_mismatch", subject,
              "correlation of motion and reference is " + number(found.at_delay.correlation, 2) +
                  " at best, should be above " + number(alike));
    } else if (factor < 1.0 / other_unit || factor > other_unit) {
      out.add("reference_unit", subject, "the motion is " + number(factor, 3) + " times its reference");
    }
  }
  if (delays.empty()) {
    return;
  }
  const std::string subject = logs.size() == 1 ? "all joints" : log.source;
  out.add(leads ? "reference_leads" : "reference_delay", subject, "motion behind reference: " + delays);
}

}  // namespace rivid::detail
