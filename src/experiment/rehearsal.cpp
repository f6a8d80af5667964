#include "rivid/experiment/rehearsal.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "excite/prior.hpp"
#include "experiment/from_program.hpp"
#include "experiment/rehearsed_record.hpp"
#include "provided_input.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/input.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Path = std::filesystem::path;

// With the figures of hidden_robot.cpp and rehearsed_record.cpp.
constexpr std::array<std::string_view, names_of<Trouble>.size()> troubles_in_words = {
    "torques of the last joint in thousandths",
    "torques five samples late",
    "a twentieth of the motion",
    "drives that give 70 % of what the motion needs",
    "the last joint 50 mm from its place",
    "5 % of the arm's mass more on the last link",
    "positions in steps of 0.005 rad or m",
    "friction that grows by a tenth of the load",
    "the last motor turned by the joint before, too",
    "a fiftieth of the control signal",
    "the zero of the second joint off by 0.05 rad or m"};
static_assert(!troubles_in_words.back().empty(), "each trouble has its words");

// [rad/s] of a position loop where the plan has no [control]; a choice
constexpr double usual_bandwidth = 60.0;
// Deviations from the blocks of ten seconds scatter between 0.8 and 1.6 of the forecast.
constexpr double precision_lost = 2.0;
// Standard deviations: none of a hundred parameters is farther off by chance.
constexpr double certainly_off = 5.0;

// Whether the parameters of the plan's robot have true values with it.
bool has_truth(std::optional<Trouble> trouble) {
  return trouble != Trouble::wrong_tip && trouble != Trouble::load_friction && trouble != Trouble::coupling &&
         trouble != Trouble::zero_offset;
}

bool is_error(const Finding& finding) { return severity(finding) == Severity::error; }

// Rehearses one motion with one hidden robot.
class Stage {
 public:
  Stage(const ExcitationPlan& plan, const Path& file, const RehearsalOptions& options);
  [[nodiscard]] RehearsedRun run(std::optional<Trouble> trouble);

 private:
  void identify_log(RehearsedRun& out) const;
  void compare_with_truth(const Robot& robot, const Identification& result, RehearsedRun& out) const;
  void compare_with_description(const Robot& robot, const Identification& result, RehearsedRun& out) const;

  const Experiment& plan_;
  double spread_;
  std::uint64_t seed_;
  Forecast forecast_;
  detail::Scene scene_;
};

Stage::Stage(const ExcitationPlan& plan, const Path& file, const RehearsalOptions& options)
    : plan_(plan.experiment), spread_(options.spread), seed_(options.seed) {
  scene_.motion = read_csv(file, plan_.log.columns);
  const Log& log = scene_.motion;
  if (const auto fault = log.complaint()) {
    throw InputError(*fault);
  }
  const Motion motion = differentiate(log.q, log.f_m);
  forecast_ = forecast(plan_.robot, motion, log.f_m, plan.options);
  if (forecast_.tau.size() == 0) {
    throw InputError(plan_.robot_file.string() +
                     ": rehearse: the links have no masses, about which a hidden robot could be drawn");
  }
  const Index n = plan_.robot.size();
  if (plan_.control) {
    scene_.loop = *plan_.control;
  } else {
    scene_.loop.control = PdControl{
        .omega_n = Vector::Constant(n, usual_bandwidth), .zeta = Vector::Ones(n), .reference_velocity = true};
  }
  scene_.hidden = detail::drawn_robot(plan_.robot, motion, forecast_.tau, spread_, options.seed);
  NoiseOptions& noise = scene_.noise;
  noise.feedback = scene_.loop.sampling.period > 0.0;
  if (plan_.simulation) {
    noise = plan_.simulation->noise;
  }
  if (noise.torque.size() == 0 && noise.disturbance.size() == 0) {
    noise.torque.resize(n);
    std::ranges::transform(forecast_.joints, noise.torque.begin(), &JointInformation::sigma);
  }
  noise.seed = options.seed;
}

// The truth is unknown to who has the trouble: it is no finding then.
void Stage::compare_with_truth(const Robot& robot, const Identification& result, RehearsedRun& out) const {
  Robot real = detail::with_trouble(scene_.hidden, out.trouble).robot;
  for (std::size_t j = 0; j < real.joints.size(); ++j) {
    real.joints[j].friction = robot.joints[j].friction;
  }
  const Vector truth = has_truth(out.trouble)
                           ? result.base.from_standard(real.chi_st())
                           : Vector::Constant(result.base.size(), std::numeric_limits<double>::quiet_NaN());
  double logarithms = 0.0;
  int ratios = 0;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const double true_value = truth[static_cast<Index>(i)];
    const auto planned = std::ranges::find(forecast_.parameters, p.name, &ForecastParameter::name);
    const double forecast = planned == forecast_.parameters.end() ? 0.0 : planned->sigma;
    out.parameters.push_back({.name = p.name,
                              .unit = p.unit,
                              .truth = true_value,
                              .estimate = p.value,
                              .sigma = p.sigma,
                              .forecast = forecast,
                              .covered = p.interval_95[0] <= true_value && true_value <= p.interval_95[1],
                              .verdict = p.verdict});
    if (const double ratio = p.sigma / forecast; std::isfinite(ratio) && ratio > 0.0) {
      logarithms += std::log(ratio);
      ++ratios;
    }
    if (const double off = out.parameters.back().sigmas_off(); !out.trouble && off > certainly_off) {
      out.findings.push_back(
          {"rehearsal_wrong", p.name, "is " + number(off, 2) + " standard deviations off the truth"});
    }
  }
  out.sigma_ratio = std::exp(logarithms / ratios);
  if (out.sigma_ratio > precision_lost) {
    out.findings.push_back({"rehearsal_precision",
                            {},
                            "standard deviations are " + number(out.sigma_ratio, 2) +
                                " times the forecast ones, in the geometric mean"});
  }
}

