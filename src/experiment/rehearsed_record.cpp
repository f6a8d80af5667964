#include "experiment/rehearsed_record.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Of the range of a joint: what a plan's margins may take, and where it is another motion.
constexpr double most_tracking_error = 0.05;
constexpr double not_followed = 0.2;

// A control law whose signals are scaled, and end at what the drives give.
class Drives final : public ControlLaw {
 public:
  Drives(std::unique_ptr<ControlLaw> law, double scale, Vector most)
      : law_(std::move(law)), scale_(scale), most_(std::move(most)) {}

  [[nodiscard]] Index states() const override { return law_->states(); }
  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override {
    law_->control(input, x, v_tau, xd);
    v_tau = (scale_ * v_tau).cwiseMin(most_).cwiseMax(-most_);
  }

 private:
  std::unique_ptr<ControlLaw> law_;
  double scale_;
  Vector most_;
};

// Control signals at the limits of effort; coupled drives have none of their own.
Vector signals_at_limits(const Robot& robot) {
  Vector out = Vector::Constant(robot.size(), std::numeric_limits<double>::infinity());
  for (Index j = 0; j < robot.size() && robot.gear_matrix.size() == 0; ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    out[j] = joint.max_effort / std::abs(joint.g_tau());
  }
  return out;
}

std::vector<Finding> findings_about(const Simulation& made, const Robot& robot) {
  std::vector<Finding> out;
  if (made.outcome != Outcome::completed) {
    return {{"rehearsal_failed", {}, "the motion is not carried through: " + made.reason}};
  }
  for (Index j = 0; j < robot.size(); ++j) {
    const double error = made.max_tracking_error[j];
    const double range = made.q_r.col(j).maxCoeff() - made.q_r.col(j).minCoeff();
    if (error > most_tracking_error * range) {
      out.push_back({error > not_followed * range ? "rehearsal_failed" : "rehearsal_tracking",
                     robot.joints[static_cast<std::size_t>(j)].name,
                     "is up to " + number(error, 3) + " off its reference, in a motion over " +
                         number(range, 3) + "; limits and distances of the plan hold where it follows"});
    }
  }
  return out;
}

void spoil(Log& log, std::optional<Trouble> trouble) {
  constexpr Index late = 5;  // samples, as about(Trouble::torque_late) says
  if (trouble == Trouble::torque_unit) {
    log.tau.rightCols(1) *= 1000.0;
  } else if (trouble == Trouble::torque_late && log.samples() > late) {
    log.tau.bottomRows(log.samples() - late) = log.tau.topRows(log.samples() - late).eval();
  } else if (trouble == Trouble::zero_offset) {
    log.q.col(1).array() += 0.05;
  }
}

}  // namespace

Record played(const Scene& scene, std::optional<Trouble> trouble) {
  const Log& motion = scene.motion;
  const Eigen::RowVectorXd start = motion.q.row(0);
  const double size = trouble == Trouble::weak_motion ? 0.05 : 1.0;
  const Matrix q = (size * (motion.q.rowwise() - start)).rowwise() + start;
  const DynamicModel tuned_for(scene.hidden.robot, scene.hidden.chi_st);
  const Plant plant{scene.hidden.robot, tuned_for, scene.loop.inertia(tuned_for, motion.q)};
  const Drives law(scene.loop.control(plant), trouble == Trouble::soft_loop ? 0.02 : 1.0,
                   trouble == Trouble::saturation ? Vector(0.7 * scene.signal_needed)
                                                  : signals_at_limits(scene.hidden.robot));
  SimulationOptions options{.f_m = motion.f_m, .samples = q.rows(), .sampling = scene.loop.sampling};
  if (trouble == Trouble::coarse_encoder) {
    options.sampling.quantum.setConstant(q.cols(), 0.005);
  }
  const HiddenRobot real = with_trouble(scene.hidden, trouble);
  const Simulation made = simulate(real.robot, DynamicModel(real.robot, real.chi_st), law,
                                   LoggedReference(motion.t, q), with_noise(options, scene.noise, q.cols()));
  Record out{.log = measured_log(made, options, scene.noise),
             .largest_signal = made.v_tau.cwiseAbs().colwise().maxCoeff(),
             .findings = findings_about(made, real.robot)};
  out.log.v_tau.resize(0, 0);
  out.log.qd_r.resize(0, 0);
  spoil(out.log, trouble);
  return out;
}

}  // namespace rivid::detail
