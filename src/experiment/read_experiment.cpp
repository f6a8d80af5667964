#include <algorithm>
#include <cmath>

#include "experiment/column_reader.hpp"
#include "experiment/identification_sections.hpp"
#include "experiment/mdh_file.hpp"
#include "experiment/simulation_sections.hpp"
#include "experiment/text_file.hpp"
#include "experiment/toml_reader.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/model/urdf.hpp"

namespace rivid {

namespace {

using detail::file_at;
using detail::file_named;
using detail::read_column;
using detail::read_columns;
using detail::read_matrix;
using detail::read_reference_columns;
using detail::TomlReader;
using detail::Units;
using Path = std::filesystem::path;

constexpr std::array<std::pair<std::string_view, Friction>, 5> friction_words = {
    {{"none", Friction::none},
     {"viscous", Friction::viscous},
     {"coulomb", Friction::coulomb},
     {"symmetric", Friction::symmetric},
     {"asymmetric", Friction::asymmetric}}};
constexpr std::array<std::pair<std::string_view, Outside>, 2> outside_words = {
    {{"refuse", Outside::refuse}, {"hold", Outside::hold}}};

// A value for each joint: one number for all, or a list.
template <typename Value, typename Read>
void for_each_joint(TomlReader& keys, std::string_view key, Robot& robot, const Read& read,
                    Value Joint::* member) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return;
  }
  const toml::array* const list = node->as_array();
  if (list != nullptr && static_cast<Index>(list->size()) != robot.size()) {
    keys.fail(*node, key,
              "has " + std::to_string(list->size()) + " entries, must have one for each of the " +
                  std::to_string(robot.size()) + " joints, or be a single value for all");
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    robot.joints[j].*member = read(list != nullptr ? *list->get(j) : *node);
  }
}

void read_joint_options(TomlReader& keys, Robot& robot) {
  for_each_joint(
      keys, "friction", robot,
      [&](const toml::node& n) { return keys.as_choice(n, "friction", friction_words); }, &Joint::friction);
  for_each_joint(
      keys, "rotor_inertia", robot, [&](const toml::node& n) { return keys.as_boolean(n, "rotor_inertia"); },
      &Joint::rotor_inertia);
  const auto numbers = [&](std::string_view key, double Joint::* member) {
    for_each_joint(keys, key, robot, [&](const toml::node& n) { return keys.as_number(n, key); }, member);
  };
  numbers("sign_speed", &Joint::sign_speed);
  numbers("drive_gain", &Joint::drive_gain);
  numbers("gear_ratio", &Joint::gear_ratio);
}

void read_joint(TomlReader keys, Joint& joint) {
  joint.friction = keys.choice("friction", friction_words).value_or(joint.friction);
  joint.rotor_inertia = keys.boolean("rotor_inertia").value_or(joint.rotor_inertia);
  joint.sign_speed = keys.number("sign_speed").value_or(joint.sign_speed);
  joint.drive_gain = keys.number("drive_gain").value_or(joint.drive_gain);
  joint.gear_ratio = keys.number("gear_ratio").value_or(joint.gear_ratio);
  joint.Ia = keys.number("Ia").value_or(joint.Ia);
  joint.Fv = keys.number("Fv").value_or(joint.Fv);
  joint.Fc = keys.number("Fc").value_or(joint.Fc);
  keys.finish();
}

std::vector<std::string> joint_names(const Robot& robot) {
  std::vector<std::string> out;
  out.reserve(robot.joints.size());
  for (const Joint& joint : robot.joints) {
    out.push_back(joint.name);
  }
  return out;
}

// Joint of that name.
Index joint_index(const TomlReader& keys, const toml::node& node, std::string_view key,
                  const std::string& name, const Robot& robot) {
  const std::vector<std::string> names = joint_names(robot);
  const auto at = std::ranges::find(names, name);
  if (at == names.end()) {
    keys.fail(node, key,
              "is no joint of robot \"" + robot.name + "\", which has " + quoted_list(names) +
                  did_you_mean(name, names));
  }
  return at - names.begin();
}

