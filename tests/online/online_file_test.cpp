// From result.json to estimators: by C++, by C, and along a log.

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "rivid/experiment/result_file.hpp"
#include "rivid/online.h"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/robot_state.hpp"
#include "rivid/output.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/online.hpp"
#include "support/complaint.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

constexpr double f_m = 200.0;
constexpr Index joints = 3;

struct Fitted {
  Robot robot;
  Vector chi_st;
  Identification result;
};

Log log_of(const Robot& robot, const Vector& chi_st, std::uint64_t seed, double seconds) {
  Log out;
  out.source = "wandering.csv";
  out.f_m = f_m;
  out.t = test::ticks(seconds, f_m);
  const Motion motion = test::Wandering(joints, seed, 0.6, 1.2).at(out.t);
  out.q = motion.q;
  out.tau = test::torques(DynamicModel(robot, chi_st), motion);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.2);
  out.tau = out.tau.unaryExpr([&](double x) { return x + noise(random); });
  return out;
}

const Fitted& fitted() {
  static const Fitted out = [] {
    std::mt19937_64 random(8);
    Fitted made{test::random_robot(joints, random), {}, {}};
    made.robot.chain.gravity = {0.0, 0.0, -9.81};
    for (Joint& joint : made.robot.joints) {
      joint.friction = Friction::symmetric;
    }
    made.chi_st = made.robot.chi_st();
    Estimation estimation;
    estimation.method = Wls{};
    estimation.signal.decimation = {5};
    estimation.signal.torque_held = false;
    made.result = identify(made.robot, log_of(made.robot, made.chi_st, 1, 60.0), estimation);
    return made;
  }();
  return out;
}

