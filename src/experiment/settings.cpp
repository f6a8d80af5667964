#include <algorithm>
#include <utility>

#include "experiment/json_fields.hpp"
#include "experiment/sections.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/simulate/control_laws.hpp"

namespace rivid {

namespace {

using detail::Json;

// A path may hold any bytes; JSON is UTF-8.
std::string text_of(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

// What a page or a person reads in place of nothing: a word, or how the default is found.
std::string in_words(const Json& value, const FieldDetails& details, bool is_default) {
  const bool nothing =
      value.is_null() || (value.is_array() && value.empty()) || value == 0 || value == Json("");
  if (nothing && !details.word.empty()) {
    return "\"" + std::string(details.word) + "\"";
  }
  const bool named = nothing && is_default && !details.otherwise.empty() && details.otherwise != "required" &&
                     details.otherwise != "–";
  return named ? std::string(details.otherwise) : nothing && value != 0 ? "none" : text_of(value);
}

// A setting of all joints may come from the table of one, "robot.joints.joint_1.friction".
std::string origin_of(const std::string& key, const std::map<std::string, std::string>& origins) {
  if (const auto at = origins.find(key); at != origins.end()) {
    return at->second;
  }
  const std::string_view robot = "robot.";
  const auto of_joint = std::ranges::find_if(origins, [&](const auto& origin) {
    return key.starts_with(robot) && origin.first.starts_with("robot.joints.") &&
           origin.first.ends_with("." + key.substr(robot.size()));
  });
  return of_joint == origins.end() ? "default" : of_joint->second;
}

// Collects settings section by section.
class Collector {
 public:
  template <typename Fields, typename Record>
  void add(const std::string& section, const Fields& fields, const Record& record) {
    const Record other{};
    std::apply([&](const auto&... field) { (add_field(section, field, record, other), ...); }, fields);
  }
  template <Described Record>
  void add(const std::string& section, const Record& record) {
    add(section, Record::fields(), record);
  }
  template <typename Value>
  void add_value(const std::string& key, const Value& value) {
    const std::string text = text_of(detail::json_of(value));
    out_.push_back({.key = key, .value = text, .words = text, .unit = {}, .origin = {}});
  }
  // A record that is wanted or not.
  template <Described Record>
  void add_switched(const std::string& key, const std::optional<Record>& record) {
    if (record) {
      add(key, *record);
    } else {
      add_value(key, false);
    }
  }

  [[nodiscard]] std::vector<Setting> settings() && { return std::move(out_); }
  [[nodiscard]] std::vector<Setting> settings(const std::map<std::string, std::string>& origins) && {
    for (Setting& setting : out_) {
      setting.origin = origin_of(setting.key, origins);
    }
    return std::move(out_);
  }

 private:
  template <typename Access, typename Record>
  void add_field(const std::string& section, const Field<Access>& field, const Record& record,
                 const Record& other) {
    if constexpr (Described<KeyValue<Access, Record>> && std::is_member_object_pointer_v<Access>) {
      add(field.key.empty() ? section : section + "." + std::string(field.key), record.*field.member);
    } else if constexpr (is_shown<Access, Record>) {
      const Json value = detail::json_of(field, record);
      out_.push_back({.key = section + "." + std::string(field.key),
                      .value = text_of(value),
                      .words = in_words(value, field.details, value == detail::json_of(field, other)),
                      .unit = std::string(field.details.unit),
                      .origin = {}});
    }
  }

  std::vector<Setting> out_;
};

template <typename... Laws>
void add_law(Collector& out, const Control& control, const std::tuple<Laws...>*) {
  const auto add = [&]<typename Law>(const Law* law) {
    if (law != nullptr) {
      out.add_value("control.law", Law::word);
      out.add("control", detail::pole_fields<Law>(), *law);
      out.add("control", *law);
    }
  };
  (add(control.target<Laws>()), ...);
}

void add_control(Collector& out, const Control& control, const Sampling& sampling) {
  add_law(out, control, static_cast<const ControlLaws*>(nullptr));
  out.add("control", sampling);
}

void add_method(Collector& out, const Estimation& estimation) {
  out.add_value("method.name", name(estimation.method));
  out.add("method", estimation.covariance);
  out.add_switched("method.physical", estimation.physical);
  out.add_switched("method.essential", estimation.essential);
  if (estimation.robust) {
    out.add("method", *estimation.robust);
  } else {
    out.add_value("method.robust", "off");
  }
  if (const Iv* const iv = std::get_if<Iv>(&estimation.method)) {
    out.add("method", *iv);
    out.add("method.simulation", SimulationOptions::integration(), iv->simulation);
  }
}

void add_estimation(Collector& out, const Estimation& estimation) {
  SignalOptions signal = estimation.signal;
  signal.rows = signal.exact_rows() ? RowScheme::exact : RowScheme::paper;
  out.add("signal", signal);
  add_method(out, estimation);
}

void add_robot(Collector& out, const Experiment& experiment) {
  const Robot& robot = experiment.robot;
  out.add_value(experiment.robot_file.extension() == ".csv" ? "robot.mdh" : "robot.urdf",
                experiment.robot_file);
  out.add("robot", detail::robot_keys, robot);
  const auto add_each = [&](const auto& field) {
    Json values = Json::array();
    for (const Joint& joint : robot.joints) {
      values.push_back(detail::json_of(field, joint));
    }
    out.add_value("robot." + std::string(field.key), values);
  };
  std::apply([&](const auto&... field) { (add_each(field), ...); }, Joint::fields());
}

void add_log(Collector& out, const std::string& section, const LogSource& source) {
  if (!source.files.empty()) {
    out.add(section, source);
  }
}

void add_simulation(Collector& out, const Experiment& experiment) {
  if (experiment.reference) {
    std::visit(
        [&](const auto& motion) {
          out.add_value("reference.type", motion.word);
          out.add("reference", motion);
        },
        experiment.reference->motion);
    out.add_value("reference.file", experiment.reference->file);
  }
  if (experiment.simulation) {
    out.add("simulation", *experiment.simulation);
  }
}

}  // namespace

std::vector<Setting> settings(const Estimation& estimation) {
  Collector out;
  add_estimation(out, estimation);
  if (const Iv* const iv = std::get_if<Iv>(&estimation.method)) {
    add_control(out, iv->control, iv->sampling);
  }
  return std::move(out).settings();
}

std::vector<Setting> settings(const Experiment& experiment, Use use) {
  Collector collector;
  add_robot(collector, experiment);
  add_log(collector, "log", experiment.log);
  const bool simulated = use == Use::simulation;
  if (!simulated) {
    add_log(collector, "validation", experiment.validation);
    add_estimation(collector, experiment.estimation);
    if (experiment.gains) {
      collector.add("method.gains", *experiment.gains);
      collector.add_value("method.gains.loaded", experiment.loaded.files);
    } else {
      collector.add_value("method.gains", "known");
    }
  }
  if (experiment.control && (simulated || std::holds_alternative<Iv>(experiment.estimation.method))) {
    add_control(collector, experiment.control->control, experiment.control->sampling);
    collector.add("control", *experiment.control);
  }
  if (simulated) {
    add_simulation(collector, experiment);
  }
  return std::move(collector).settings(experiment.origins);
}

std::vector<Setting> settings(const ExcitationPlan& plan) {
  Collector collector;
  add_robot(collector, plan.experiment);
  collector.add("excitation", plan);
  return std::move(collector).settings(plan.experiment.origins);
}

}  // namespace rivid