Coupling read_coupling(TomlReader keys, const Robot& robot) {
  const auto joint = [&](const toml::node& node, std::string_view key) {
    return static_cast<int>(joint_index(keys, node, key, keys.as_text(node, key), robot));
  };
  Coupling out;
  const toml::node* const motor = keys.find("motor");
  const toml::node* const joints = keys.find("joints");
  if (motor == nullptr || joints == nullptr) {
    keys.fail("must name motor and joints: { motor = \"joint_6\", joints = [\"joint_5\"] }");
  }
  out.motor = joint(*motor, "motor");
  if (const toml::array* const list = joints->as_array()) {
    for (const toml::node& item : *list) {
      out.joints.push_back(joint(item, "joints"));
    }
  } else {
    out.joints.push_back(joint(*joints, "joints"));
  }
  out.ratios = keys.numbers("ratios").value_or(std::vector<double>(out.joints.size(), 1.0));
  out.inertia = keys.choice("inertia",
                            std::array<std::pair<std::string_view, Coupling::Inertia>, 3>{
                                {{"none", Coupling::Inertia::none},
                                 {"free", Coupling::Inertia::free},
                                 {"tied", Coupling::Inertia::tied}}})
                    .value_or(out.inertia);
  out.viscous = keys.boolean("viscous").value_or(out.viscous);
  out.coulomb = keys.choice("coulomb",
                            std::array<std::pair<std::string_view, Coupling::Coulomb>, 3>{
                                {{"none", Coupling::Coulomb::none},
                                 {"sum", Coupling::Coulomb::sum},
                                 {"single", Coupling::Coulomb::single}}})
                    .value_or(out.coulomb);
  out.terms = keys.choice("terms",
                          std::array<std::pair<std::string_view, Coupling::Terms>, 2>{
                              {{"cross", Coupling::Terms::cross}, {"all", Coupling::Terms::all}}})
                  .value_or(out.terms);
  out.Iam = keys.number("Iam").value_or(out.Iam);
  out.Fvm = keys.number("Fvm").value_or(out.Fvm);
  out.Fcm = keys.number("Fcm").value_or(out.Fcm);
  keys.finish();
  return out;
}

void read_couplings(TomlReader& keys, Robot& robot) {
  const toml::node* const node = keys.find("coupling");
  if (node == nullptr) {
    return;
  }
  const toml::array* const list = node->as_array();
  if (list == nullptr) {
    keys.fail(*node, "coupling", "must be a list of tables: [[robot.coupling]] before each");
  }
  for (const toml::node& item : *list) {
    robot.couplings.push_back(
        read_coupling(TomlReader(keys.as_table(item, "coupling"), keys.file(), "robot.coupling"), robot));
  }
}

Robot read_robot(TomlReader keys, const Path& folder, Path& robot_file) {
  UrdfOptions options;
  options.base = keys.text("base").value_or("");
  options.tip = keys.text("tip").value_or("");
  if (const auto gravity = keys.numbers("gravity")) {
    if (gravity->size() != 3) {
      keys.fail(*keys.find("gravity"), "gravity",
                "has " + std::to_string(gravity->size()) +
                    " entries, must have three: the acceleration of free fall in the base frame, in m/s²");
    }
    options.gravity = Eigen::Vector3d((*gravity)[0], (*gravity)[1], (*gravity)[2]);
  }
  const auto urdf = file_named(keys, "urdf", folder);
  const auto mdh = file_named(keys, "mdh", folder);
  if (urdf.has_value() == mdh.has_value()) {
    keys.look_for_mistyped({"urdf", "mdh"});
    keys.fail(urdf ? "names both urdf and mdh, must name one" : "names no robot, must name urdf or mdh");
  }
  for (const char* const link : {"base", "tip"}) {
    if (mdh && keys.find(link) != nullptr) {
      keys.fail(*keys.find(link), link,
                "goes with urdf: a table describes the chain from its base to its tip");
    }
  }
  robot_file = urdf.value_or(mdh.value_or(folder));
  Robot robot = urdf ? read_urdf(robot_file, options) : detail::read_mdh(robot_file, options.gravity);
  robot.base_tolerance = keys.number("base_tolerance").value_or(robot.base_tolerance);
  read_joint_options(keys, robot);
  if (auto joints = keys.section("joints")) {
    for (const auto& [key, node] : joints->table()) {
      const std::string name(key.str());
      const Index j = joint_index(*joints, node, name, name, robot);
      if (auto joint = joints->section(name)) {
        read_joint(std::move(*joint), robot.joints[static_cast<std::size_t>(j)]);
      }
    }
  }
  read_couplings(keys, robot);
  const std::string n = std::to_string(robot.size());
  if (const auto gears =
          read_matrix(keys, "gear_matrix", robot.size(), robot.size(),
                      n + " lists of " + n + " numbers: one list a motor, one number a joint")) {
    robot.gear_matrix = *gears;
  }
  keys.finish();
  if (const auto complaint = robot.complaint()) {
    keys.fail(*complaint);
  }
  return robot;
}

