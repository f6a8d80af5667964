#include "experiment/law_control.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "identify/estimate/closed_loops.hpp"
#include "rivid/data/adjust.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr const char* by_law =
    "no torques: its control signals are those of the law in [control] along the measured positions. All "
    "parameters of a joint are in proportion to its drive_gain, which such a log can not tell: a data "
    "sheet does, or a known mass";

// The law with its gains, which must be those of the actual controller.
std::unique_ptr<ControlLaw> known_law(const Log& log, const LogSource& source, const Robot& robot) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(log.source + ": neither torque nor control signal, and " + why);
  };
  const DynamicModel model(robot, robot.chi_st());
  const Vector one = Vector::Ones(robot.size());
  std::unique_ptr<ControlLaw> law = law_of(source.law, Plant{robot, model, one});
  const auto other = law_of(source.law, Plant{robot, model, 2.0 * one});
  if (by_name(law->description().gains) != by_name(other->description().gains)) {
    refuse("the gains in [control] follow the inertias: name columns, or give the gains of the controller");
  }
  if (law->states() > 0) {
    refuse("the control law in [control] has an integral, whose value is not logged: name columns");
  }
  if (log.q_r.size() == 0) {
    refuse("no reference that the control law in [control] follows: name columns of one of them");
  }
  return law;
}

}  // namespace

Log with_control_of_law(Log log, const LogSource& source, const Robot& robot) {
  const std::unique_ptr<ControlLaw> law = known_law(log, source, robot);
  const Iv loop{.control = source.law, .sampling = source.sampling};
  log.v_tau = AuxiliaryLoop(robot, log, SignalOptions{}, loop).rebuilt_control(*law);
  log.notes.push_back(by_law);
  // A controller of another rate than the log has its delay between samples.
  const double period = source.sampling.period * log.f_m;
  const bool each_sample = std::abs(period - 1.0) < 1e-6;
  const double delay = source.sampling.delay;
  const double lag = source.torque_lag - (each_sample ? delay - std::floor(delay) : period * delay);
  return lag != 0.0 ? shift_torque(log, lag) : log;
}

bool has_control_of_law(const Log& log) { return std::ranges::find(log.notes, by_law) != log.notes.end(); }

std::vector<Log> with_control_of_loop(std::span<const Log> logs, LogSource source, const Robot& robot,
                                      const std::vector<LoopEstimate>& loop) {
  const DynamicModel model(robot, robot.chi_st());
  const std::vector<Gain> gains =
      law_of(source.law, {robot, model, Vector::Ones(robot.size())})->description().gains;
  Matrix factors = Matrix::Ones(robot.size(), std::ssize(gains));
  for (const LoopEstimate& one : loop) {
    const auto joint = std::ranges::find(robot.joints, one.joint, &Joint::name);
    if (joint == robot.joints.end()) {
      source.sampling.delay = one.value;
    } else {
      factors(joint - robot.joints.begin(), std::ranges::find(gains, one.name, &Gain::name) - gains.begin()) =
          one.value / one.prior;
    }
  }
  source.law = [given = source.law, factors](Plant plant) {
    plant.gain_factors = factors;
    return given(plant);
  };
  std::vector<Log> out;
  for (const Log& log : logs) {
    Log bare = log;
    std::erase(bare.notes, by_law);
    out.push_back(has_control_of_law(log) ? with_control_of_law(std::move(bare), source, robot) : log);
  }
  return out;
}

}  // namespace rivid::detail
