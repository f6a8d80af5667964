#include <array>
#include <memory>
#include <string>
#include <utility>

#include "experiment/sections.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

namespace detail {

namespace {

// A law by its keys. Its faults are reported when all keys are known: a mistyped one comes first.
template <typename Law>
std::optional<std::string> read_law(TomlReader& keys, ControlLoop& out) {
  refuse_floating(keys);
  const Robot& robot = keys.robot();
  Law law;
  keys.read(pole_fields<Law>(), law);
  keys.read(law);
  if (law.omega_n.size() > 0 && law.zeta.size() == 0) {
    law.zeta = Vector::Ones(robot.size());
  }
  if constexpr (requires { law.model; }) {
    if (keys.get<ControllerModel>("model") == ControllerModel::a_priori) {
      law.model = std::make_shared<const DynamicModel>(robot, robot.chi_st());
    }
  }
  const std::optional<std::string> complaint = law.complaint(robot);
  out.omega_n = law.omega_n;
  out.control = std::move(law);
  return complaint;
}

// The law of a word; nothing where there is none.
template <typename... Laws>
std::optional<std::string> read_law_of(const std::tuple<Laws...>*, std::size_t chosen, TomlReader& keys,
                                       ControlLoop& out) {
  std::optional<std::string> complaint;
  std::size_t i = 0;
  static_cast<void>(((i++ == chosen ? (complaint = read_law<Laws>(keys, out), true) : false) || ...));
  return complaint;
}

template <typename... Laws>
constexpr std::array<std::string_view, sizeof...(Laws)> words_of(const std::tuple<Laws...>*) {
  return {Laws::word...};
}

constexpr const ControlLaws* laws = nullptr;
constexpr std::array law_words = words_of(laws);

std::vector<double> read_velocity_filter(TomlReader& keys, std::vector<double> otherwise) {
  const toml::node* const node = keys.find("velocity_filter");
  if (node == nullptr) {
    return otherwise;
  }
  if (!node->is_string()) {
    return keys.as<std::vector<double>>(*node, "velocity_filter");
  }
  switch (keys.as<VelocityFilter>(*node, "velocity_filter")) {
    case VelocityFilter::central:
      return {0.5, 0.0, -0.5};
    case VelocityFilter::none:
      return {};
    default:
      return {1.0, -1.0};
  }
}

Sampling read_sampling(TomlReader& keys) {
  Sampling out;
  const auto rate_hz = keys.get<double>("rate_hz", rate_range, "Hz");
  if (rate_hz) {
    out.period = 1.0 / *rate_hz;
  }
  keys.read(out);
  out.velocity_filter = read_velocity_filter(keys, out.velocity_filter);
  if (!rate_hz) {
    keys.refuse_keys({"delay", "delay_sigma", "velocity_filter", "reference_lead"},
                     "goes with rate_hz: without it the law is continuous");
  }
  if (auto complaint = out.complaint(keys.joints())) {
    // Of members of a Sampling, which are keys of this table.
    const std::string owner = "sampling.";
    complaint->erase(complaint->find(owner), owner.size());
    keys.fail(*complaint);
  }
  return out;
}

}  // namespace

ControlLoop read_control(TomlReader keys) {
  const auto law = keys.word("law", law_words);
  if (!law) {
    keys.look_for_mistyped({"law"});
    keys.fail("must name its law: " +
              quoted_list(std::vector<std::string>(law_words.begin(), law_words.end())));
  }
  ControlLoop out;
  const std::optional<std::string> complaint = read_law_of(laws, *law, keys, out);
  out.sampling = read_sampling(keys);
  keys.read(out);
  keys.finish();
  keys.refuse(complaint);
  return out;
}

}  // namespace detail

Vector ControlLoop::inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q_r) const {
  return design_inertia == InertiaOver::all ? rivid::design_inertia(model)
                                            : rivid::design_inertia(model, q_r);
}

}  // namespace rivid
