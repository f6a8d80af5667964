// Logs without torques: goal and position alone, with the controller's law.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "rivid/experiment/experiment.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

// The simulated SCARA of data/scara, whose log has the control signals that its controller computed.
class ControlOfTheLaw : public testing::Test {
 protected:
  ControlOfTheLaw() {
    const std::filesystem::path data = std::filesystem::path(RIVID_DATA) / "scara";
    std::filesystem::copy_file(data / "scara.urdf", folder_.path() / "scara.urdf");
    for (const std::string log : {"scara_s2.csv", "scara_validation.csv"}) {
      // Columns that are not named are still found by their names.
      std::string content = test::content_of(data / log);
      for (const char* const name : {"v1", "v2"}) {
        content.replace(content.find(name), 2, std::string("w") + name[1]);
      }
      folder_.write(log, content);
    }
  }

  [[nodiscard]] Experiment experiment(const std::string& columns, const std::string& control) const {
    const std::string robot =
        "[robot]\nurdf = \"scara.urdf\"\ngravity = [0, 0, -9.81]\n"
        "joints.joint_1 = { friction = \"coulomb\", rotor_inertia = false }\n"
        "joints.joint_2 = { friction = \"coulomb\", rotor_inertia = false }\n";
    const std::string log =
        "[log]\nfiles = [\"scara_s2.csv\"]\nposition = [\"q1\", \"q2\"]\n" + columns +
        "[signal]\ntorque_held = true\n[validation]\nfiles = [\"scara_validation.csv\"]\n";
    folder_.write("e.toml", robot + log + control);
    return read_experiment(folder_.path() / "e.toml");
  }
  [[nodiscard]] std::string refusal(const std::string& columns, const std::string& control) const {
    return test::complaint_of([&] {
      const Experiment of = experiment(columns, control);
      return read_logs(of.log, of.robot);
    });
  }

  test::TemporaryFolder folder_;
  std::string reference_ = "reference = [\"qref1\", \"qref2\"]\n";
  std::string law_ = "[control]\nlaw = \"pd\"\nk_p = [0.5, 5]\nk_v = [7.488, 1.24]\nrate_hz = 200\n";
};

TEST_F(ControlOfTheLaw, IsWhatTheControllerLogged) {
  const Experiment without = experiment(reference_, law_);
  const Experiment with = experiment(reference_ + "control = [\"w1\", \"w2\"]\n", law_);
  for (const LogSource Experiment::* const source : {&Experiment::log, &Experiment::validation}) {
    const Log rebuilt = read_logs(without.*source, without.robot).front();
    const Log logged = read_logs(with.*source, with.robot).front();
    ASSERT_EQ(rebuilt.v_tau.rows(), logged.v_tau.rows());
    // The file has all digits of both; its first sample knows no velocity.
    const Index rest = logged.samples() - 1;
    EXPECT_LT((rebuilt.v_tau - logged.v_tau).bottomRows(rest).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NE(rebuilt.notes.back().find("in proportion to its drive_gain"), std::string::npos);
  }
}

// As of a log with torques: row k of the control signals belongs to sample k − lag, and so a delay is taken
// back.
TEST_F(ControlOfTheLaw, ComesLaterByALagOrADelay) {
  const auto v = [&](const std::string& columns, const std::string& control) {
    const Experiment of = experiment(reference_ + columns, control);
    return Matrix(read_logs(of.log, of.robot).front().v_tau);
  };
  const Matrix whole = v("", law_);
  EXPECT_EQ(v("torque_lag = -2\n", law_), whole.topRows(whole.rows() - 2));
  const std::string faster = "[control]\nlaw = \"pd\"\nk_p = [0.5, 5]\nk_v = [7.488, 1.24]\nrate_hz = 1000\n";
  const Matrix at_once = v("", faster);
  EXPECT_EQ(v("", faster + "delay = 10\n"), at_once.topRows(at_once.rows() - 2));
}

TEST_F(ControlOfTheLaw, GivesTheParametersThatTorquesGive) {
  const Identification without = run(experiment(reference_, law_ + "[method]\nname = \"iv\"\n"));
  const Identification with =
      run(experiment(reference_ + "control = [\"w1\", \"w2\"]\n", law_ + "[method]\nname = \"iv\"\n"));
  EXPECT_EQ(without.status, Status::identified);
  for (Index i = 0; i < with.chi.size(); ++i) {
    EXPECT_NEAR(without.chi[i], with.chi[i], 1e-3 * without.parameters[static_cast<std::size_t>(i)].sigma);
  }
}

// What is judged is the control signal of the loop that output error finds, not that of the given one.
TEST_F(ControlOfTheLaw, IsThatOfTheEstimatedLoop) {
  const std::string method = "[method]\nname = \"output_error\"\n";
  const auto law = [&](const std::string& k_p, const std::string& more, const std::string& validation = "") {
    return run(experiment(
        reference_, validation + "[control]\nlaw = \"pd\"\nrate_hz = 200\nk_v = [7.488, 1.24]\nk_p = " + k_p +
                        "\ndelay = 1\n" + more + method));
  };
  const Identification known = run(experiment(reference_ + "control = [\"w1\", \"w2\"]\n", law_ + method));
  // There is no delay: its estimate leaves what the logged signals leave.
  const Identification late = law("[0.5, 5]", "delay_sigma = 1\n");
  EXPECT_NEAR(late.fit.relative_error, known.fit.relative_error, 0.05 * known.fit.relative_error);
  const Identification found = law("[0.55, 4.5]", "delay_sigma = 1\ngain_sigma = { k_p = 0.1 }\n");
  // The given loop leaves 0.063.
  EXPECT_LT(found.fit.relative_error, 0.03);
  EXPECT_EQ(found.output_error->loop.front().prior, 0.55);
  // A lag of the validation log is that log's own.
  const Identification lagged = law("[0.5, 5]", "delay_sigma = 1\n", "torque_lag = 8\n");
  EXPECT_EQ(lagged.fit.relative_error, late.fit.relative_error);
  EXPECT_GT(lagged.validation.front().fit.relative_error, 2.0 * late.validation.front().fit.relative_error);
  for (const Identification* const one : {&late, &found}) {
    EXPECT_EQ(one->status, Status::identified);
    EXPECT_TRUE(one->warnings.empty()) << one->warnings.front().text;
  }
}

TEST_F(ControlOfTheLaw, IsRefusedWhereTheLawIsNotKnown) {
  EXPECT_NE(refusal(reference_, "[control]\nlaw = \"pd\"\nomega_n = [1, 10]\nzeta = 1\n")
                .find("the gains in [control] follow the inertias"),
            std::string::npos);
  EXPECT_NE(refusal(reference_, "[control]\nlaw = \"pid\"\nK_p = [4, 6]\nK_d = [7, 1]\nK_i = [1, 1]\n")
                .find("has an integral, whose value is not logged"),
            std::string::npos);
}

}  // namespace
}  // namespace rivid
