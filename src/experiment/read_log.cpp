#include <array>

#include "experiment/column_reader.hpp"
#include "experiment/identification_sections.hpp"

namespace rivid::detail {

namespace {

using Path = std::filesystem::path;

constexpr std::array<std::pair<std::string_view, Outside>, 2> outside_words = {
    {{"refuse", Outside::refuse}, {"hold", Outside::hold}}};

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

}  // namespace

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

}  // namespace rivid::detail
