#include <cmath>
#include <memory>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// A log of more rows is a mistake of units, and would not fit into the memory.
constexpr double most_samples = 1e8;
// Part of a sample that the end of a motion may fall short of the last instant by rounding.
constexpr double rounding = 1e-6;

// The logged reference with its own clock.
Log logged_motion(const Experiment& experiment, const std::filesystem::path& file,
                  const LoggedMotion& logged) {
  if (!file.empty()) {
    Log out = read_reference(file, logged.columns);
    if (out.q_r.cols() != experiment.robot.size()) {
      throw InputError(file.string() + ": " + counted(out.q_r.cols(), "reference column") + ", robot \"" +
                       experiment.robot.name + "\" has " + counted(experiment.robot.size(), "joint") +
                       "; name one column for each joint in [reference] position");
    }
    return out;
  }
  LogSource first = experiment.log;
  if (first.files.empty()) {
    throw InputError(experiment.file.string() +
                     ": [reference] names no file, and there is no [log] whose reference could be followed");
  }
  first.files.resize(1);
  const std::vector<Log> pieces = read_logs(first, experiment.robot);
  if (pieces.front().q_r.size() == 0) {
    throw InputError(pieces.front().source +
                     ": the log has no reference columns that [reference] could follow; name a file there");
  }
  return pieces.front();
}

std::unique_ptr<Reference> reference_of(const Experiment& experiment, const ReferenceSource& source) {
  const auto& motion = source.motion;
  if (const auto* const series = std::get_if<FourierSeries>(&motion)) {
    return std::make_unique<FourierReference>(*series);
  }
  if (const auto* const moves = std::get_if<PointToPoint>(&motion)) {
    return std::make_unique<PointToPointReference>(*moves);
  }
  const auto& logged = std::get<LoggedMotion>(motion);
  const Log log = logged_motion(experiment, source.file, logged);
  if (logged.interpolation == LoggedMotion::Interpolation::linear) {
    return std::make_unique<LinearReference>(log.t, log.q_r);
  }
  return std::make_unique<LoggedReference>(log.t, log.q_r);
}

Index samples_of(const SimulationPlan& plan, const Reference& reference) {
  const double duration = plan.duration > 0.0 ? plan.duration : reference.duration();
  const double samples = std::floor(duration * plan.options.f_m + rounding) + 1.0;
  if (!(samples <= most_samples)) {
    throw InputError("[simulation] " + number(duration) + " s at " + number(plan.options.f_m) + " Hz are " +
                     number(samples) + " samples; duration is in seconds, rate_hz in Hz");
  }
  return static_cast<Index>(samples);
}

Matrix added_control(const SimulationPlan::AddedControl& added) {
  TableOptions options;
  for (const Column& column : added.columns) {
    options.columns.push_back(column.name);
  }
  Matrix out = read_table(added.file, options).values;
  for (std::size_t j = 0; j < added.columns.size(); ++j) {
    auto values = out.col(static_cast<Index>(j)).array();
    values = added.columns[j].scale * values + added.columns[j].offset;
  }
  return out;
}

Matrix reference_positions(const Reference& reference, const SimulationOptions& options) {
  Matrix out(options.samples, reference.joints());
  Vector q_r(reference.joints());
  Vector qd_r(reference.joints());
  Vector qdd_r(reference.joints());
  for (Index k = 0; k < options.samples; ++k) {
    reference.at(reference.begin() + static_cast<double>(k) / options.f_m, q_r, qd_r, qdd_r);
    out.row(k) = q_r;
  }
  return out;
}

Log recorded(const SimulationRecord& record, const SimulationPlan& plan, const SimulationOptions& options) {
  Log out = measured_log(record.simulation, options, plan.noise);
  out.source = "the simulated log";
  const auto drop = [](bool keep, Matrix& columns) {
    if (!keep) {
      columns.resize(0, 0);
    }
  };
  drop(plan.columns.torque, out.tau);
  drop(plan.columns.control, out.v_tau);
  drop(plan.columns.reference, out.q_r);
  drop(plan.columns.reference_velocity, out.qd_r);
  return out;
}