LogOptions read_log_columns(TomlReader& keys, LogOptions out, Index n) {
  Units units(keys);
  out.position = read_columns(keys, "position", units, out.position, n);
  out.velocity = read_columns(keys, "velocity", units, out.velocity, n);
  out.torque = read_columns(keys, "torque", units, out.torque, n);
  out.control = read_columns(keys, "control", units, out.control, n);
  out.reference = read_columns(keys, "reference", units, out.reference, n);
  out.reference_velocity = read_columns(keys, "reference_velocity", units, out.reference_velocity, n);
  if (const toml::node* const time = keys.find("time")) {
    out.time = read_column(keys, *time, "time", units("time"));
  }
  units.finish(keys);
  if (const std::optional<double> rate_hz = keys.number("rate_hz")) {
    out.rate_hz = rate_hz;
  }
  out.table.separator =
      keys.choice("separator",
                  std::array<std::pair<std::string_view, Separator>, 5>{{{"auto", Separator::automatic},
                                                                         {",", Separator::comma},
                                                                         {";", Separator::semicolon},
                                                                         {"tab", Separator::tab},
                                                                         {"space", Separator::spaces}}})
          .value_or(out.table.separator);
  out.table.decimal =
      keys.choice("decimal",
                  std::array<std::pair<std::string_view, Decimal>, 3>{
                      {{"auto", Decimal::automatic}, {".", Decimal::point}, {",", Decimal::comma}}})
          .value_or(out.table.decimal);
  if (const auto header = keys.boolean("header")) {
    out.table.header = *header ? Header::present : Header::absent;
  }
  return out;
}

LogSource::Reference read_reference_file(TomlReader keys, const Path& folder, const LogOptions& columns,
                                         Index n) {
  LogSource::Reference out;
  const auto file = file_named(keys, "file", folder);
  if (!file) {
    keys.look_for_mistyped({"file"});
    keys.fail("must name its file");
  }
  out.file = *file;
  out.columns.reference = columns.reference;
  out.columns.reference_velocity = columns.reference_velocity;
  out.columns.table = columns.table;
  out.columns = read_reference_columns(keys, std::move(out.columns), n, true);
  out.delay = keys.number("delay").value_or(0.0);
  out.outside = keys.choice("outside", outside_words).value_or(Outside::refuse);
  keys.finish();
  return out;
}

std::vector<LogSource::Subtraction> read_subtractions(TomlReader& keys, const Path& folder,
                                                      const Robot& robot) {
  std::vector<LogSource::Subtraction> out;
  const toml::node* const node = keys.find("subtract");
  if (node == nullptr) {
    return out;
  }
  const toml::array* const list = node->as_array();
  if (list == nullptr) {
    keys.fail(*node, "subtract",
              "must be a list of tables: [{ joint = \"joint_2\", table = \"counterbalance.csv\" }]");
  }
  for (const toml::node& item : *list) {
    TomlReader inner(keys.as_table(item, "subtract"), keys.file(), "log.subtract");
    LogSource::Subtraction s;
    const auto joint = inner.text("joint");
    const auto table = file_named(inner, "table", folder);
    if (!joint || !table) {
      inner.look_for_mistyped({"joint", "table"});
      inner.fail("must name joint and table");
    }
    s.joint = joint_index(inner, *inner.find("joint"), "joint", *joint, robot);
    s.table = *table;
    s.columns = inner.texts("columns").value_or(std::vector<std::string>{});
    s.outside = inner.choice("outside", outside_words).value_or(Outside::refuse);
    inner.finish();
    out.push_back(std::move(s));
  }
  return out;
}

