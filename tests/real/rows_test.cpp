// Exact rows against the paper's on real arms: both fits by WLS, judged on logs of the same kind by the
// paper's rows, which is in their favour. The table of docs/rows.md.

#include <gtest/gtest.h>

#include <iomanip>
#include <iostream>

#include "rivid/experiment/experiment.hpp"
#include "support/real_experiment.hpp"

namespace {

using rivid::Convention;
using rivid::Experiment;
using rivid::Identification;
using rivid::Index;
using rivid::Log;
using rivid::RowScheme;
using rivid::SignalOptions;

// What exact rows may lose on rows that are not theirs.
constexpr double other_rows = 0.05;

struct Judged {
  double own = 0.0;
  double others = 0.0;
  double left_out = 0.0;
};

class ExactRows : public rivid::test::RealExperiment, public ::testing::WithParamInterface<const char*> {
 protected:
  ExactRows() : RealExperiment(GetParam()) {}

  // Relative error on the fit's own rows and on the paper's rows of the logs to judge on.
  static Judged judged(Experiment experiment, const SignalOptions& signal, const SignalOptions& paper,
                       const std::vector<Log>& logs) {
    experiment.estimation.method = rivid::Wls{};
    experiment.estimation.signal = signal;
    experiment.validation.files.clear();
    Identification found = run(experiment);
    Judged out = {.own = found.fit.relative_error};
    Index left_out = 0;
    for (const rivid::JointFit& joint : found.fit.joints) {
      left_out += joint.left_out;
    }
    out.left_out = static_cast<double>(left_out) / static_cast<double>(left_out + found.fit.rows);
    found.estimation.signal = paper;
    for (const Log& log : logs) {
      out.others +=
          validate(experiment.robot, found, log).fit.relative_error / static_cast<double>(logs.size());
    }
    return out;
  }
};

TEST_P(ExactRows, CarryOverAsWellAsThePapers) {
  const Experiment experiment = this->experiment();
  const SignalOptions paper = experiment.estimation.signal;
  const std::vector<Log> logs = read_logs(
      experiment.validation.files.empty() ? experiment.log : experiment.validation, experiment.robot);
  SignalOptions exact = paper;
  exact.rows = RowScheme::exact;
  exact.convention = Convention::standard;
  exact.velocity_threshold.clear();
  SignalOptions unfiltered = exact;
  unfiltered.cutoff_hz = unfiltered.torque_cutoff_hz = 0.0;
  const Judged by_paper = judged(experiment, paper, paper, logs);
  std::cout << std::fixed << std::setprecision(3) << GetParam() << ": paper own " << 100.0 * by_paper.own
            << " %, judged " << 100.0 * by_paper.others << " %\n";
  for (const auto& [name, signal] : {std::pair("exact", exact), std::pair("exact, no filter", unfiltered)}) {
    const Judged found = judged(experiment, signal, paper, logs);
    EXPECT_LT(found.others, (1.0 + other_rows) * by_paper.others) << name;
    std::cout << "  " << name << " own " << 100.0 * found.own << " %, judged " << 100.0 * found.others
              << " %, left out " << 100.0 * found.left_out << " %\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, ExactRows,
                         ::testing::Values("emps", "panda", "ur10e", "kuka_kr300", "tx40", "ur10_vrep"),
                         [](const auto& arm) { return std::string(arm.param); });

}  // namespace
