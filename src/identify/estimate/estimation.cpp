#include "rivid/identify/estimation.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "dense.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

std::optional<std::string> complaint_of(const Iv& iv, const Estimation& estimation, const Robot& robot) {
  if (!iv.control) {
    return "control is not set; the loop that is simulated needs a control law, PdControl say";
  }
  if (auto fault = estimation.signal.complaint(robot.size())) {
    return fault;
  }
  if (iv.follows == Iv::Follows::measured && iv.reference_cutoff_hz == 0.0 &&
      estimation.signal.cutoff_hz == 0.0) {
    return "reference_cutoff_hz is 0: a loop that followed the raw positions would carry their noise into "
           "the instruments; it must be positive where follows is measured";
  }
  if (auto fault = iv.sampling.complaint(robot.size())) {
    return fault;
  }
  if (iv.prefilter && iv.compares != Iv::Compares::instruments) {
    return "prefilter belongs to instrumental variables, not to " + std::string(title(iv));
  }
  if (estimation.robust && iv.compares != Iv::Compares::instruments) {
    return "robust belongs to least squares and instrumental variables, not to " + std::string(title(iv));
  }
  if (iv.compares == Iv::Compares::positions && iv.follows == Iv::Follows::measured) {
    return "follows is measured: a loop that follows the measured positions has nothing to tell output "
           "error; it must be reference";
  }
  if (iv.compares != Iv::Compares::instruments && has_load(robot)) {
    return std::string(title(iv)) + " does not go with friction that follows the load";
  }
  if (iv.prefilter && estimation.robust) {
    return "prefilter and robust do not go together: a filter smears each outlier over the rows that follow";
  }
  if (iv.prefilter && !estimation.signal.exact_rows()) {
    return "prefilter works on exact rows: rows must be \"exact\"";
  }
  if (iv.prefilter_order < 0 || iv.prefilter_order > Iv::most_prefilter_order) {
    return "prefilter_order is " + std::to_string(iv.prefilter_order) + ", must lie between 0 and " +
           std::to_string(Iv::most_prefilter_order);
  }
  return range_fault(iv);
}

// ZZ of frame j as the link frame calls it: the joint's axis may be another one there.
ParameterKind about_axis(const Chain::Link& link) {
  for (const ParameterKind kind : {ParameterKind::XX, ParameterKind::YY}) {
    if (inertial_column(link, kind).index == static_cast<int>(ParameterKind::ZZ)) {
      return kind;
    }
  }
  return ParameterKind::ZZ;
}

// Among method_names.
static_assert(method_names.size() == std::variant_size_v<Method> + 2);
std::size_t place_of(const Method& method) {
  const Iv* const iv = std::get_if<Iv>(&method);
  if (iv == nullptr || iv->compares == Iv::Compares::instruments) {
    return method.index();
  }
  return std::variant_size_v<Method> + (iv->compares == Iv::Compares::torques ? 0 : 1);
}

}  // namespace

std::optional<std::string> Robust::complaint() const {
  if (tuning && (!std::isfinite(*tuning) || *tuning <= 0.0)) {
    return "tuning is " + number(*tuning) + ", must be positive";
  }
  if (max_rounds < 1) {
    return "max_rounds is " + std::to_string(max_rounds) + ", must be at least 1";
  }
  if (!std::isfinite(tolerance) || tolerance <= 0.0) {
    return "tolerance is " + number(tolerance) + ", must be positive";
  }
  return std::nullopt;
}

std::optional<std::string> Estimation::complaint(const Robot& robot) const {
  const Auto* const open = std::get_if<Auto>(&method);
  const Iv* const iv = open != nullptr && open->iv.control ? &open->iv : std::get_if<Iv>(&method);
  if (auto fault = iv != nullptr ? complaint_of(*iv, *this, robot) : signal.complaint(robot.size())) {
    return fault;
  }
  if (robot.base_joints > 0 && iv != nullptr) {
    return "instruments are simulated on a base that stands still, that of robot \"" + robot.name +
           "\" floats: take \"wls\"";
  }
  for (const Joint& joint : robot.joints) {
    if (joint.friction == Friction::automatic) {
      return "friction of joint \"" + joint.name +
             "\" is to be chosen; choose_friction() and rivid identify do that before, by the logs; else "
             "name a law, such as "
             "\"load_root\"";
    }
  }
  if (iv != nullptr && iv->prefilter && has_load(robot)) {
    return "prefilter does not go with friction that follows the load: the absolute value of the torque of a "
           "row that is "
           "not averaged is too large by its noise";
  }
  if (auto fault = covariance.complaint()) {
    return fault;
  }
  if (gain_covariance.size() > 0 &&
      (gain_covariance.rows() != robot.size() || !detail::is_positive_semidefinite(gain_covariance))) {
    return "gain_covariance is " + std::to_string(gain_covariance.rows()) + " × " +
           std::to_string(gain_covariance.cols()) +
           ", must be n × n, finite, symmetric and positive semidefinite for the " +
           counted(robot.size(), "joint");
  }
  if (choice_covariance.rows() != choice_covariance.cols() || !choice_covariance.allFinite()) {
    return "choice_covariance must be a square of finite numbers, as choose_friction() makes it";
  }
  if (auto fault = physical ? physical->complaint(robot) : std::nullopt) {
    return "physical: " + *fault;
  }
  if (auto fault = essential ? essential->complaint() : std::nullopt) {
    return "essential: " + *fault;
  }
  if (auto fault = robust ? robust->complaint() : std::nullopt) {
    return "robust: " + *fault;
  }
  if (threads < 1) {
    return "threads is " + std::to_string(threads) + ", must be at least 1";
  }
  return std::nullopt;
}

std::string_view name(const Method& method) { return method_names[place_of(method)]; }

std::string_view title(const Method& method) {
  constexpr std::array<std::string_view, method_names.size()> titles = {
      "IDIM-OLS", "IDIM-WLS", "IDIM-IV", "automatic", "DIDIM", "closed-loop output error"};
  return titles[place_of(method)];
}

Vector regular_start(const Robot& robot, const BaseParameters& base) {
  Vector chi_st = Vector::Zero(static_cast<Index>(base.standard.size()));
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    const ParameterKind kind = joint.rotor_inertia                 ? ParameterKind::Ia
                               : joint.type == JointType::revolute ? about_axis(robot.chain.links[j])
                                                                   : ParameterKind::M;
    for (std::size_t i = 0; i < base.standard.size(); ++i) {
      if (base.standard[i].joint == static_cast<int>(j) && base.standard[i].kind == kind) {
        chi_st[static_cast<Index>(i)] = 1.0;
      }
    }
  }
  return base.from_standard(chi_st);
}

}  // namespace rivid
