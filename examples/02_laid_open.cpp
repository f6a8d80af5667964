#include <Eigen/QR>
#include <iostream>
#include <limits>

#include "rivid/rivid.hpp"

// What identify() does, written out with the functions that it is made of; both answers must agree.
int main(int argc, char** argv) {
  using namespace rivid;
  const std::filesystem::path data = argc > 1 ? argv[1] : "data/scara";
  Robot robot = read_urdf(data / "scara.urdf");
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
    joint.rotor_inertia = false;
  }
  const Log log = shift_torque(read_csv(data / "scara_s2.csv"), -0.5);

  constexpr double cutoff_hz = 20.0;
  constexpr int n_d = 14;
  constexpr Index border = 20;  // samples that filter and differences spoil at each end
  const Index kept = log.samples() - 2 * border;

  const BaseParameters base = base_parameters(robot);  // (4–6)
  const Motion whole =
      differentiate(zero_phase(log.q, log.f_m, cutoff_hz), log.f_m);  // q̂ and its derivatives
  const Motion motion = {whole.q.middleRows(border, kept), whole.qd.middleRows(border, kept),
                         whole.qdd.middleRows(border, kept)};
  const Matrix tau = decimate(effort(robot, log).middleRows(border, kept), n_d);  // (8), then (13)
  const Matrix W = decimate(observation(robot, base, motion), n_d).dense();       // (10–14)
  const Vector Y = tau.reshaped();

  const Eigen::HouseholderQR<Matrix> qr(W);
  const Vector chi = qr.solve(Y);  // (15)
  const Index b = base.size();
  const auto freedom = static_cast<double>(W.rows() - b);
  // (17), and what the decimation filter has taken from the deviations is given back
  const double sigma_rho = (Y - W * chi).norm() / std::sqrt(freedom) / deviation_factor({n_d});
  const Matrix R_inverse =
      qr.matrixQR().topRows(b).triangularView<Eigen::Upper>().solve(Matrix::Identity(b, b));
  const Matrix C_chi = sigma_rho * sigma_rho * R_inverse * R_inverse.transpose();  // (18)

  const SignalOptions signal = {
      .rows = RowScheme::paper, .cutoff_hz = cutoff_hz, .decimation = {n_d}, .trim = {{border, border}}};
  const Identification answer = identify(
      robot, log, {.method = Ols{}, .signal = signal, .covariance = {.kind = CovarianceKind::classical}});
  for (Index i = 0; i < b; ++i) {
    std::cout << base.parameters[static_cast<std::size_t>(i)].name << ": " << chi[i] << " and "
              << answer.chi[i] << ", sigma " << std::sqrt(C_chi(i, i)) << " and "
              << std::sqrt(answer.C_chi(i, i)) << '\n';
  }

  // Two factorisations of the same rows are 10 ε κ apart at most.
  const double tolerance = 10.0 * std::numeric_limits<double>::epsilon() * answer.condition;
  const bool same = (chi - answer.chi).norm() <= tolerance * chi.norm() &&
                    (C_chi - answer.C_chi).norm() <= tolerance * C_chi.norm();
  std::cout << (same ? "the same answer\n" : "two answers\n");
  return same ? 0 : 1;
}