// First moments that the spread of the a-priori values does not explain: another body hangs there.
void Stage::compare_with_description(const Robot& robot, const Identification& result,
                                     RehearsedRun& out) const {
  constexpr std::uint64_t draws = 1000;  // of the robot about its description; a choice
  // times the farthest of them; a choice: further draws go a little farther
  constexpr double beyond_draws = 1.2;
  const Vector believed = result.base.from_standard(robot.chi_st());
  Vector explained = Vector::Zero(believed.size());
  for (std::uint64_t draw = 1; draw <= draws; ++draw) {
    const Vector drawn = detail::drawn_about(robot, spread_, seed_ + draw).chi_st();
    explained = explained.cwiseMax((result.base.from_standard(drawn) - believed).cwiseAbs());
  }
  for (Index i = 0; i < believed.size(); ++i) {
    const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
    using enum ParameterKind;
    const ParameterKind kind = result.base.parameters[static_cast<std::size_t>(i)].leading.kind;
    const bool is_moment = kind == MX || kind == MY || kind == MZ;
    if (is_moment &&
        std::abs(p.value - believed[i]) > certainly_off * p.sigma + beyond_draws * explained[i]) {
      out.findings.push_back({"rehearsal_prior", p.name,
                              "is " + number(p.value, 3) + ' ' + p.unit + ", by the description " +
                                  number(believed[i], 3) + " ± " + number(explained[i], 2)});
    }
  }
}

void Stage::identify_log(RehearsedRun& out) const {
  const Path robot_file = std::filesystem::absolute(plan_.robot_file);
  const Path file = std::filesystem::absolute(plan_.file).parent_path().lexically_normal() / "rehearsal.toml";
  const std::array logs = {file.parent_path() / "rehearsal_log.csv"};
  detail::provide_input(logs[0], out.log);
  const UrdfOptions part = robot_file.extension() == ".csv" ? UrdfOptions{} : same_part(plan_.robot);
  const std::string draft = draft_experiment(file, robot_file, part, logs).text;
  Experiment experiment = detail::experiment_of_text(file, draft);
  experiment.robot = plan_.robot;
  Reading reading;
  take_friction(experiment, reading);
  const Identification result = rivid::run(experiment, reading);
  out.status = name(result.status);
  out.torque_error = result.fit.reference_error;
  std::ranges::copy_if(result.warnings, std::back_inserter(out.findings),
                       [](const Finding& f) { return severity(f) != Severity::note; });
  if (result.status != Status::identified && std::ranges::none_of(out.findings, is_error)) {
    out.findings.push_back({"rehearsal_failed", {}, "the log is " + out.status});
  }
  compare_with_truth(experiment.robot, result, out);
  compare_with_description(experiment.robot, result, out);
}

RehearsedRun Stage::run(std::optional<Trouble> trouble) {
  detail::Record record = detail::played(scene_, trouble);
  RehearsedRun out{.trouble = trouble, .findings = std::move(record.findings), .log = to_csv(record.log)};
  if (!trouble) {
    scene_.signal_needed = record.largest_signal;
  }
  try {
    identify_log(out);
  } catch (const InputError& e) {
    out.findings.push_back({"rehearsal_failed", {}, e.what()});
  }
  std::ranges::stable_sort(out.findings, std::ranges::greater(), severity);
  return out;
}

}  // namespace

std::string_view about(Trouble trouble) { return troubles_in_words[static_cast<std::size_t>(trouble)]; }

std::optional<std::string> RehearsalOptions::complaint() const {
  if (!(spread >= 0.0 && spread <= largest_spread)) {
    return "spread is " + number(spread) + ", must be from 0 to " + number(largest_spread);
  }
  return std::nullopt;
}

bool Rehearsal::passes() const {
  return as_planned.status == name(Status::identified) && std::ranges::none_of(as_planned.findings, is_error);
}

Rehearsal rehearse(const ExcitationPlan& plan, const Path& motion, const RehearsalOptions& options,
                   const Progress& progress) {
  if (const auto fault = options.complaint()) {
    throw InputError("rehearse: " + *fault);
  }
  const InputScope scope;
  Stage stage(plan, motion, options);
  Rehearsal out{.as_planned = stage.run(std::nullopt), .troubles = {}};
  const std::vector<Finding>& usual = out.as_planned.findings;
  constexpr std::size_t count = names_of<Trouble>.size();
  for (std::size_t k = 0; options.troubles && k < count; ++k) {
    const auto trouble = static_cast<Trouble>(k);
    const bool of_two_joints = trouble == Trouble::coupling || trouble == Trouble::zero_offset;
    if (of_two_joints && plan.experiment.robot.size() == 1) {
      continue;
    }
    if (progress) {
      progress(name(trouble), static_cast<double>(k + 1) / (count + 1));
    }
    RehearsedRun& run = out.troubles.emplace_back(stage.run(trouble));
    run.log.clear();
    std::erase_if(run.findings, [&](const Finding& finding) {
      return std::ranges::any_of(usual, [&](const Finding& other) {
        return other.code == finding.code && other.subject == finding.subject;
      });
    });
  }
  return out;
}

}  // namespace rivid