// [log], or [validation] with [log] for what it does not say itself.
LogSource read_log_source(TomlReader keys, LogSource out, const Path& folder, const Robot& robot) {
  out.files.clear();
  const toml::node* const files = keys.find("files");
  if (files == nullptr) {
    keys.look_for_mistyped({"files"});
    keys.fail("must name at least one file in files");
  }
  if (const toml::array* const list = files->as_array()) {
    for (const toml::node& file : *list) {
      out.files.push_back(file_at(keys, file, "files", folder));
    }
  } else {
    out.files.push_back(file_at(keys, *files, "files", folder));
  }
  if (out.files.empty()) {
    keys.fail(*files, "files", "must name at least one file");
  }
  out.columns = read_log_columns(keys, std::move(out.columns), robot.size());
  // What the file names is read, not what else happens to be in the log under a default name.
  if (!out.columns.torque.empty() || !out.columns.control.empty()) {
    out.columns.default_names = false;
  }
  out.side = keys.choice("side",
                         std::array<std::pair<std::string_view, LogSource::Side>, 2>{
                             {{"joint", LogSource::Side::joint}, {"motor", LogSource::Side::motor}}})
                 .value_or(out.side);
  out.irregular =
      keys.choice("irregular",
                  std::array<std::pair<std::string_view, Irregular>, 3>{{{"refuse", Irregular::refuse},
                                                                         {"resample", Irregular::resample},
                                                                         {"ignore", Irregular::ignore}}})
          .value_or(out.irregular);
  if (const std::optional<double> rate_hz = keys.number("resample_hz")) {
    if (*rate_hz <= 0.0) {
      keys.fail(*keys.find("resample_hz"), "resample_hz", "is " + number(*rate_hz) + " Hz, must be positive");
    }
    out.resample.rate_hz = rate_hz;
    out.irregular = Irregular::resample;
  }
  out.resample.max_gap = keys.number("max_gap").value_or(out.resample.max_gap);
  out.torque_lag = keys.number("torque_lag").value_or(out.torque_lag);
  if (keys.find("subtract") != nullptr) {
    out.subtract = read_subtractions(keys, folder, robot);
  }
  if (auto reference = keys.section("reference_file")) {
    out.reference = read_reference_file(*reference, folder, out.columns, robot.size());
  }
  keys.finish();
  for (const auto& complaint : {out.columns.complaint(), out.resample.complaint()}) {
    if (complaint) {
      keys.fail(*complaint);
    }
  }
  return out;
}

// A frequency, or "off" for no filter.
std::optional<double> cutoff(TomlReader& keys, std::string_view key) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return std::nullopt;
  }
  if (node->is_string() && keys.as_text(*node, key) == "off") {
    return 0.0;
  }
  const double value = node->is_string() ? -1.0 : keys.as_number(*node, key);
  if (value <= 0.0) {
    keys.fail(*node, key, "must be a frequency in Hz, or \"off\" for no filter");
  }
  return value;
}

}  // namespace

SignalOptions detail::read_signal(TomlReader keys, Index n) {
  SignalOptions out;
  const auto cutoff_hz = cutoff(keys, "cutoff_hz");
  if (!cutoff_hz) {
    keys.look_for_mistyped({"cutoff_hz"});
    keys.fail(
        "must say cutoff_hz, the cut-off of the position filter in Hz: some ten times the highest frequency "
        "of the "
        "motion, or \"off\" for no filter");
  }
  out.rows = keys.choice("rows",
                         std::array<std::pair<std::string_view, RowScheme>, 2>{
                             {{"paper", RowScheme::paper}, {"exact", RowScheme::exact}}})
                 .value_or(out.rows);
  out.torque_held = keys.boolean("torque_held").value_or(out.torque_held);
  out.cutoff_hz = *cutoff_hz;
  out.torque_cutoff_hz = cutoff(keys, "torque_cutoff_hz").value_or(0.0);
  out.order = keys.count("order").value_or(out.order);
  out.torque_order = keys.count("torque_order").value_or(out.order);
  out.decimation = keys.counts("decimation").value_or(std::vector<int>{});
  const toml::node* const trim = keys.find("trim");
  if (trim != nullptr && !(trim->is_string() && keys.as_text(*trim, "trim") == "auto")) {
    const auto ends = keys.integers("trim").value_or(std::vector<std::int64_t>{});
    if (ends.empty() || ends.size() > 2) {
      keys.fail(*trim, "trim", "must be one number of samples for both ends, [begin, end], or \"auto\"");
    }
    out.trim = {ends.front(), ends.back()};
  }
  if (const auto threshold = keys.numbers("velocity_threshold")) {
    const bool for_all = !keys.find("velocity_threshold")->is_array();
    out.velocity_threshold =
        for_all ? std::vector<double>(static_cast<std::size_t>(n), threshold->front()) : *threshold;
  }
  if (const auto window = keys.numbers("window")) {
    if (window->size() != 2) {
      keys.fail(*keys.find("window"), "window", "must be [begin, end] in seconds");
    }
    out.window = {(*window)[0], (*window)[1]};
  }
  out.convention = keys.choice("convention",
                               std::array<std::pair<std::string_view, Convention>, 2>{
                                   {{"standard", Convention::standard}, {"matlab", Convention::matlab}}})
                       .value_or(out.convention);
  keys.finish();
  if (const auto complaint = out.complaint(n)) {
    keys.fail(*complaint);
  }
  return out;
}

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