class OnlineFile : public testing::Test {
 protected:
  void SetUp() override {
    Identification result = fitted().result;
    // What the judge of results thinks of this one is not the matter here.
    result.status = Status::identified;
    file_ = folder_.path() / "result.json";
    write_file(file_, to_json(fitted().robot, result, Provenance()));
  }
  [[nodiscard]] OnlineModel expected() const {
    Identification result = fitted().result;
    result.status = Status::identified;
    return online_model(fitted().robot, result);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_;
};

TEST_F(OnlineFile, IsTheResultItself) {
  const OnlineModel found = read_online_model(file_);
  const OnlineModel wanted = expected();
  EXPECT_EQ((found.chi - wanted.chi).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((found.C_chi - wanted.C_chi).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((found.sigma_rho - wanted.sigma_rho).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((found.velocity_threshold - wanted.velocity_threshold).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_TRUE(test::says(test::complaint_of([&] { return read_online_model(folder_.path() / "none.json"); }),
                         "none.json"));
}

TEST_F(OnlineFile, CFunctionsAreTheEstimators) {
  std::array<char, 200> message{};
  EXPECT_EQ(rivid_payload_new("none.json", f_m, 0.0, nullptr, message.data(), message.size()), nullptr);
  EXPECT_TRUE(test::says(message.data(), "none.json"));
  const std::array<double, 6> flange = {0.0, 0.1, 0.2, 0.0, 0.0, 1.0};
  rivid_payload* const payload =
      rivid_payload_new(file_.c_str(), f_m, 0.01, flange.data(), message.data(), message.size());
  ASSERT_NE(payload, nullptr) << message.data();
  rivid_contact* const contact =
      rivid_contact_new(file_.c_str(), f_m, 20.0, 1.0, message.data(), message.size());
  ASSERT_NE(contact, nullptr) << message.data();
  EXPECT_EQ(rivid_payload_joints(payload), joints);
  EXPECT_EQ(rivid_contact_joints(contact), joints);

  PayloadEstimatorOptions options{.rows = {.f_m = f_m}, .p = {0.0, 0.1, 0.2}, .gain_sigma = 0.01};
  options.R << std::cos(1.0), -std::sin(1.0), 0.0, std::sin(1.0), std::cos(1.0), 0.0, 0.0, 0.0, 1.0;
  PayloadEstimator<double> same(read_online_model(file_), options);
  ContactObserver<double> observer(read_identified_model(file_), {.f_m = f_m, .bandwidth = 20.0});
  const Inertial body = inertial_from_com(2.0, {0.1, 0.0, 0.1}, 0.01 * Eigen::Matrix3d::Identity());
  const Log log = log_of(fitted().robot, test::loaded(fitted().robot, fitted().chi_st, body), 2, 10.0);
  const Matrix q = log.q.transpose();
  const Matrix tau = log.tau.transpose();
  Vector qd = Vector::Zero(joints);
  for (Index k = 1; k < q.cols(); ++k) {
    qd = (q.col(k) - q.col(k - 1)) * f_m;
    const Vector q_k = q.col(k);
    const Vector tau_k = tau.col(k);
    EXPECT_EQ(rivid_payload_update(payload, q_k.data(), tau_k.data()), same.update(q_k, tau_k) ? 1 : 0);
    observer.update(q_k, qd, tau_k, ContactObserver<double>::Mode::learn);
    EXPECT_EQ(rivid_contact_update(contact, q_k.data(), qd.data(), tau_k.data(), 1), 0);
    EXPECT_EQ(rivid_contact_learned(contact, 0) != 0, observer.learned());
    EXPECT_EQ(rivid_contact_learned(contact, joints) != 0, observer.learned(joints - 1));
  }
  EXPECT_EQ(rivid_contact_learned(contact, joints + 1), 0);
  rivid_payload_numbers numbers{};
  rivid_payload_read(payload, &numbers);
  EXPECT_GT(numbers.mass, 1.0);
  EXPECT_NEAR(numbers.mass, same.payload().mass, 1e-12);
  EXPECT_NEAR(numbers.com[2], same.payload().com[2], 1e-9);
  EXPECT_EQ(numbers.held != 0, same.payload().held);
  Vector torque(joints);
  Vector relative(joints);
  rivid_contact_read(contact, torque.data(), relative.data());
  EXPECT_EQ((torque - observer.residual()).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((relative - observer.relative()).cwiseAbs().maxCoeff(), 0.0);
  rivid_payload_delete(payload);
  rivid_contact_delete(contact);
}

// Ticks that are lost, late, no numbers and glitches among them; a state that is put back; what a gripper
// says.
TEST_F(OnlineFile, TheStateByCIsThatByCpp) {
  std::array<char, 200> message{};
  EXPECT_EQ(rivid_state_new("none.json", f_m, 0.0, nullptr, 1, 5.0, message.data(), message.size()), nullptr);
  EXPECT_TRUE(test::says(message.data(), "none.json"));
  const auto made = [&] {
    return rivid_state_new(file_.c_str(), f_m, 0.01, nullptr, 0, 5.0, message.data(), message.size());
  };
  rivid_state* by_c = made();
  ASSERT_NE(by_c, nullptr) << message.data();
  EXPECT_EQ(rivid_state_joints(by_c), joints);
  RobotStateOptions options;
  options.payload.rows = {.f_m = f_m, .torque_held = false};
  options.payload.gain_sigma = 0.01;
  options.learn = 5.0;
  RobotState<double> state(read_online_model(file_), read_identified_model(file_), options);
  const Inertial body = inertial_from_com(2.0, {0.1, 0.0, 0.1}, 0.01 * Eigen::Matrix3d::Identity());
  const Log log = log_of(fitted().robot, test::loaded(fitted().robot, fitted().chi_st, body), 2, 20.0);
  const Matrix q = log.q.transpose();
  const Matrix tau = log.tau.transpose();
  Index changes = 0;
  double largest = 0.0;
  for (Index k = 0; k < q.cols(); ++k) {
    Vector q_k = q.col(k);
    Vector tau_k = tau.col(k);
    q_k[1] += k % 211 == 50 ? 0.3 : 0.0;
    tau_k[2] = k % 307 == 11 ? std::numeric_limits<double>::quiet_NaN() : tau_k[2];
    const double t = log.t[k] + (k % 401 == 7 ? 0.4 / f_m : 0.0) + (k > 2000 ? 1.0 : 0.0);
    if (k % 101 == 3) {
      continue;
    }
    if (k == 1500) {  // another object goes on
      std::vector<char> bytes(rivid_state_size(by_c));
      EXPECT_EQ(rivid_state_save(by_c, bytes.data(), bytes.size() - 1), 0);
      ASSERT_EQ(rivid_state_save(by_c, bytes.data(), bytes.size()), 1);
      rivid_state_delete(by_c);
      by_c = made();
      ASSERT_NE(by_c, nullptr);
      ASSERT_EQ(rivid_state_restore(by_c, bytes.data(), bytes.size()), 1);
      bytes.back() ^= 1;
      EXPECT_EQ(rivid_state_restore(by_c, bytes.data(), bytes.size()), 0);
    }
    if (k == 2500) {
      rivid_state_gripper(by_c, 0);
      state.gripper(false);
    }
    if (k == 3000) {
      const std::array<double, 3> com = {0.1, 0.0, 0.1};
      EXPECT_EQ(rivid_state_payload_known(by_c, -1.0, com.data(), 0.1, 0.01), 0);
      EXPECT_EQ(rivid_state_payload_known(by_c, 2.0, com.data(), 0.1, 0.01), 1);
      EXPECT_FALSE(state.payload_known(-1.0, {0.1, 0.0, 0.1}, 0.1, 0.01));
      EXPECT_TRUE(state.payload_known(2.0, {0.1, 0.0, 0.1}, 0.1, 0.01));
    }
    rivid_tick tick{};
    const int said = rivid_state_update(by_c, t, q_k.data(), tau_k.data(), &tick);
    const TickQuality quality = state.update(t, q_k, tau_k);
    ASSERT_EQ(tick.lost, quality.lost);
    ASSERT_EQ(
        tick.gap + 2 * tick.not_finite + 4 * tick.repeated + 8 * tick.late + 16 * tick.glitch,
        quality.gap + 2 * quality.not_finite + 4 * quality.repeated + 8 * quality.late + 16 * quality.glitch);
    ASSERT_EQ(said, (state.contact() ? RIVID_CONTACT : 0) + (state.collision() ? RIVID_COLLISION : 0) +
                        (state.payload_changes() != changes ? RIVID_PAYLOAD_CHANGED : 0));
    changes = state.payload_changes();
    Vector found(joints);
    const Vector none = Vector::Zero(joints);
    rivid_state_feedforward(by_c, q.col(k).data(), none.data(), none.data(), found.data());
    largest = std::max(largest, (found - state.feedforward(q.col(k), none, none)).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(largest, 1e-9);
  rivid_payload_numbers numbers{};
  rivid_state_payload(by_c, &numbers);
  EXPECT_NEAR(numbers.mass, state.payload().mass, 1e-9);
  EXPECT_NEAR(numbers.mass, 2.0, 2.0 * state.payload().mass_half_width());
  EXPECT_EQ(rivid_state_link(by_c), state.observer().link() + 1);
  EXPECT_GE(state.counts().gaps, 1);
  EXPECT_GE(state.counts().glitches, 10);
  rivid_state_delete(by_c);
}

TEST_F(OnlineFile, AReplayTellsWhatALoopWouldHaveSeen) {
  const Inertial body = inertial_from_com(3.0, {0.1, 0.0, 0.1}, 0.01 * Eigen::Matrix3d::Identity());
  Log log = log_of(fitted().robot, fitted().chi_st, 3, 40.0);
  const Log with = log_of(fitted().robot, test::loaded(fitted().robot, fitted().chi_st, body), 3, 40.0);
  log.tau.bottomRows(4000) = with.tau.bottomRows(4000);
  OnlineReplayOptions options;
  options.state.payload.rows.torque_held = false;
  const OnlineReplay found = replay(read_online_model(file_), read_identified_model(file_), log, options);
  bool seen = false;
  for (const OnlineReplay::Event& event : found.events) {
    if (event.text == "the payload changes") {
      EXPECT_GE(event.t, 20.0);
      EXPECT_LE(event.t, 20.5);
      seen = true;
    }
  }
  EXPECT_TRUE(seen);
  EXPECT_NEAR(found.last.mass, 3.0, 2.0 * found.last.mass_half_width());
  const std::string csv = to_csv(found);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), found.t.size() + 1);
  EXPECT_EQ(csv.substr(0, 22), "t,mass,mass_half_width");
  const std::string page = to_html(found);
  EXPECT_TRUE(test::says(page, "<figure class=\"chart"));
  EXPECT_TRUE(test::says(page, "the payload changes"));
  EXPECT_TRUE(test::says(in_words(found), "at the end: mass"));
  Log other = log;
  other.q = Matrix::Zero(log.q.rows(), 2);
  other.tau = other.q;
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           return replay(read_online_model(file_), read_identified_model(file_), other,
                                         options);
                         }),
                         "has 2 joints, the model has 3"));
}

}  // namespace
}  // namespace rivid
