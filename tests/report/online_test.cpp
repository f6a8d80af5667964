#include "rivid/report/online.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/complaint.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 500.0;
constexpr double usual_picked_up = 15.0;  // [s]
constexpr double usual_seconds = 40.0;

// A random arm that picks up 5 kg while it moves.
struct PickUp {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
  Log log;

  explicit PickUp(double picked_up = usual_picked_up, double seconds = usual_seconds)
      : robot(arm()), chi_st(robot.chi_st()), model(test::known_model(robot, chi_st, 0.1)) {
    model.C_chi *= 0.1;
    const Inertial body =
        inertial_from_com(5.0, {0.03, -0.05, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
    log.source = "run <1>.csv";
    log.f_m = f_m;
    log.t = test::ticks(seconds, f_m);
    const Motion motion = test::Wandering(6, 3, 0.5, 1.2).at(log.t);
    log.q = motion.q;
    log.tau = test::torques(DynamicModel(robot, chi_st), motion);
    const Matrix with = test::torques(DynamicModel(robot, test::loaded(robot, chi_st, body)), motion);
    const auto rest = static_cast<Index>((seconds - picked_up) * f_m);
    log.tau.bottomRows(rest) = with.bottomRows(rest);
    std::mt19937_64 random(3);
    test::Normal noise(0.0, 0.3);
    for (double& x : log.tau.reshaped()) {
      x += noise(random);
    }
  }

  [[nodiscard]] OnlineReplay replayed(double learn = 10.0) const {
    OnlineReplayOptions options{.learn = learn};
    options.state.payload.rows.torque_held = false;
    return replay(model, DynamicModel(robot, chi_st), log, options);
  }

 private:
  static Robot arm() {
    std::mt19937_64 random(3);
    Robot out = test::random_robot(6, random);
    out.chain.gravity = {0.0, 0.0, -9.81};
    for (std::size_t j = 0; j < 6; ++j) {
      out.chain.links[j].type = out.joints[j].type = JointType::revolute;
      out.joints[j].friction = Friction::symmetric;
    }
    return out;
  }
};

std::vector<double> times_of(const OnlineReplay& replay, std::string_view begin) {
  std::vector<double> out;
  for (const OnlineReplay::Event& event : replay.events) {
    if (event.text.starts_with(begin)) {
      out.push_back(event.t);
    }
  }
  return out;
}

TEST(OnlineReplay, SaysWhenAPayloadWasPickedUpAndWhatItIs) {
  const OnlineReplay found = PickUp().replayed();
  const std::vector<double> changes = times_of(found, "the payload changes");
  ASSERT_EQ(changes.size(), 1U) << in_words(found);
  EXPECT_GE(changes[0], usual_picked_up);
  EXPECT_LE(changes[0], usual_picked_up + 0.3);
  EXPECT_EQ(times_of(found, "it was a pick-up").size(), 1U) << in_words(found);
  EXPECT_TRUE(found.last.good);
  EXPECT_NEAR(found.last.mass, 5.0, 2.0 * found.last.mass_half_width());
  const std::string words = in_words(found);
  EXPECT_NE(words.find(", good enough to\n  send\n"), std::string::npos) << words;
  EXPECT_NE(words.find("\nset_target_payload("), std::string::npos) << words;
}

TEST(OnlineReplay, NamesJointsThatHaveLearnedNoThreshold) {
  constexpr double learn = 2.0;  // [s]; a class of motion takes three
  const OnlineReplay found = PickUp().replayed(learn);
  const std::string none = "too little motion to learn thresholds of contacts: joint_1";
  EXPECT_EQ(times_of(found, none), std::vector<double>{learn}) << in_words(found);
  // A curve of zeros would look like a robot that nothing touches.
  OnlineReplay blind = found;
  blind.external.setZero();
  const std::string page = to_html(blind);
  EXPECT_NE(page.find("<p>No joint has learned a threshold, so that no contact can be detected.</p>"),
            std::string::npos);
  EXPECT_EQ(page.find("id=\"external\""), std::string::npos);
}

// A payload that is known is part of the model: its weight pushes against nothing.
TEST(OnlineReplay, AKnownPayloadIsNoContact) {
  constexpr double learn = 60.0;  // [s]
  constexpr double picked_up = 80.0;
  const OnlineReplay found = PickUp(picked_up, 120.0).replayed(learn);
  EXPECT_TRUE(times_of(found, "too little motion").empty()) << in_words(found);
  constexpr double known_after = 10.0;  // [s]
  for (const double t : times_of(found, "external torque")) {
    EXPECT_GE(t, picked_up);
    EXPECT_LE(t, picked_up + known_after) << in_words(found);
  }
  for (Index k = 0; k < found.t.size(); ++k) {
    if (found.t[k] > picked_up + known_after) {
      ASSERT_LT(found.external.row(k).cwiseAbs().maxCoeff(), 1.0) << found.t[k] << " s";
    }
  }
}

TEST(OnlineReplay, ItsCsvHasARecordALine) {
  const OnlineReplay found = PickUp().replayed();
  const std::string csv = to_csv(found);
  EXPECT_TRUE(
      csv.starts_with("t,mass,mass_half_width,com_x,com_y,com_z,com_half_width,suspicion,"
                      "friction_error1,"))
      << csv.substr(0, 100);
  // Every 25 ticks of 0.05 s.
  EXPECT_EQ(found.t.size(), 800);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 801);
  // t, six of the payload, the test, two of each of six joints.
  EXPECT_EQ(std::ranges::count(csv, ','), 801 * 19);
}

TEST(OnlineReplay, ItsPageHasPlotsThatLoadNothing) {
  OnlineReplay found = PickUp().replayed();
  found.external.setConstant(0.5);  // of thresholds that are learned
  const std::string page = to_html(found);
  for (const char* const id : {"mass", "centre-of-mass", "change", "friction-error", "external"}) {
    EXPECT_NE(page.find("<figure class=\"chart wide\" id=\"" + std::string(id) + "\">"), std::string::npos)
        << id;
  }
  EXPECT_NE(page.find("<h1>run &lt;1&gt;.csv</h1>"), std::string::npos);
  EXPECT_NE(page.find("\"style\":\"event\""), std::string::npos);
  EXPECT_NE(page.find("<code>set_target_payload("), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
}

TEST(OnlineReplay, RefusesALogOfAnotherRobot) {
  PickUp scene;
  scene.log.q = scene.log.q.leftCols(5).eval();
  scene.log.tau = scene.log.tau.leftCols(5).eval();
  EXPECT_TRUE(test::says(test::complaint_of([&] { return scene.replayed(); }),
                         "run <1>.csv has 5 joints, the model has 6"));
}

}  // namespace
}  // namespace rivid
