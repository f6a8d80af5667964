#include "experiment/sections.hpp"
#include "model/link_poses.hpp"

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

void read_more(TomlReader& keys, LogSource::BasePose& out) {
  out.position = keys.columns("position", {3});
  out.acceleration = keys.columns("acceleration", {3});
  out.orientation = keys.columns("orientation", {4, 3});
  if (out.position.empty() == out.acceleration.empty()) {
    keys.fail("must name the columns of either position or acceleration");
  }
}

void read_more(TomlReader& keys, LogSource::Contact& out) {
  out.wrench = keys.columns("wrench", {6, 3});
  if (const Robot& robot = keys.robot(); !link_called(robot, out.link)) {
    keys.fail(*keys.find("link"), "link",
              "is no moving link of robot \"" + robot.name + "\", which has " +
                  quoted_list(link_names(robot)) +
                  ": of one that is fixed to such a link take that and `at`");
  }
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
  keys.set(out.base, {.key = "base"});
  keys.set(out.contact,
           {.key = "contact", .details = {.must_be = "a list of tables: [[log.contact]] before each"}});
  if (out.base.has_value() != (keys.robot().base_joints > 0)) {
    keys.fail("base and floating = true of [robot] belong together");
  }
  if (!out.contact.empty() && out.torque_lag != 0.0) {
    keys.fail(*keys.find("torque_lag"), "torque_lag", "does not go with contact: shift the log before");
  }
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
