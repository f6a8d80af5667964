#include "rivid/experiment/result_file.hpp"

#include <nlohmann/json.hpp>

#include "experiment/json_node.hpp"
#include "experiment/named_values.hpp"
#include "experiment/result_robot.hpp"
#include "experiment/text_file.hpp"
#include "identify/infer/parameter_set.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

using detail::JsonNode;
using detail::NamedValues;

// Of docs/result.md; raised where a member is removed, renamed or changes its meaning.
constexpr double newest_format = 1.0;

nlohmann::json parsed(const std::filesystem::path& path) {
  try {
    return nlohmann::json::parse(detail::file_text(path, "the result"));
  } catch (const nlohmann::json::exception& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

void expect_result(const JsonNode& file, const IdentifiedModelOptions& options) {
  if (!file.has("format") || !file.has("method") || !file.has("status")) {
    file.fail("is no result.json of rivid_identify: it has no format, method and status");
  }
  if (const double format = file.at("format").number(); format > newest_format) {
    file.at("format").fail("is " + number(format) + ", this rivid knows " + number(newest_format) +
                           "; take the rivid that wrote the file");
  }
  std::vector<std::string> reasons;
  for (const JsonNode& reason : file.at("reasons").list()) {
    reasons.push_back(reason.text());
  }
  detail::expect_identified(file.file(), file.at("status").text(), reasons, options);
}

// chi_st, (N_s).
Vector values(const JsonNode& file, const BaseParameters& base, const IdentifiedModelOptions& options) {
  NamedValues out(file.file());
  const auto add = [&](const JsonNode& parameters) {
    for (const JsonNode& p : parameters.list()) {
      out.add(p.at("name").text(), p.at("value").json());
    }
  };
  if (detail::chosen_set(file.file(), file.has("physical"), options) == ParameterSet::estimate) {
    add(file.at("parameters"));
  } else {
    for (const JsonNode& link : file.at("physical").at("links").list()) {
      add(link.at("parameters"));
    }
  }
  return out.standard(base);
}

DynamicModel model(const std::filesystem::path& path, const Robot* expected,
                   const IdentifiedModelOptions& options) {
  const nlohmann::json content = parsed(path);
  const JsonNode file(content, path.string());
  expect_result(file, options);
  const Robot robot = detail::result_robot(file.at("robot"));
  if (expected != nullptr) {
    detail::expect_same_geometry(file.at("robot"), robot, *expected);
  }
  return {robot, values(file, base_parameters(robot), options)};
}

}  // namespace

DynamicModel read_identified_model(const std::filesystem::path& path, const IdentifiedModelOptions& options) {
  return model(path, nullptr, options);
}

DynamicModel read_identified_model(const std::filesystem::path& path, const Robot& robot,
                                   const IdentifiedModelOptions& options) {
  return model(path, &robot, options);
}

}  // namespace rivid
