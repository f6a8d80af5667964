// machine_figures EXPERIMENT.toml: simulates it, fits rows of its reference, and prints each number to its
// last bit, so that machines can be compared.
#include <cstdio>

#include "rivid/rivid.hpp"

namespace {

// Each column behind what it is compared to: its largest number, or that of all.
void print(const char* name, const Eigen::Ref<const rivid::Matrix>& values, bool to_all = false) {
  for (rivid::Index j = 0; j < values.cols(); ++j) {
    std::printf("%s %.3e", name, (to_all ? values : values.middleCols(j, 1)).cwiseAbs().maxCoeff());
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
  print("tau", record.simulation.tau);

  // Rows of inputs that are the same everywhere: those of the loop differ by its roundings times its gains.
  const rivid::Matrix& q_r = record.simulation.q_r;
  const rivid::Observation rows = rivid::observation(experiment.robot, record.base,
                                                     {.q = q_r, .qd = record.simulation.qd_r, .qdd = -q_r});
  std::vector<rivid::RowGroup> groups;
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    const rivid::JointRows& joint = rows.joints[j];
    print("W", joint.W, true);  // some columns are zero but for roundings
    groups.push_back({joint.columns, rivid::StreamingQr(joint.W.cols())});
    groups.back().qr.add(joint.W, record.simulation.tau.col(static_cast<rivid::Index>(j)));
  }
  const std::vector<double> weights(groups.size(), 1.0);
  const rivid::LeastSquares fit = rivid::least_squares(groups, rows.columns, weights);
  print("chi", fit.chi);
  print("covariance", fit.unit_covariance);
}
