#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "experiment/parameter_file.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

// The names of a kind of parameters, against those of a file.
struct Kind {
  std::string_view title;
  std::vector<std::string> names;
  std::vector<std::string> missing;
  std::vector<std::string> unknown;

  Kind(std::string_view kind, std::vector<std::string> all, const std::map<std::string, double>& values)
      : title(kind), names(std::move(all)) {
    std::ranges::copy_if(names, std::back_inserter(missing),
                         [&](const std::string& name) { return !values.contains(name); });
    for (const auto& [name, value] : values) {
      if (std::ranges::find(names, name) == names.end()) {
        unknown.push_back(name);
      }
    }
  }

  [[nodiscard]] std::size_t differences() const { return missing.size() + unknown.size(); }
};

}  // namespace

void NamedValues::add(const std::string& name, double value) {
  if (!std::isfinite(value)) {
    throw InputError(where_ + ": " + in_quotes(name) + " is " + number(value) + ", must be finite");
  }
  if (!values_.emplace(name, value).second) {
    throw InputError(where_ + ": " + in_quotes(name) + " is there twice");
  }
}

void NamedValues::add(const std::string& name, const nlohmann::json& node) {
  const nlohmann::json& value = node.is_object() && node.contains("value") ? node["value"] : node;
  if (!value.is_number()) {
    throw InputError(where_ + ": the value of " + in_quotes(name) + " is " + value.dump() +
                     ", must be a number" + (value.is_null() ? "; null is a parameter not determined" : ""));
  }
  add(name, value.get<double>());
}

Vector NamedValues::standard(const BaseParameters& base) const {
  std::vector<std::string> base_names;
  for (const BaseParameter& p : base.parameters) {
    base_names.push_back(p.name);
  }
  std::vector<std::string> standard_names;
  for (const StandardParameter& p : base.standard) {
    standard_names.push_back(p.name());
  }
  const Kind of_base("base", std::move(base_names), values_);
  const Kind of_standard("standard", std::move(standard_names), values_);
  const bool is_base = of_base.differences() <= of_standard.differences();
  const Kind& kind = is_base ? of_base : of_standard;
  if (!kind.unknown.empty()) {
    const std::string& name = kind.unknown.front();
    throw InputError(where_ + ": " + in_quotes(name) + " is none of the robot's " +
                     std::to_string(kind.names.size()) + " " + std::string(kind.title) + " parameters, " +
                     listed(kind.names) + did_you_mean(name, kind.names));
  }
  if (!kind.missing.empty()) {
    throw InputError(where_ + ": " + listed(kind.missing) + (kind.missing.size() == 1 ? " is" : " are") +
                     " missing; a parameter file names all of the robot's " +
                     std::to_string(of_base.names.size()) + " base or all of its " +
                     std::to_string(of_standard.names.size()) + " standard parameters");
  }
  Vector chosen(static_cast<Index>(kind.names.size()));
  for (std::size_t i = 0; i < kind.names.size(); ++i) {
    chosen[static_cast<Index>(i)] = values_.at(kind.names[i]);
  }
  return is_base ? base.to_standard(chosen) : chosen;
}

}  // namespace detail

}  // namespace rivid
