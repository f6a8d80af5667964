// Motions of two arms, rehearsed: what is planted is found or changes nothing, and the truth is within the
// intervals as often as they say.

#include "rivid/experiment/rehearsal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/report/rehearsal.hpp"
#include "rivid/text.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

// A plan and its motion, in a folder.
struct Planned {
  ExcitationPlan plan;
  test::TemporaryFolder folder;

  // At rest at both ends, as motions that are designed.
  void make_motion(const FourierSeries& series, double rate_hz) {
    const FourierReference reference(series);
    const Index n = reference.joints();
    Log log;
    log.f_m = rate_hz;
    log.t =
        Vector::LinSpaced(static_cast<Index>(reference.duration() * rate_hz) + 1, 0.0, reference.duration());
    log.q.resize(log.t.size(), n);
    Vector q(n);
    Vector qd(n);
    Vector qdd(n);
    for (Index k = 0; k < log.t.size(); ++k) {
      reference.at(log.t[k], q, qd, qdd);
      log.q.row(k) = q;
    }
    folder.write("motion.csv", to_csv(log));
  }
  [[nodiscard]] Rehearsal rehearsed(const RehearsalOptions& options) const {
    return rehearse(plan, folder.path() / "motion.csv", options);
  }
};

// The arm of data/six_axis with the motion that its log is made of.
struct SixAxis : Planned {
  SixAxis() {
    const std::filesystem::path arm = std::filesystem::path(RIVID_DATA) / "six_axis";
    plan = read_excitation(arm / "excite.toml");
    const Experiment made = read_experiment(arm / "simulate.toml", Use::simulation);
    make_motion(std::get<FourierSeries>(made.reference->motion), 1000.0);
  }
};

// The arm of data/scara, which gravity does not reach, with a controller that follows.
struct Scara : Planned {
  Scara() {
    folder.write("scara.urdf", test::content_of(std::filesystem::path(RIVID_DATA) / "scara/scara.urdf"));
    folder.write("scara.toml",
                 "[robot]\nurdf = \"scara.urdf\"\nfriction = \"coulomb\"\nrotor_inertia = false\n"
                 "[excitation]\nnoise = [0.06, 0.015]\nlimits.acceleration = [10, 20]\n"
                 "[control]\nlaw = \"pd\"\nomega_n = [40, 40]\nzeta = 1\nreference_velocity = true\n"
                 "rate_hz = 500\n");
    plan = read_excitation(folder.path() / "scara.toml");
    FourierSeries series{.omega_f = 0.628318530717958648};
    series.A = (Matrix(2, 4) << 0.5, -0.3, 0.4, -0.6, -0.8, 0.9, 0.5, -0.6).finished();
    series.B = (Matrix(2, 4) << 0.6, 0.3, -0.4, 0.0, 0.2, -0.9, 0.0, 0.4).finished();
    make_motion(series, 500.0);
  }
};

const RehearsedRun& with(const Rehearsal& rehearsal, Trouble trouble) {
  return *std::ranges::find(rehearsal.troubles, trouble, &RehearsedRun::trouble);
}

std::set<std::string> codes(const RehearsedRun& run) {
  std::set<std::string> out;
  std::ranges::transform(run.findings, std::inserter(out, out.end()), &Finding::code);
  return out;
}

// Which codes name a trouble, one of which must be found.
const std::map<Trouble, std::set<std::string>> named_by = {
    {Trouble::torque_unit, {"torque_unit"}},
    {Trouble::torque_late, {"torque_delay", "torque_lag"}},
    {Trouble::weak_motion, {"rehearsal_precision"}},
    {Trouble::saturation, {"rehearsal_failed"}},
    {Trouble::wrong_tip, {"rehearsal_prior"}},
    {Trouble::gripper_missing, {"rehearsal_prior"}},
    {Trouble::coarse_encoder, {"rehearsal_precision"}},
    {Trouble::load_friction, {"load_friction"}},
    {Trouble::coupling, {"joint_coupling", "poor_fit"}},
    {Trouble::soft_loop, {"rehearsal_failed", "rehearsal_tracking"}},
    {Trouble::zero_offset, {"zero_offset", "model_mismatch"}}};

void expect_found(const Rehearsal& rehearsal, Trouble trouble) {
  const std::set<std::string> found = codes(with(rehearsal, trouble));
  EXPECT_TRUE(std::ranges::any_of(named_by.at(trouble),
                                  [&](const std::string& code) { return found.contains(code); }))
      << name(trouble) << '\n'
      << summary(rehearsal);
}

