#include "identify/iv_mismatch.hpp"

#include <string>
#include <string_view>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Position error [rad | m] that a law's stiffness is told from: too small to saturate it.
constexpr double dead_band_probe = 1e-6;
// A joint that moves in a smaller part of the samples counts as locked.
constexpr double hardly_moving = 0.05;
// The assumed loop is in doubt where the law rebuilds the control signal worse than this, or the simulated motion lies
// farther from the measured one than this part of the tracking error.
constexpr double doubtful_control = 0.2;
constexpr double doubtful_tracking = 0.5;
// The bandwidth is doubtful where the residual with V is so much of Y, and so many times the one with W.
constexpr double doubtful_residual = 0.2;
constexpr double doubtful_ratio = 4.0;

// How far a joint's position must be off before a proportional law overcomes its friction: Fc / (ω_n² J) for PD (40).
std::string dead_band(const Robot& robot, const SimulatedLoops& loops, Index j) {
  const Index n = robot.size();
  const Vector none = Vector::Zero(n);
  const Vector x = Vector::Zero(loops.law->states());
  Vector xd = x;
  Vector v(n);
  Vector v_0(n);
  loops.law->control({0.0, none, none, none, none, none}, x, v_0, xd);
  loops.law->control({0.0, none, none, Vector::Unit(n, j) * dead_band_probe, none, none}, x, v, xd);
  const double stiffness = (robot.drive_matrix() * (v - v_0))[j] / dead_band_probe;
  double Fc = 0.0;
  for (const DryFriction& law : loops.model->dry_friction()) {
    Fc += law.direction[j] != 0.0 ? 0.5 * (law.Fc_plus + law.Fc_minus) : 0.0;
  }
  if (!(stiffness > 0.0) || Fc == 0.0) {
    return "";
  }
  return ", which holds it within " + number(Fc / stiffness, 3) + " of its reference";
}

}  // namespace

void explain_locked(const IvProblem& problem, const SimulatedLoops& loops, Identification& out) {
  for (Index j = 0; j < problem.joints(); ++j) {
    double moving = 0.0;
    double all = 0.0;
    for (const Motion& motion : loops.motions) {
      moving += static_cast<double>((motion.qd.col(j).array() != 0.0).count());
      all += static_cast<double>(motion.samples());
    }
    if (moving < hardly_moving * all) {
      out.reasons.push_back("joint \"" + problem.robot.joints[static_cast<std::size_t>(j)].name +
                            "\" stands still in " + number(100.0 * (1.0 - moving / all), 3) +
                            " % of the simulation: the assumed controller does not overcome its friction" +
                            dead_band(problem.robot, loops, j) +
                            "; a wider bandwidth or a larger motion is needed");
    }
  }
}

LoopDiagnosis diagnosed_loop(const IvProblem& problem, const ClosedLoops& all, const SimulatedLoops& loops,
                             Identification& out) {
  const Index n = problem.joints();
  Vector missed = Vector::Zero(n);
  Vector control = Vector::Zero(n);
  Vector apart = Vector::Zero(n);
  Vector tracking = Vector::Zero(n);
  const auto add = [](Vector& to, const Matrix& x) { to += x.colwise().squaredNorm().transpose(); };
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Log& log = problem.logs[k];
    const AuxiliaryLoop& loop = all.of_log(k);
    // A law that follows the measured motion has no error to work on, and rebuilds nothing.
    if (log.v_tau.size() > 0 && problem.method.follows == Iv::Follows::reference) {
      add(missed, loop.rebuilt_control(*loops.law) - log.v_tau);
      add(control, log.v_tau);
    }
    add(apart, loops.motions[k].q - loop.measured().q);
    add(tracking, loop.reference().q - loop.measured().q);
  }
  LoopDiagnosis diagnosis;
  if (control.maxCoeff() > 0.0) {
    diagnosis.control_error = (missed.array() / control.array()).sqrt();
  }
  if (problem.method.follows == Iv::Follows::reference) {
    diagnosis.tracking_ratio = (apart.array() / tracking.array()).sqrt();
  }
  const auto warn = [&](const Vector& error, double limit, std::string_view what) {
    for (Index j = 0; j < error.size(); ++j) {
      if (error[j] > limit) {
        out.warnings.push_back(
            Finding{"loop_mismatch",
                    {},
                    "joint \"" + problem.robot.joints[static_cast<std::size_t>(j)].name +
                        "\": " + std::string(what) + " by " + number(100.0 * error[j], 3) +
                        " %; the assumed controller may not be the actual one, which makes the instruments "
                        "weaker"});
      }
    }
  };
  warn(diagnosis.control_error, doubtful_control, "the control law misses the recorded control signal");
  warn(diagnosis.tracking_ratio, doubtful_tracking,
       "the simulated motion misses the measured one, in units of the tracking error,");
  return diagnosis;
}

void diagnose_bandwidth(double with_V, Identification& out) {
  const double with_W = out.fit.relative_error;
  if (with_V > doubtful_residual && with_V > doubtful_ratio * with_W) {
    out.warnings.push_back(
        Finding{"loop_bandwidth",
                {},
                "the simulated motion misses " + number(100.0 * with_V, 3) +
                    " % of the torques, the measured one " + number(100.0 * with_W, 3) +
                    " %: the bandwidth of the assumed controller may be far from the actual one"});
  }
}

}  // namespace rivid::detail
