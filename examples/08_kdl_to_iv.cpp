#include <Eigen/QR>
#include <iostream>
#include <kdl/chain.hpp>
#include <random>
#include <span>

#include "rivid/model/kdl.hpp"
#include "rivid/rivid.hpp"

// The whole way by hand: a KDL::Chain, rows of its regressor for any number type, least squares by Eigen's
// Householder QR, the closed loop by CVODE with gains adapted to each estimate, and the iteration of
// instrumental variables that follows. identify() has the same answer.
using namespace rivid;

namespace {

KDL::Chain two_links() {
  KDL::Chain chain;
  const auto add = [&](const char* link, const char* joint, const KDL::Vector& tip, double mass, double com,
                       double inertia) {
    chain.addSegment(KDL::Segment(
        link, KDL::Joint(joint, KDL::Joint::RotZ), KDL::Frame(tip),
        KDL::RigidBodyInertia(mass, {com, 0.0, 0.0}, KDL::RotationalInertia(inertia, inertia, inertia))));
  };
  add("arm", "shoulder", {0.5, 0.0, 0.0}, 6.0, -0.25, 0.2);
  add("forearm", "elbow", {0.4, 0.0, 0.0}, 3.0, -0.2, 0.08);
  return chain;
}

// Rows of the regressor along a motion, (2) of [RIV], of each joint: of double here, as well of float or of
// numbers that know their derivatives.
template <typename Scalar, typename Rows = Eigen::MatrixX<Scalar>>
std::vector<Rows> regressor(const Robot& robot, const BaseParameters& base, const Rows& q, const Rows& qd,
                            const Rows& qdd) {
  const RegressorColumns columns(robot, base.columns());
  RegressorWorkspace<Scalar> workspace(columns);
  std::vector<Rows> out(columns.joints(), Rows::Zero(q.rows(), base.size()));
  for (Index k = 0; k < q.rows(); ++k) {
    const Rows at =
        (Rows(q.cols(), 3) << q.row(k).transpose(), qd.row(k).transpose(), qdd.row(k).transpose()).finished();
    const auto part = [&](Index c) { return std::span<const Scalar>(&at(0, c), columns.joints()); };
    columns.rows(State<Scalar>{part(0), part(1), part(2)}, workspace,
                 [&](std::size_t j, Index c, const Scalar& value) {
                   out[j](k, columns.of_joint(j)[static_cast<std::size_t>(c)]) = value;
                 });
  }
  return out;
}

}  // namespace

int main() {
  Robot robot = robot_from(two_links());
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::viscous;
    joint.Fv = 0.5;
    joint.rotor_inertia = false;
  }
  const BaseParameters base = base_parameters(robot);  // (4–6)
  const Vector truth = base.from_standard(robot.chi_st());
  const PdControl control{.omega_n = Eigen::Vector2d(8.0, 12.0), .zeta = Eigen::Vector2d(1.0, 1.0)};

  // What a recorder kept: the loop of the true robot with noise on positions and torques.
  FourierSeries series{.omega_f = 2.0, .A = Matrix(2, 3), .B = Matrix(2, 3), .duration = 6.0};
  series.A << 1.2, -0.8, 0.5, 0.7, 1.1, -0.9;
  series.B << -0.4, 0.9, 0.6, 1.0, -0.5, 0.8;
  const FourierReference reference(series);
  SimulationOptions options{.f_m = 500.0, .integrator = Integrator::adams, .rtol = 1e-9, .atol = 1e-11};
  const Vector J = design_inertia(DynamicModel(robot, base, truth));  // (38)
  const Simulation run = simulate(robot, base, truth, control, J, reference, options);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto noise = [&] { return normal(random); };
  Log log;
  log.source = "by hand";
  log.t = run.t;
  log.f_m = options.f_m;
  log.q = run.motion.q + 1e-5 * Matrix::NullaryExpr(run.tau.rows(), 2, noise);
  log.tau = run.tau + 0.05 * Matrix::NullaryExpr(run.tau.rows(), 2, noise);
  log.q_r = run.q_r;

  // Rows (10–13): filter, differences, and a decimation that leaves the ends out.
  const SignalOptions signal = {
      .rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {10}, .trim = {{50, 50}}};
  const auto decimated = [&](const Matrix& x) { return decimate(x.middleRows(50, x.rows() - 100), 10); };
  const auto rows_of = [&](const Motion& of) {
    const std::vector<Matrix> joints = regressor<double>(robot, base, of.q, of.qd, of.qdd);
    return (Matrix(2 * decimated(of.q).rows(), base.size()) << decimated(joints[0]), decimated(joints[1]))
        .finished();
  };
  const Motion motion = differentiate(zero_phase(log.q, log.f_m, signal.cutoff_hz), log.f_m);
  const Matrix W = rows_of(motion);
  const Vector Y = decimated(log.tau).reshaped();

  // Instruments (21, 29, 46): the loop with gains for this estimate, which no noise has reached.
  Vector chi = Eigen::HouseholderQR<Matrix>(W).solve(Y);  // (15)
  const LoggedReference logged(log.t, log.q_r);
  for (int iteration = 0; iteration < 15; ++iteration) {
    const Vector adapted = design_inertia(DynamicModel(robot, base, chi), motion.q);
    const Matrix V = rows_of(simulate(robot, base, chi, control, adapted, logged, options).motion);
    chi = Eigen::HouseholderQR<Matrix>(V.transpose() * W).solve(V.transpose() * Y);
  }

  const Iv iv{.control = control,
              .weights = Iv::Weights::none,
              .start_on_reference = true,
              .tolerance = 1e-9,
              .parameter_tolerance = 1e-6,
              .simulation = options};
  const Identification answer = identify(robot, log, {.method = iv, .signal = signal});
  double apart = 0.0;
  for (Index i = 0; i < base.size(); ++i) {
    const ParameterEstimate& p = answer.parameters[static_cast<std::size_t>(i)];
    std::cout << p.name << ": " << chi[i] << " by hand, " << p.value << " by identify(), truth " << truth[i]
              << ", sigma " << p.sigma << '\n';
    apart = std::max(apart, std::abs(chi[i] - p.value) / p.sigma);
  }
  std::cout << "apart by " << apart << " deviations at most\n";
  return answer.status == Status::identified && apart < 1e-3 ? 0 : 1;
}