void expect_a_screen(const Rehearsal& rehearsal) {
  constexpr std::size_t columns = 100;
  const std::string text = summary(rehearsal, columns);
  EXPECT_LE(std::ranges::count(text, '\n'), 40) << text;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(display_width(line), columns) << line;
  }
}

TEST(Rehearsal, FindsEveryTroubleOfASixJointArm) {
  const SixAxis arm;
  const Rehearsal found = arm.rehearsed({});
  EXPECT_TRUE(found.passes()) << summary(found);
  EXPECT_EQ(found.troubles.size(), named_by.size());
  for (const auto& [trouble, wanted] : named_by) {
    expect_found(found, trouble);
  }
  expect_a_screen(found);
}

// Without gravity a zero of the last joint and the place of its axis are those of another forearm: nothing in
// any log shows them, and no torque is explained worse.
TEST(Rehearsal, SaysOfAScaraWhatItsLogsDoNotShow) {
  const Scara arm;
  const Rehearsal found = arm.rehearsed({});
  EXPECT_TRUE(found.passes()) << summary(found);
  for (const auto& [trouble, wanted] : named_by) {
    if (trouble == Trouble::zero_offset || trouble == Trouble::wrong_tip) {
      EXPECT_NEAR(with(found, trouble).torque_error, found.as_planned.torque_error,
                  0.1 * found.as_planned.torque_error)
          << summary(found);
    } else {
      expect_found(found, trouble);
    }
  }
  expect_a_screen(found);
}

// How often intervals that are wider by a factor hold the truth.
double coverage(const std::vector<RehearsedParameter>& all, double factor) {
  constexpr double z_95 = 1.96;
  const auto held = [&](const RehearsedParameter& p) { return p.sigmas_off() <= factor * z_95; };
  return static_cast<double>(std::ranges::count_if(all, held)) / static_cast<double>(all.size());
}

TEST(Rehearsal, HoldsTheTruthInItsIntervalsAsOftenAsTheySay) {
  const Scara arm;
  std::vector<RehearsedParameter> all;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Rehearsal found = arm.rehearsed({.spread = 0.5, .seed = seed, .troubles = false});
    EXPECT_TRUE(found.passes()) << "seed " << seed << '\n' << summary(found);
    const std::vector<RehearsedParameter>& of_seed = found.as_planned.parameters;
    all.insert(all.end(), of_seed.begin(), of_seed.end());
  }
  // Four standard errors of 60 seeds of some three independent errors each; half and twice the deviation are
  // farther away.
  ASSERT_EQ(all.size(), 60U * 8U);
  const double allowed = 4.0 * std::sqrt(0.95 * 0.05 / 180.0);
  EXPECT_NEAR(coverage(all, 1.0), 0.95, allowed);
  EXPECT_LT(coverage(all, 0.5), 0.95 - allowed);
  const auto covered = static_cast<double>(std::ranges::count_if(all, &RehearsedParameter::covered));
  EXPECT_NEAR(covered / static_cast<double>(all.size()), 0.95, allowed);
}

TEST(Rehearsal, GivesTheSameBytesForTheSameSeed) {
  const Scara arm;
  const auto text = [&](std::uint64_t seed) {
    const Rehearsal found = arm.rehearsed({.seed = seed});
    return to_json(arm.plan, found, {}) + found.as_planned.log;
  };
  const std::string first = text(7);
  EXPECT_EQ(text(7), first);
  EXPECT_NE(text(8), first);
}

// Bodies are other ones than those of the description by chance.
TEST(Rehearsal, DoesNotTakeTheSpreadForAGripper) {
  const Scara arm;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(
        codes(arm.rehearsed({.seed = seed, .troubles = false}).as_planned).contains("rehearsal_prior"))
        << seed;
  }
}

void expect_refused(const std::function<void()>& run, std::string_view words) {
  try {
    run();
    ADD_FAILURE() << "not refused: " << words;
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
  }
}

TEST(Rehearsal, RefusesWhatCanNotBeRehearsed) {
  Scara arm;
  expect_refused([&] { (void)arm.rehearsed({.spread = 2.0}); }, "spread is 2, must be from 0 to 0.9");
  expect_refused([&] { (void)rehearse(arm.plan, arm.folder.path() / "none.csv"); }, "none.csv");
  arm.folder.write("one_joint.csv", "t,q1\n0,0\n0.002,0\n0.004,0\n");
  expect_refused([&] { (void)rehearse(arm.plan, arm.folder.path() / "one_joint.csv"); }, "joint");
  for (Inertial& body : arm.plan.experiment.robot.inertials) {
    body.setZero();
  }
  expect_refused([&] { (void)arm.rehearsed({}); }, "scara.urdf: rehearse: the links have no masses");
}

}  // namespace
}  // namespace rivid
