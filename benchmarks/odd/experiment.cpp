#include "odd/experiment.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/text.hpp"

namespace rivid::odd {

namespace {

namespace fs = std::filesystem;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// A folder that is gone when the experiment is over.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "rivid_odd_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error("can not make " + name);
    }
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// What the user knows of the torques, which no file says.
std::string with_held_torques(std::string text) {
  const std::string key = "torque_held = true";
  const std::size_t comment = text.find("# " + key);
  if (comment != std::string::npos) {
    return text.erase(comment, 2);
  }
  const std::string section = "[signal]\n";
  const std::size_t at = text.find(section);
  return at == std::string::npos ? text : text.insert(at + section.size(), key + '\n');
}

fs::path drafted(const Truth& truth, const fs::path& folder) {
  const fs::path file = folder / "experiment.toml";
  std::vector<fs::path> logs;
  for (int k = 1; fs::exists(folder / ("log_" + std::to_string(k) + ".csv")); ++k) {
    logs.push_back(folder / ("log_" + std::to_string(k) + ".csv"));
  }
  std::string text = draft_experiment(file, folder / "robot.urdf", {}, logs).text;
  if (!truth.recipe.continuous && truth.recipe.control_every == 1 && truth.recipe.held_known) {
    text = with_held_torques(std::move(text));
  }
  std::ofstream(file) << text;
  return file;
}

// The instrumental variables that need to know nothing, where the file has no control law.
Experiment read_for(const fs::path& file, const std::string& method) {
  Experiment out = read_experiment(file);
  if (method == "iv" && !out.control) {
    const std::vector<std::string> settings = {
        "method.follows=measured", "method.reference_cutoff_hz=10",   "control.law=pd",
        "control.omega_n=20",      "control.reference_velocity=true", "control.zeta=1",
        "control.assumed=true"};
    out = read_experiment(file, Use::identification, settings);
  }
  if (method != "as-drafted") {
    out.take_method(method);
  }
  return out;
}

std::string checked(const Experiment& experiment) {
  const std::vector<Log> logs = read_logs(experiment.log, experiment.robot);
  const std::vector<Log> validation = read_logs(experiment.validation, experiment.robot);
  std::string out;
  for (const Finding& finding :
       check(experiment.robot, logs, validation,
             {.signal = experiment.estimation.signal,
              .instrumental = std::holds_alternative<Iv>(experiment.estimation.method)})) {
    if (severity(finding) != Severity::note) {
      out += (out.empty() ? "" : ";") + finding.code;
    }
  }
  return out;
}

void write_truth(const Name& name, const Truth& truth, const Identification& result, const fs::path& folder) {
  nlohmann::ordered_json json;
  json["kind"] = name.kind->name;
  json["number"] = name.number;
  json["seed"] = name.seed;
  const Vector chi = truth.base_values(result.base);
  for (Index i = 0; i < chi.size(); ++i) {
    const BaseParameter& p = result.base.parameters[static_cast<std::size_t>(i)];
    json["parameters"].push_back({{"name", p.name}, {"value", chi[i]}, {"unit", p.unit}});
  }
  std::ofstream(folder / "truth.json") << json.dump(2) << '\n';
}

void keep(const fs::path& from, const fs::path& to) {
  fs::create_directories(to.parent_path());
  fs::remove_all(to);
  fs::copy(from, to, fs::copy_options::recursive);
}

// What was thrown is told in the record: one experiment does not end the others.
template <typename Work>
void guarded(Record& record, const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    record.status = "input_error";
    record.message = error.what();
    record.judgement.outcome = Outcome::refused;
  } catch (const std::exception& error) {
    record.status = "crashed";
    record.message = error.what();
    record.judgement.outcome = Outcome::crashed;
  }
}

// Mean over the joints of how much larger the fault makes their squared residuals. The twin has the same
// rows, since the residual goes with the window.
double visible_share(const Name& name, const std::string& method, const Identification& result) {
  Name twin = name;
  twin.sound = true;
  const WorkFolder folder;
  const Truth truth = write_experiment(twin, folder.path());
  Experiment experiment = read_for(drafted(truth, folder.path()), method);
  if (result.row_choice) {
    experiment.estimation.signal.decimation = {result.row_choice->decimation};
    experiment.estimation.signal.torque_held = result.row_choice->torque_held;
  }
  Reading reading;
  take_friction(experiment, reading);
  const Identification sound = run(experiment);
  double ratio = 0.0;
  for (std::size_t j = 0; j < sound.fit.joints.size(); ++j) {
    const double part = result.fit.joints.at(j).relative_error / sound.fit.joints[j].relative_error;
    ratio += part * part / static_cast<double>(sound.fit.joints.size());
  }
  return 1.0 - 1.0 / ratio;
}

}  // namespace

std::vector<Record> carried_out(const Name& name, const Asked& asked) {
  const WorkFolder folder;
  const double start = seconds();
  const Truth truth = write_experiment(name, folder.path());
  const double written = seconds() - start;
  std::vector<Record> out;
  for (const std::string& method : asked.methods) {
    Record record{.name = name,
                  .method = method,
                  .used = {},
                  .status = {},
                  .check = "-",
                  .message = {},
                  .judgement = {}};
    record.joints = truth.recipe.joints;
    record.rate_hz = truth.recipe.rate_hz;
    record.written_s = written;
    const double begin = seconds();
    guarded(record, [&] {
      const fs::path file = drafted(truth, folder.path());
      Experiment experiment = read_for(file, method);
      Reading reading;
      take_friction(experiment, reading);
      const Identification result = run(experiment);
      record.identified_s = seconds() - begin;
      record.used = result.method;
      record.status = rivid::name(result.status);
      record.message = result.reasons.empty() ? "" : result.reasons.front();
      record.judgement = judged(result, truth.base_values(result.base), name.kind->inertial_only);
      write_truth(name, truth, result, folder.path());
      if (asked.visible && name.kind->group != "good") {
        record.visible = visible_share(name, method, result);
      }
      if (asked.check) {
        record.check = checked(experiment);
      }
    });
    const bool worth_it = asked.keep_all || record.judgement.outcome == Outcome::wrong ||
                          record.judgement.outcome == Outcome::crashed;
    if (!asked.keep.empty() && worth_it) {
      keep(folder.path(), asked.keep / (name.text() + '_' + method));
    }
    out.push_back(std::move(record));
  }
  return out;
}

}  // namespace rivid::odd
