#include "experiment/sections.hpp"

namespace rivid::detail {

// A joint by its name.
void read_more(TomlReader& keys, LogSource::Subtraction& out) {
  out.joint = keys.joint(*keys.find("joint"), "joint");
}

void read_reference_columns(TomlReader& keys, LogOptions& columns) {
  keys.set(columns.reference, {.key = "position"});
  keys.set(columns.time, {.key = "time"});
  columns.rate_hz = keys.get<double>("rate_hz", rate_range, "Hz");
}

// The reference columns of a log hold where the file does not name its own; the file itself is read in the
// same way.
void read_more(TomlReader& keys, LogSource::Reference& out) {
  read_reference_columns(keys, out.columns);
  keys.set(out.columns.reference_velocity, {.key = "velocity"});
}

LogSource read_log_source(TomlReader keys, LogSource out) {
  out.files.clear();
  keys.read(out);
  if (out.files.empty()) {
    keys.fail(*keys.find("files"), "files", "must name at least one file");
  }
  LogOptions& columns = out.columns;
  // What the file names is read, not what else happens to be in the log under a default name.
  if (!columns.torque.empty() || !columns.control.empty()) {
    columns.default_names = false;
  }
  if (const auto header = keys.get<bool>("header")) {
    columns.table.header = *header ? Header::present : Header::absent;
  }
  if (keys.find("resample_hz") != nullptr) {
    out.irregular = Irregular::resample;
  }
  keys.set(out.subtract, {.key = "subtract",
                          .details = {.must_be = "a list of tables: [{ joint = \"joint_2\", table = "
                                                 "\"counterbalance.csv\" }]"}});
  if (auto reference = keys.section("reference_file")) {
    LogSource::Reference& of_file = out.reference.emplace(LogSource::Reference{});
    of_file.columns.reference = columns.reference;
    of_file.columns.reference_velocity = columns.reference_velocity;
    of_file.columns.table = columns.table;
    reference->read_whole(of_file);
  }
  keys.finish();
  keys.refuse(columns.complaint());
  keys.refuse(out.resample.complaint());
  return out;
}

}  // namespace rivid::detail