const Experiment& with_sections(const Experiment& experiment) {
  if (!experiment.control || !experiment.reference || !experiment.simulation) {
    throw InputError("run_simulation: the experiment must have [control], [reference] and [simulation]");
  }
  return experiment;
}

// All that stands before the motion, read and checked.
struct Setup {
  explicit Setup(const Experiment& experiment);

  const Robot& robot;
  const SimulationPlan& plan;
  SimulationRecord record;
  Vector chi_st;
  DynamicModel model;
  std::unique_ptr<Reference> reference;
  SimulationOptions options;
  SimulationOptions disturbed;      // the same with noise
  std::unique_ptr<ControlLaw> law;  // none where the robot is no robot at the start: see the record's outcome
};

SimulationRecord record_of(const Robot& robot) {
  SimulationRecord out;
  out.base = base_parameters(robot);
  return out;
}

Setup::Setup(const Experiment& experiment)
    : robot(with_sections(experiment).robot),
      plan(*experiment.simulation),
      record(record_of(robot)),
      chi_st(plan.parameters.empty() ? robot.chi_st() : read_parameters(plan.parameters, record.base)),
      model(robot, chi_st),
      reference(reference_of(experiment, *experiment.reference)),
      options(plan.options) {
  const ControlLoop& loop = *experiment.control;
  record.chi = record.base.from_standard(chi_st);
  options.sampling = loop.sampling;
  options.samples = samples_of(plan, *reference);
  if (plan.added_control) {
    options.added_control = added_control(*plan.added_control);
  }
  disturbed = with_noise(options, plan.noise, robot.size());
  if (const auto fault = disturbed.complaint(robot.size())) {
    throw InputError("simulate: " + *fault);
  }
  record.seed = plan.noise.seed;
  record.control_hz = loop.sampling.period > 0.0 ? 1.0 / loop.sampling.period : 0.0;
  record.control_assumed = loop.assumed;
  record.warnings = robot.warnings;
  try {
    record.J = loop.inertia(model, reference_positions(*reference, options));
  } catch (const NumericsError& e) {
    record.simulation.outcome = Outcome::not_positive_definite;
    record.simulation.reason = std::string("before the start: ") + e.what();
    return;
  }
  law = loop.control({robot, model, record.J});
  record.control = law->description();
}

}  // namespace

SimulationOutlook outlook(const Experiment& experiment) {
  Setup setup(experiment);
  return {std::move(setup.record), setup.options.samples, setup.options.f_m};
}

SimulationRecord run_simulation(const Experiment& experiment, const Progress& progress) {
  Setup setup(experiment);
  const SimulationPlan& plan = setup.plan;
  SimulationRecord& out = setup.record;
  if (progress) {
    setup.disturbed.progress = [&](double fraction) { progress("simulating", fraction); };
  }
  if (setup.law) {
    out.simulation = simulate(setup.robot, setup.model, *setup.law, *setup.reference, setup.disturbed);
  } else {
    for (Matrix* m : {&out.simulation.motion.q, &out.simulation.v_tau, &out.simulation.tau,
                      &out.simulation.q_r, &out.simulation.qd_r, &out.simulation.q_measured}) {
      m->resize(0, setup.robot.size());
    }
  }
  out.log = recorded(out, plan, setup.options);
  out.warnings.insert(out.warnings.end(), out.simulation.warnings.begin(), out.simulation.warnings.end());
  if (plan.added_control && plan.columns.control && !plan.columns.torque) {
    out.warnings.push_back(
        Finding{"added_control_unrecorded",
                {},
                "the log holds the controller's signal without what added_control adds to it; "
                "record = [\"torque\", …] holds the torques of both"});
  }
  return std::move(out);
}

}  // namespace rivid
