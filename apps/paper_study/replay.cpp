#include <algorithm>
#include <array>
#include <cmath>

#include "paper_study/runs.hpp"
#include "paper_study/study.hpp"

namespace rivid::study {

namespace {

// No feedback: what moves the robot is added to this.
class Silent final : public ControlLaw {
 public:
  void control(const ControlInput& /*input*/, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    v_tau.setZero();
  }
};

struct Model {
  std::string name;
  std::size_t color;
  Vector chi;
};

Motion replayed(const Scara& scara, const Vector& chi, const PointToPointReference& reference,
                const Log& log) {
  const DynamicModel model(scara.robot, scara.base, chi);
  SimulationOptions options{.f_m = Scara::f_m, .samples = log.samples(), .sampling = scara.sampling};
  options.added_control = log.v_tau;
  return simulate(scara.robot, model, Silent{}, reference, options).motion;
}

svg::Panel positions(Index j, const Log& log) {
  svg::Panel out;
  out.title = "joint " + std::to_string(j + 1);
  out.x.label = "t [s]";
  out.y.label = "q [rad]";
  out.series.push_back({.label = "measured",
                        .x = {log.t.begin(), log.t.end()},
                        .y = {log.q.col(j).begin(), log.q.col(j).end()},
                        .color = 5});
  return out;
}

}  // namespace

void replay(const Scara& scara, std::uint64_t seeds, Report& report) {
  const PointToPointReference reference = Scara::unused_moves();
  const std::array<const char*, 5> what = {"the true parameters", "IDIM-OLS, filtered", "IDIM-IV, filtered",
                                           "IDIM-OLS, not filtered", "IDIM-IV, not filtered"};
  Matrix errors = Matrix::Zero(5, 4);  // of q and q̇ of both joints, summed over the logs
  std::vector<svg::Panel> panels;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log log = scara.log(S2, seed);
    const std::vector<Model> models = {
        {what[0], 2, scara.chi},
        {what[1], 3, identify(scara.robot, log, {.method = Ols{}, .signal = filtered()}).chi},
        {what[2], 4, identify(scara.robot, log, scara.iv(filtered())).chi},
        {what[3], 1, identify(scara.robot, log, {.method = Ols{}, .signal = raw()}).chi},
        {what[4], 0, identify(scara.robot, log, scara.iv(raw())).chi}};
    const Log unused = scara.log(reference, seeds + seed, {});
    const Matrix qd = differentiate(zero_phase(unused.q, unused.f_m, 20.0), unused.f_m).qd;
    for (Index j = 0; j < 2 && seed == 1; ++j) {
      panels.push_back(positions(j, unused));
    }
    for (std::size_t m = 0; m < models.size(); ++m) {
      const Motion motion = replayed(scara, models[m].chi, reference, unused);
      for (Index j = 0; j < 2; ++j) {
        const auto row = static_cast<Index>(m);
        errors(row, 2 * j) += (motion.q.col(j) - unused.q.col(j)).norm() / unused.q.col(j).norm();
        errors(row, 2 * j + 1) += (motion.qd.col(j) - qd.col(j)).norm() / qd.col(j).norm();
        if (seed == 1) {
          panels[static_cast<std::size_t>(j)].series.push_back(
              {.label = models[m].name,
               .x = {unused.t.begin(), unused.t.end()},
               .y = {motion.q.col(j).begin(), motion.q.col(j).end()},
               .dashed = m == 0,
               .color = models[m].color});
        }
      }
    }
  }
  errors /= static_cast<double>(seeds);
  std::vector<std::vector<std::string>> rows = {{"model", "joint 1: q", "q̇", "joint 2: q", "q̇"}};
  for (Index m = 0; m < errors.rows(); ++m) {
    rows.push_back({what[static_cast<std::size_t>(m)]});
    for (Index c = 0; c < errors.cols(); ++c) {
      rows.back().push_back(percent(errors(m, c)));
    }
  }
  report.print(
      "\nEq. (21), the direct dynamic model driven by the torques of a trajectory that was not used, 10 s\n"
      "without feedback; errors against the measured motion\n\n" +
      table({24, 12, 9, 12}, rows));
  report.figure("replay.svg", "Eq. (21): positions from the same torques, without feedback (first log)",
                panels, 1, 900.0, 300.0);
  report.expect(
      errors(4, 0) < 0.2 * errors(3, 0),
      "replayed without feedback, IV on raw data is five times nearer than least squares on raw data");
}

}  // namespace rivid::study