void detail::read_method(TomlReader keys, Experiment& out) {
  const auto positive = [&](const char* key, double& value) {
    if (const auto given = keys.number(key)) {
      if (!std::isfinite(*given) || *given <= 0.0) {
        keys.fail(*keys.find(key), key, "must be positive");
      }
      value = *given;
    }
  };
  out.method = keys.choice("name",
                           std::array<std::pair<std::string_view, Method>, 3>{
                               {{"ols", Method::ols}, {"wls", Method::wls}, {"iv", Method::iv}}})
                   .value_or(out.method);
  out.covariance.kind = keys.choice("covariance",
                                    std::array<std::pair<std::string_view, CovarianceKind>, 3>{
                                        {{"automatic", CovarianceKind::automatic},
                                         {"classical", CovarianceKind::classical},
                                         {"hac", CovarianceKind::hac}}})
                            .value_or(out.covariance.kind);
  positive("covariance_lag", out.covariance.lag);
  out.physical = read_whether_physical(keys, out.robot);
  out.essential = read_whether_essential(keys);
  out.robust = read_whether_robust(keys);
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
}

Experiment read_experiment(const Path& path, Use use) {
  const toml::table table = detail::parsed_toml(path, "the experiment file");
  const Path folder = path.parent_path();
  TomlReader keys(table, path.string(), "");
  // All sections are looked up before one can be missing, so that a mistyped name is told first.
  const auto robot = keys.section("robot");
  const auto log = keys.section("log");
  const auto signal = keys.section("signal");
  auto method = keys.section("method");
  const auto validation = keys.section("validation");
  const auto control = keys.section("control");
  const auto reference = keys.section("reference");
  const auto simulation = keys.section("simulation");
  static_cast<void>(keys.find("montecarlo"));  // read_monte_carlo() reads it
  keys.finish();
  const auto require = [&](const std::optional<TomlReader>& section, const char* name) -> const TomlReader& {
    if (!section) {
      throw InputError(path.string() + ": section [" + name + "] is missing");
    }
    return *section;
  };
  const TomlReader& robot_keys = require(robot, "robot");
  if (use == Use::identification) {
    require(log, "log");
    require(signal, "signal");
  } else {
    require(control, "control");
    require(reference, "reference");
    require(simulation, "simulation");
  }

  Experiment out;
  out.file = path;
  out.robot = read_robot(robot_keys, folder, out.robot_file);
  if (log) {
    out.log = read_log_source(*log, {}, folder, out.robot);
  }
  if (signal) {
    out.signal = detail::read_signal(*signal, out.robot.size());
  }
  if (method) {
    detail::read_method(*method, out);
  }
  out.validation = out.log;
  out.validation.files.clear();
  out.validation.reference.reset();  // it is the motion of the first log
  if (validation) {
    out.validation = read_log_source(*validation, out.log, folder, out.robot);
  }
  if (control) {
    out.control = detail::read_control(*control, out.robot);
  }
  if (reference) {
    out.reference = detail::read_reference_source(*reference, folder, out.robot.size());
  }
  if (simulation) {
    out.simulation = detail::read_simulation(*simulation, folder, out.robot.size(), out.control);
  }
  return out;
}

}  // namespace rivid
