#include <array>
#include <memory>
#include <string>
#include <utility>

#include "experiment/column_reader.hpp"
#include "experiment/simulation_sections.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

namespace detail {

namespace {

enum class Law { pd, pid, cascade, computed_torque };
enum class VelocityFilter { backward, central, none };
enum class ControllerModel { simulated, a_priori };

constexpr std::array<std::pair<std::string_view, Law>, 4> law_words = {
    {{"pd", Law::pd},
     {"pid", Law::pid},
     {"cascade", Law::cascade},
     {"computed_torque", Law::computed_torque}}};

// Poles that all laws can be given by; ζ = 1 where only ω_n is told.
template <typename Specification>
void read_poles(TomlReader& keys, Specification& out, Index n) {
  out.omega_n = read_per_joint(keys, "omega_n", n);
  out.zeta = read_per_joint(keys, "zeta", n);
  if (out.omega_n.size() > 0 && out.zeta.size() == 0) {
    out.zeta = Vector::Ones(n);
  }
  out.v_tau_max = read_per_joint(keys, "v_tau_max", n);
}

// A law as its keys tell it. What is wrong with it is told when all keys are known: a mistyped one comes first.
struct LawSection {
  std::optional<std::string> complaint;
  Vector omega_n;
  Control control;
};

template <typename Specification>
LawSection section_of(const Robot& robot, Specification specification) {
  return {.complaint = specification.complaint(robot),
          .omega_n = specification.omega_n,
          .control = std::move(specification)};
}

LawSection read_pd(TomlReader& keys, const Robot& robot) {
  const Index n = robot.size();
  PdControl out;
  read_poles(keys, out, n);
  out.k_p = read_per_joint(keys, "k_p", n);
  out.k_v = read_per_joint(keys, "k_v", n);
  out.J_apriori = read_per_joint(keys, "J_apriori", n);
  out.reference_velocity = keys.boolean("reference_velocity").value_or(out.reference_velocity);
  return section_of(robot, std::move(out));
}

LawSection read_pid(TomlReader& keys, const Robot& robot) {
  const Index n = robot.size();
  PidControl out;
  read_poles(keys, out, n);
  out.omega_i = read_per_joint(keys, "omega_i", n);
  out.K_p = read_per_joint(keys, "K_p", n);
  out.K_i = read_per_joint(keys, "K_i", n);
  out.K_d = read_per_joint(keys, "K_d", n);
  out.J_apriori = read_per_joint(keys, "J_apriori", n);
  out.tracking_time = read_per_joint(keys, "tracking_time", n);
  return section_of(robot, std::move(out));
}

LawSection read_cascade(TomlReader& keys, const Robot& robot) {
  const Index n = robot.size();
  CascadeControl out;
  read_poles(keys, out, n);
  out.omega_i = read_per_joint(keys, "omega_i", n);
  out.k_p = read_per_joint(keys, "k_p", n);
  out.k_v = read_per_joint(keys, "k_v", n);
  out.T_i = read_per_joint(keys, "T_i", n);
  out.J_apriori = read_per_joint(keys, "J_apriori", n);
  out.feed_forward = read_per_joint(keys, "feed_forward", n);
  out.tracking_time = read_per_joint(keys, "tracking_time", n);
  return section_of(robot, std::move(out));
}

LawSection read_computed_torque(TomlReader& keys, const Robot& robot) {
  const Index n = robot.size();
  ComputedTorqueControl out;
  read_poles(keys, out, n);
  out.k_p = read_per_joint(keys, "k_p", n);
  out.k_d = read_per_joint(keys, "k_d", n);
  out.friction = keys.boolean("friction").value_or(out.friction);
  out.coulomb_velocity = keys.number("coulomb_velocity").value_or(out.coulomb_velocity);
  const auto model = keys.choice(
      "model", std::array<std::pair<std::string_view, ControllerModel>, 2>{
                   {{"simulated", ControllerModel::simulated}, {"a_priori", ControllerModel::a_priori}}});
  if (model == ControllerModel::a_priori) {
    out.model = std::make_shared<const DynamicModel>(robot, robot.chi_st());
  }
  return section_of(robot, std::move(out));
}

std::vector<double> read_velocity_filter(TomlReader& keys, std::vector<double> otherwise) {
  const toml::node* const node = keys.find("velocity_filter");
  if (node == nullptr) {
    return otherwise;
  }
  if (!node->is_string()) {
    return keys.numbers("velocity_filter").value_or(otherwise);
  }
  constexpr std::array<std::pair<std::string_view, VelocityFilter>, 3> words = {
      {{"backward", VelocityFilter::backward},
       {"central", VelocityFilter::central},
       {"none", VelocityFilter::none}}};
  switch (keys.as_choice(*node, "velocity_filter", words)) {
    case VelocityFilter::central:
      return {0.5, 0.0, -0.5};
    case VelocityFilter::none:
      return {};
    case VelocityFilter::backward:
      break;
  }
  return {1.0, -1.0};
}

Sampling read_sampling(TomlReader& keys, Index n) {
  Sampling out;
  const auto rate_hz = keys.number("rate_hz");
  if (rate_hz) {
    if (*rate_hz <= 0.0) {
      keys.fail(*keys.find("rate_hz"), "rate_hz", "is " + number(*rate_hz) + " Hz, must be positive");
    }
    out.period = 1.0 / *rate_hz;
  }
  out.delay = keys.count("delay").value_or(out.delay);
  out.velocity_filter = read_velocity_filter(keys, out.velocity_filter);
  out.reference_lead = keys.count("reference_lead").value_or(out.reference_lead);
  out.quantum = read_per_joint(keys, "quantum", n);
  for (const char* const key : {"delay", "velocity_filter", "reference_lead"}) {
    if (!rate_hz && keys.find(key) != nullptr) {
      keys.fail(*keys.find(key), key, "goes with rate_hz: without it the law is continuous");
    }
  }
  if (auto complaint = out.complaint(n)) {
    // Of members of a Sampling, which are keys of this table.
    const std::string owner = "sampling.";
    complaint->erase(complaint->find(owner), owner.size());
    keys.fail(*complaint);
  }
  return out;
}

}  // namespace

ControlLoop read_control(TomlReader keys, const Robot& robot) {
  const auto law = keys.choice("law", law_words);
  if (!law) {
    keys.look_for_mistyped({"law"});
    keys.fail("must name its law: \"pd\", \"pid\", \"cascade\" or \"computed_torque\"");
  }
  const auto read = [&]() -> LawSection {
    switch (*law) {
      case Law::pid:
        return read_pid(keys, robot);
      case Law::cascade:
        return read_cascade(keys, robot);
      case Law::computed_torque:
        return read_computed_torque(keys, robot);
      case Law::pd:
        break;
    }
    return read_pd(keys, robot);
  };
  LawSection section = read();
  ControlLoop out;
  out.sampling = read_sampling(keys, robot.size());
  out.design_inertia = keys.choice("design_inertia",
                                   std::array<std::pair<std::string_view, ControlLoop::InertiaOver>, 2>{
                                       {{"reference", ControlLoop::InertiaOver::reference},
                                        {"all", ControlLoop::InertiaOver::all}}})
                           .value_or(out.design_inertia);
  out.assumed = keys.boolean("assumed").value_or(out.assumed);
  keys.finish();
  if (section.complaint) {
    keys.fail(*section.complaint);
  }
  out.control = std::move(section.control);
  out.omega_n = std::move(section.omega_n);
  return out;
}

}  // namespace detail

Vector ControlLoop::inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q_r) const {
  return design_inertia == InertiaOver::all ? rivid::design_inertia(model)
                                            : rivid::design_inertia(model, q_r);
}

}  // namespace rivid
