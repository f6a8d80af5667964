// machine_figures EXPERIMENT.toml: simulates it and fits the motion, and prints each number to its last bit, so that machines can be compared.
#include <cstdio>

#include "rivid/rivid.hpp"

namespace {

void print(const char* name, const Eigen::Ref<const rivid::Matrix>& values) {
  for (rivid::Index j = 0; j < values.cols(); ++j) {
    std::printf("%s %.3e", name, values.col(j).cwiseAbs().maxCoeff());
    for (rivid::Index i = 0; i < values.rows(); ++i) {
      std::printf(" %.17g", values(i, j));
    }
    std::puts("");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    return 2;
  }
  const rivid::Experiment experiment = rivid::read_experiment(argv[1], rivid::Use::simulation);
  const rivid::SimulationRecord record = rivid::run_simulation(experiment);
  const rivid::Motion& motion = record.simulation.motion;
  print("q", motion.q);
  print("qd", motion.qd);
  print("qdd", motion.qdd);
  print("tau", record.simulation.tau);

  const rivid::Observation rows = rivid::observation(experiment.robot, record.base, motion);
  std::vector<rivid::RowGroup> groups;
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    const rivid::JointRows& joint = rows.joints[j];
    print("W", joint.W);
    groups.push_back({joint.columns, rivid::StreamingQr(joint.W.cols())});
    groups.back().qr.add(joint.W, record.simulation.tau.col(static_cast<rivid::Index>(j)));
  }
  const std::vector<double> weights(groups.size(), 1.0);
  const rivid::LeastSquares fit = rivid::least_squares(groups, rows.columns, weights);
  print("chi", fit.chi);
  print("covariance", fit.unit_covariance);
}
