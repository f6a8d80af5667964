#include <array>
#include <cmath>

#include "experiment/identification_sections.hpp"

namespace rivid::detail {

namespace {

// [least, most] in kg.
std::array<double, 2> read_mass_bounds(TomlReader& keys, std::string_view key) {
  const auto bounds = keys.numbers(key).value_or(std::vector<double>{});
  if (bounds.size() != 2) {
    keys.fail(*keys.find(key), key, "must be [least, most] in kg");
  }
  return {bounds[0], bounds[1]};
}

Physical read_physical(TomlReader keys, const Robot& robot) {
  Physical out;
  out.prior = keys.choice("prior",
                          std::array<std::pair<std::string_view, Physical::Prior>, 2>{
                              {{"log_det", Physical::Prior::log_det}, {"ridge", Physical::Prior::ridge}}})
                  .value_or(out.prior);
  if (const auto weight = keys.number("weight")) {
    out.weight = *weight;
    out.weight_may_fall = false;
  }
  if (auto masses = keys.section("masses")) {
    for (const auto& [link, node] : masses->table()) {
      const std::array<double, 2> bounds = read_mass_bounds(*masses, link.str());
      out.masses.push_back({.link = std::string(link.str()), .least = bounds[0], .most = bounds[1]});
    }
  }
  if (keys.find("total_mass") != nullptr) {
    out.total_mass = read_mass_bounds(keys, "total_mass");
  }
  keys.finish();
  if (const auto complaint = out.complaint(robot)) {
    keys.fail(*complaint);
  }
  return out;
}

// `physical`, a switch or a table of options.
std::optional<Physical> read_whether_physical(TomlReader& keys, const Robot& robot) {
  const toml::node* const node = keys.find("physical");
  if (node == nullptr) {
    return std::nullopt;
  }
  if (node->is_table()) {
    return read_physical(TomlReader(*node->as_table(), keys.file(), keys.path() + ".physical"), robot);
  }
  if (!node->is_boolean()) {
    keys.fail(*node, "physical", "must be true or false, or a table of options");
  }
  return keys.as_boolean(*node, "physical") ? std::optional<Physical>(Physical{}) : std::nullopt;
}

// `essential`, a switch or a table of options.
std::optional<Essential> read_whether_essential(TomlReader& keys) {
  const toml::node* const node = keys.find("essential");
  if (node == nullptr) {
    return std::nullopt;
  }
  if (node->is_table()) {
    TomlReader options(*node->as_table(), keys.file(), keys.path() + ".essential");
    Essential out;
    out.significance = options.number("significance").value_or(out.significance);
    options.finish();
    if (const auto complaint = out.complaint()) {
      options.fail(*complaint);
    }
    return out;
  }
  if (!node->is_boolean()) {
    keys.fail(*node, "essential", "must be true or false, or a table of options");
  }
  return keys.as_boolean(*node, "essential") ? std::optional<Essential>(Essential{}) : std::nullopt;
}

// `robust`, the name of a loss or "off", and its `robust_tuning`.
std::optional<Robust> read_whether_robust(TomlReader& keys) {
  using Kind = std::optional<RobustKind>;
  const Kind kind =
      keys.choice(
              "robust",
              std::array<std::pair<std::string_view, Kind>, 3>{
                  {{"huber", RobustKind::huber}, {"bisquare", RobustKind::bisquare}, {"off", std::nullopt}}})
          .value_or(std::nullopt);
  const auto tuning = keys.number("robust_tuning");
  if (tuning && keys.find("robust") == nullptr) {
    keys.fail(*keys.find("robust_tuning"), "robust_tuning", "needs robust = \"huber\" or \"bisquare\"");
  }
  if (!kind) {
    return std::nullopt;
  }
  const Robust out = {.kind = *kind, .tuning = tuning};
  if (out.complaint()) {
    keys.fail(*keys.find("robust_tuning"), "robust_tuning", "must be positive");
  }
  return out;
}

// `prefilter`, a switch or the order of the noise models.
void read_prefilter(TomlReader& keys, Iv& iv) {
  const toml::node* const node = keys.find("prefilter");
  if (node == nullptr) {
    return;
  }
  if (node->is_boolean()) {
    iv.prefilter = keys.as_boolean(*node, "prefilter");
    return;
  }
  const auto order = node->value_exact<std::int64_t>();
  if (!order || *order < 1 || *order > Iv::most_prefilter_order) {
    keys.fail(*node, "prefilter",
              (order ? "is " + std::to_string(*order) + ", " : "") +
                  "must be true, false or an order from 1 to " + std::to_string(Iv::most_prefilter_order));
  }
  iv.prefilter = true;
  iv.prefilter_order = static_cast<int>(*order);
}

}  // namespace

void read_method(TomlReader keys, Experiment& out) {
  const auto positive = [&](const char* key, double& value) {
    if (const auto given = keys.number(key)) {
      if (!std::isfinite(*given) || *given <= 0.0) {
        keys.fail(*keys.find(key), key, "must be positive");
      }
      value = *given;
    }
  };
  using Word = std::pair<std::string_view, std::string_view>;
  const auto method =
      keys.choice("name", std::array<Word, 3>{{{"ols", "ols"}, {"wls", "wls"}, {"iv", "iv"}}});
  out.estimation.covariance.kind = keys.choice("covariance",
                                               std::array<std::pair<std::string_view, CovarianceKind>, 3>{
                                                   {{"automatic", CovarianceKind::automatic},
                                                    {"classical", CovarianceKind::classical},
                                                    {"hac", CovarianceKind::hac}}})
                                       .value_or(out.estimation.covariance.kind);
  positive("covariance_lag", out.estimation.covariance.lag);
  out.estimation.physical = read_whether_physical(keys, out.robot);
  out.estimation.essential = read_whether_essential(keys);
  out.estimation.robust = read_whether_robust(keys);
  Iv& iv = out.iv;
  iv.start = keys.choice("start",
                         std::array<std::pair<std::string_view, Iv::Start>, 3>{
                             {{"regular", Iv::Start::regular},
                              {"a_priori", Iv::Start::a_priori},
                              {"least_squares", Iv::Start::least_squares}}})
                 .value_or(iv.start);
  iv.signs =
      keys.choice(
              "signs",
              std::array<std::pair<std::string_view, Iv::Signs>, 3>{{{"automatic", Iv::Signs::automatic},
                                                                     {"measured", Iv::Signs::measured},
                                                                     {"simulated", Iv::Signs::simulated}}})
          .value_or(iv.signs);
  iv.weights = keys.choice("weights",
                           std::array<std::pair<std::string_view, Iv::Weights>, 2>{
                               {{"none", Iv::Weights::none}, {"by_joint", Iv::Weights::by_joint}}})
                   .value_or(iv.weights);
  iv.follows = keys.choice("follows",
                           std::array<std::pair<std::string_view, Iv::Follows>, 2>{
                               {{"reference", Iv::Follows::reference}, {"measured", Iv::Follows::measured}}})
                   .value_or(iv.follows);
  positive("reference_cutoff_hz", iv.reference_cutoff_hz);
  iv.start_on_reference =
      keys.choice("initial_state", std::array<std::pair<std::string_view, bool>, 2>{{{"measured", false},
                                                                                     {"reference", true}}})
          .value_or(iv.start_on_reference);
  if (const auto given = keys.number("transient")) {
    if (!std::isfinite(*given) || *given < 0.0) {
      keys.fail(*keys.find("transient"), "transient", "must not be negative");
    }
    iv.transient = *given;
  }
  read_prefilter(keys, iv);
  positive("tolerance", iv.tolerance);
  positive("parameter_tolerance", iv.parameter_tolerance);
  iv.max_iterations = keys.count("max_iterations").value_or(iv.max_iterations);
  keys.finish();
  out.take_method(method.value_or(name(out.estimation.method)));
}

}  // namespace rivid::detail
