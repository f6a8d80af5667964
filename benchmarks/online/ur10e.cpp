// PayloadEstimator on the logs of a UR10e: an arm from logs without a load, 2.805 kg on its flange in
// another.

#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

constexpr double true_mass = 2.805;
constexpr std::array<double, 6> controllers_gains = {11.78, 11.98, 9.82, 10.69, 10.53, 10.63};

// The experiment file of tests/real names its files relative to the folder of the logs.
Experiment ur10e(const std::string& data, const std::string& experiment) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "rivid_online_study";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::create_directory_symlink(std::filesystem::absolute(data + "/ur10e"), folder / "ur10e");
  std::filesystem::copy_file(experiment, folder / "ur10e.toml");
  Experiment out = read_experiment(folder / "ur10e.toml");
  for (std::size_t j = 0; j < controllers_gains.size(); ++j) {
    out.robot.joints[j].drive_gain = controllers_gains[j];
  }
  out.estimation.signal = {};
  out.estimation.method = Wls{};
  return out;
}

std::vector<Log> logs(const Experiment& arm, const std::string& folder, std::vector<std::string> names) {
  LogSource source = arm.log;
  source.files.clear();
  for (const std::string& name : names) {
    source.files.push_back(folder + name);
  }
  return read_logs(source, arm.robot);
}

struct Replay {
  const OnlineModel& model;
  PayloadEstimatorOptions options;

  void run(const std::string& title, const Robot& robot, const std::vector<Log>& parts) const {
    PayloadEstimator<double> estimator(model, options);
    std::cout << title << '\n';
    double t = 0.0;
    double next = 1.0;
    double settled = 0.0;
    for (const Log& log : parts) {
      const bool loaded = log.source.find("/load_") != std::string::npos;
      const Matrix q = log.q.transpose();
      const Matrix tau = effort(robot, log).transpose();
      const double begin = t;
      double moved = 0.0;  // s since then in which a joint moves fast enough for rows
      for (Index k = 0; k < q.cols(); ++k, t += 1.0 / log.f_m) {
        const bool changed = estimator.update(q.col(k), tau.col(k));
        const Vector velocity = (q.col(k) - q.col(std::max<Index>(k - 1, 0))) * log.f_m;
        moved += (velocity.cwiseAbs().array() > model.velocity_threshold.array()).any() ? 1.0 / log.f_m : 0.0;
        if (changed) {
          std::cout << "  the payload changes at " << t << " s, " << t - begin
                    << " s after the log's begin and after " << moved << " s of motion\n";
        }
        const auto& found = estimator.payload();
        const double truth = loaded ? true_mass : 0.0;
        if (std::abs(found.mass - truth) > std::max(found.mass_half_width(), 0.0) ||
            (loaded && std::abs(found.mass - truth) > 0.05 * truth)) {
          settled = t - begin;
        }
        if (t >= next) {
          next += t < 10.0 ? 1.0 : 5.0;
          std::cout << std::fixed << std::setprecision(3) << "  " << std::setw(7) << t << " s  mass "
                    << found.mass << " ± " << found.mass_half_width() << "  com [mm] "
                    << 1e3 * found.com.transpose() << "  ± " << 1.96e3 * found.com_sigma.maxCoeff()
                    << (found.body ? " body" : " point") << (found.good ? " good" : "") << "  suspicion "
                    << estimator.suspicion() << "  row sigma";
          for (Index j = 0; j < 6; ++j) {
            std::cout << ' ' << std::setprecision(2) << estimator.row_sigma(j, 0.1);
          }
          std::cout << '\n';
        }
      }
      std::cout << "  within 5 % and the interval from " << settled << " s on\n";
    }
  }
};

}  // namespace

void ur10e_study(const std::string& data, const std::string& experiment) {
  const Experiment arm = ur10e(data, experiment);
  const std::string folder = data + "/ur10e/";
  const std::vector<Log> training =
      logs(arm, folder, {"unload_14harm.csv", "ident_30s_12harm.csv", "ident_40s_12harm.csv"});
  const Identification found = identify(arm.robot, training, arm.estimation);
  const OnlineModel model = online_model(arm.robot, found);
  std::cout << "arm: sigma_rho " << model.sigma_rho.transpose() << ", threshold "
            << model.velocity_threshold.transpose() << ", decimation "
            << found.estimation.signal.decimation.front() << '\n';
  for (const Index stride : {Index{3}, Index{4}, Index{5}, Index{10}}) {  // 5 is the default
    const RowStreamOptions rows = {.f_m = 100.0, .stride = stride, .torque_held = false};
    const Replay replay{model, {.rows = rows, .gain_sigma = 0.01}};
    const std::string of = ", stride " + std::to_string(stride);
    replay.run("loaded" + of, arm.robot, logs(arm, folder, {"load_14harm.csv"}));
    replay.run("unloaded" + of, arm.robot, logs(arm, folder, {"unload_14harm.csv"}));
    replay.run("unloaded, 40 s" + of, arm.robot, logs(arm, folder, {"ident_40s_12harm.csv"}));
    replay.run("unloaded, then loaded" + of, arm.robot,
               logs(arm, folder, {"unload_14harm.csv", "load_14harm.csv"}));
    replay.run("loaded, then unloaded" + of, arm.robot,
               logs(arm, folder, {"load_14harm.csv", "unload_14harm.csv"}));
  }
}

}  // namespace rivid::benchmarks
