#include <algorithm>

#include "dense.hpp"
#include "experiment/sections.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid {

namespace detail {

namespace {

// What nobody named is numbered.
template <typename Obstacle>
void name_by_number(std::vector<Obstacle>& obstacles, const std::string& kind) {
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (obstacles[i].name.empty()) {
      obstacles[i].name = kind + " " + std::to_string(i + 1);
    }
  }
}

}  // namespace

void read_more(TomlReader& keys, Space& out) {
  keys.set(out.half_spaces, {.key = "half_spaces"});
  name_by_number(out.half_spaces, "half_spaces");
  if (const auto floor = keys.get<double>("floor")) {
    out.half_spaces.insert(out.half_spaces.begin(),
                           {.name = "floor", .normal = Eigen::Vector3d::UnitZ(), .offset = *floor});
  }
  keys.set(out.boxes, {.key = "boxes"});
  name_by_number(out.boxes, "boxes");
  keys.set(out.capsules, {.key = "capsules"});
  keys.set(out.ignored, {.key = "ignored"});
}

void read_excitation_plan(TomlReader keys, ExcitationPlan& out) {
  refuse_floating(keys);
  keys.read(out);
  keys.finish();
  keys.refuse(out.options.complaint(keys.robot()));
}

}  // namespace detail

std::vector<std::filesystem::path> ExcitationPlan::inputs() const {
  std::vector<std::filesystem::path> out = {experiment.file, experiment.robot_file};
  for (const auto* const files : {&experiment.robot_tables, &known, &options.space.model.meshes}) {
    out.insert(out.end(), files->begin(), files->end());
  }
  return out;
}

namespace {

// What a result knows of the parameters that it determines: the inverse of their covariance.
bool add_result(const std::filesystem::path& file, const Robot& robot, const BaseParameters& base,
                Matrix& to) {
  const IdentifiedArm arm = read_identified_arm(file, robot);
  const BaseParameters of_arm = base_parameters(arm.robot);
  std::vector<Index> here;
  std::vector<Index> there;
  for (Index i = 0; i < of_arm.size(); ++i) {
    const auto at = std::ranges::find(base.parameters, of_arm.parameters[static_cast<std::size_t>(i)].name,
                                      &BaseParameter::name);
    if (at != base.parameters.end() && arm.C_chi(i, i) > 0.0) {
      here.push_back(at - base.parameters.begin());
      there.push_back(i);
    }
  }
  const Matrix C = arm.C_chi(there, there);
  const auto scale = C.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
  to(here, here) += scale * detail::inverse(scale * C * scale) * scale;
  return true;
}

}  // namespace

Matrix known_information(const ExcitationPlan& plan) {
  if (plan.known.empty()) {
    return {};
  }
  const Robot& robot = plan.experiment.robot;
  const BaseParameters base = base_parameters(robot);
  Matrix out = Matrix::Zero(base.size(), base.size());
  LogSource source = plan.experiment.log;
  source.files = plan.known;
  std::erase_if(source.files, [&](const std::filesystem::path& known) {
    return known.extension() == result_ending && add_result(known, robot, base, out);
  });
  if (source.files.empty()) {
    return out;
  }
  const Vector& sigma = plan.options.noise.sigma;
  if (sigma.size() == 0) {
    throw InputError(plan.experiment.file.string() +
                     ": [excitation] noise is required with known: it says what earlier logs are worth");
  }
  const double noise_hz =
      plan.options.noise.rate_hz > 0.0 ? plan.options.noise.rate_hz : plan.options.rate_hz;
  for (const Log& log : read_logs(source, robot)) {
    SignalOptions signal = plan.experiment.estimation.signal;
    if (signal.automatic()) {
      signal = chosen_signal(robot, std::span(&log, 1), {.method = Wls{}, .signal = signal});
    }
    const Rows rows_of_log = rows(robot, base, log, signal);
    double n_d = 1.0;
    for (const int factor : signal.decimation) {
      n_d *= factor;
    }
    // A row stands for its part of the time.
    const double worth = noise_hz * n_d / log.f_m;
    for (std::size_t j = 0; j < rows_of_log.W.joints.size(); ++j) {
      const JointRows& joint = rows_of_log.W.joints[j];
      const double deviation = sigma[static_cast<Index>(j)];
      out(joint.columns, joint.columns) += worth / (deviation * deviation) * joint.W.transpose() * joint.W;
    }
  }
  return out;
}

}  // namespace rivid
