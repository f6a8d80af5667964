// The robot of a result.json, and of a result in memory, for a controller.

#include "rivid/experiment/result_file.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/report/json.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/robots.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

using Json = nlohmann::json;

// Recursive Newton-Euler against W χ, relative to the largest torque; roundings are some 1e-15 of its terms.
constexpr double tolerance = 1e-9;

const std::filesystem::path scara_file = std::filesystem::path(RIVID_DATA) / "scara" / "scara.toml";

Matrix torques(const DynamicModel& model, const Motion& motion) {
  InverseDynamics dynamics(model);
  Matrix out(motion.samples(), motion.joints());
  Vector tau(motion.joints());
  for (Index k = 0; k < motion.samples(); ++k) {
    dynamics.torque(motion.q.row(k).transpose(), motion.qd.row(k).transpose(), motion.qdd.row(k).transpose(),
                    tau);
    out.row(k) = tau.transpose();
  }
  return out;
}

void expect_same(const Matrix& found, const Matrix& expected) {
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff());
}

// Standard parameters as a physical() of its own would put them into a result.
PhysicalModel physical_of(const Robot& robot, const BaseParameters& base, const Vector& chi_st) {
  PhysicalModel out;
  out.parameters.chi_st = chi_st;
  out.parameters.chi = base.from_standard(chi_st);
  out.fit.joints.resize(robot.joints.size());
  return out;
}

// All that a result.json needs to be one.
Identification result_with(const Robot& robot, const Vector& chi_st) {
  Identification out;
  out.method = "ols";
  out.base = base_parameters(robot);
  out.chi = out.base.from_standard(chi_st);
  out.base.load.chi = out.chi;
  for (Index i = 0; i < out.base.size(); ++i) {
    const BaseParameter& p = out.base.parameters[static_cast<std::size_t>(i)];
    out.parameters.push_back(
        {.name = p.name, .unit = p.unit, .regrouped = p.regrouped, .value = out.chi[i], .advice = ""});
  }
  return out;
}

class ResultFile : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path path() const { return folder_.path() / "result.json"; }

  void write(const Robot& robot, const Identification& result) const {
    folder_.write("result.json", to_json(robot, result, {}));
  }
  [[nodiscard]] Json content() const { return Json::parse(folder_.read("result.json")); }
  void write(const std::string& text) const { folder_.write("result.json", text); }
  void write(const Json& json) const { write(json.dump()); }

  template <typename... Arguments>
  void expect_refused(std::string_view words, const Arguments&... arguments) const {
    const std::string message =
        test::complaint_of([&] { return read_identified_model(path(), arguments...); });
    EXPECT_TRUE(message.starts_with(path().string() + ": ")) << message << "\nshould be refused: " << words;
    EXPECT_TRUE(test::says(message, words));
  }

 private:
  test::TemporaryFolder folder_;
};

Coupling wrist(int motor, int joint) {
  Coupling out;
  out.motor = motor;
  out.joints = {joint};
  out.ratios = {-0.6};
  out.Iam = 0.2;
  out.Fvm = 0.1;
  out.Fcm = 0.3;
  return out;
}

TEST_F(ResultFile, GivesTheTorquesOfTheRegressorForEveryRobotAndFrictionLaw) {
  for (const FrictionRow& row : friction_rows) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(std::string(row.name) + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      Robot robot = test::random_robot(5, random);
      for (Joint& joint : robot.joints) {
        joint.friction = row.law;
      }
      robot.joints[2].sign_speed = 0.7;
      robot.joints[3].rotor_inertia = seed % 2 == 0;
      if (row.law == Friction::symmetric) {
        robot.joints[3].rotor_inertia = true;
        robot.couplings = {wrist(3, 4)};
        robot.gear_matrix = Matrix::Identity(5, 5);
        robot.gear_matrix(3, 4) = -0.6;
      }
      const Vector chi_st = test::distinct_friction(robot);
      Identification result = result_with(robot, chi_st);
      const Motion motion = test::random_motion(20, 5, random);
      const Matrix expected =
          (observation(robot, result.base, motion).dense() * result.chi).reshaped(motion.samples(), 5);
      write(robot, result);
      expect_same(torques(read_identified_model(path()), motion), expected);
      expect_same(torques(identified_model(robot, result), motion), expected);
      Vector twice = 2.0 * chi_st;
      for (std::size_t i = 0; i < result.base.standard.size(); ++i) {
        if (result.base.standard[i].kind == ParameterKind::Fl) {
          twice[static_cast<Index>(i)] = chi_st[static_cast<Index>(i)];  // the load is twice as large already
        }
      }
      result.physical = physical_of(robot, result.base, twice);
      write(robot, result);
      expect_same(torques(read_identified_model(path()), motion), 2.0 * expected);
      expect_same(torques(identified_model(robot, result), motion), 2.0 * expected);
    }
  }
}

class IdentifiedScara : public ResultFile {
 protected:
  IdentifiedScara() : experiment_(read_experiment(scara_file)) {
    experiment_.estimation.physical =
        Physical{.weight = 1e4};  // far enough from the estimate to tell the two apart
    result_ = run(experiment_);
    write(experiment_.robot, result_);
  }

  // W χ at every sample of the log, without a filter, so that its motion is known here.
  [[nodiscard]] std::pair<Motion, Matrix> predicted(const Vector& chi) const {
    const Log log = read_logs(experiment_.validation, experiment_.robot).front();
    Identification result = result_;
    result.estimation.signal = {.rows = RowScheme::paper, .trim = {{0, 0}}};
    result.chi = chi;
    result.physical.reset();
    const Prediction prediction = predict(experiment_.robot, result, log);
    Matrix tau(prediction.samples(), experiment_.robot.size());
    for (Index j = 0; j < tau.cols(); ++j) {
      tau.col(j) = prediction.joints[static_cast<std::size_t>(j)].predicted;
    }
    return {differentiate(log.q, log.f_m), std::move(tau)};
  }

  [[nodiscard]] const Robot& robot() const { return experiment_.robot; }
  [[nodiscard]] const Identification& result() const { return result_; }

 private:
  Experiment experiment_;
  Identification result_;
};

TEST_F(IdentifiedScara, GivesTheTorquesThatPredictGives) {
  const auto [motion, estimate] = predicted(result().chi);
  const IdentifiedModelOptions plain = {.parameters = ParameterSet::estimate};
  expect_same(torques(read_identified_model(path(), plain), motion), estimate);
  expect_same(torques(identified_model(robot(), result(), plain), motion), estimate);
  const Matrix physical = predicted(result().physical.value().parameters.chi).second;
  expect_same(torques(read_identified_model(path()), motion), physical);
  expect_same(torques(identified_model(robot(), result()), motion), physical);
  EXPECT_GT((physical - estimate).norm(), 1e-6 * estimate.norm()) << "the two sets are told apart";
}

TEST_F(IdentifiedScara, MakesAControllerThatDoesNotAllocate) {
  InverseDynamics dynamics(read_identified_model(path()), {.smoothing_speed = Vector::Constant(2, 0.01)});
  const Vector q = Vector::Constant(2, 0.3);
  Vector tau(2);
  Matrix M(2, 2);
  const long count = test::allocations_of([&] {
    dynamics.torque(q, q, q, tau);
    dynamics.gravity(q, tau);
    dynamics.friction(q, tau);
    dynamics.M(q, M);
  });
  EXPECT_EQ(count, 0);
}

TEST_F(IdentifiedScara, IsRefusedWhereItIsNotIdentifiedUnlessForced) {
  Json json = content();
  json["status"] = "rank_deficient";
  json["reasons"] = {"MX2 is not determined"};
  write(json);
  expect_refused("the result is rank_deficient, not identified (MX2 is not determined)");
  EXPECT_EQ(read_identified_model(path(), {.force = true}).size(), 2);
  json["parameters"][4]["value"] = nullptr;
  write(json);
  EXPECT_EQ(read_identified_model(path(), {.force = true}).size(), 2) << "the physical set is determined";
  expect_refused("the value of \"MX2\" is null",
                 IdentifiedModelOptions{.parameters = ParameterSet::estimate, .force = true});
  Identification not_converged = result();
  not_converged.status = Status::not_converged;
  EXPECT_THROW((void)identified_model(robot(), not_converged), InputError);
  EXPECT_EQ(identified_model(robot(), not_converged, {.force = true}).size(), 2);
}

TEST_F(IdentifiedScara, TellsWhatIsMissingOrIsNoResult) {
  const Json json = content();
  const auto with = [&](const auto& edit) {
    Json other = json;
    edit(other);
    write(other);
  };
  with([](Json& j) { j.erase("physical"); });
  expect_refused("the result has no physically consistent parameters; identify with --physical",
                 IdentifiedModelOptions{.parameters = ParameterSet::physical});
  with([](Json& j) { j["physical"]["links"][1]["parameters"].erase(9); });
  expect_refused("M2 is missing");
  with([](Json& j) { j.erase("physical"), j["parameters"][4]["name"] = "MX3"; });
  expect_refused("\"MX3\" is none of the robot's 8 base parameters");
  with([](Json& j) { j["robot"]["joints"][1].erase("frame"); });
  expect_refused("robot.joints[1] has no \"frame\"");
  with([](Json& j) { j["robot"]["joints"][1]["frame"]["rotation"][0][0] = 0.5; });
  expect_refused("robot.joints[1].frame.rotation is no rotation");
  with([](Json& j) { j["robot"]["joints"][1]["frame"]["axes"] = {1, 1, 3}; });
  expect_refused("robot.joints[1].frame.axes must hold 1, 2 and 3");
  with([](Json& j) { j["robot"]["joints"][0]["friction"] = "sticky"; });
  expect_refused("robot.joints[0].friction is \"sticky\", must be one of \"none\"");
  with([](Json& j) { j["robot"]["gravity"] = {0.0, 9.81}; });
  expect_refused("robot.gravity has 2 numbers, must have 3");
  with([](Json& j) { j["robot"]["joints"] = Json::array(); });
  expect_refused("robot can not be used: the robot has no moving joint");
  with([](Json& j) { j["format"] = 2; });
  expect_refused("format is 2, this rivid knows 1");
  with([](Json& j) { j.erase("status"); });
  expect_refused("the file is no result.json of rivid identify");
  with([](Json& j) { j = Json::array({1}); });
  expect_refused("the file is no result.json of rivid identify");
  write(std::string("{\"format\": "));
  expect_refused("parse error");
  std::filesystem::remove(path());
  expect_refused("");
}

TEST_F(IdentifiedScara, BelongsToItsRobotWhateverItsFrictionLaws) {
  const Robot same = read_urdf(scara_file.parent_path() / "scara.urdf",
                               {.base = "", .tip = "", .gravity = {0.0, 0.0, -9.81}});
  ASSERT_NE(same.joints[0].friction, robot().joints[0].friction);
  const DynamicModel model = read_identified_model(path(), same);
  EXPECT_EQ(model.joints()[0].friction, robot().joints[0].friction);

  Robot other = same;
  other.chain.gravity.z() = -9.80665;
  expect_refused(
      "robot is another one than \"scara\": gravity is [0, 0, -9.81] here and [0, 0, -9.80665] there", other);
  other = same;
  other.chain.links[1].p.x() += 1e-6;
  expect_refused(
      "joint \"joint_2\": its origin in the frame before it is [0.5, 0, 0] here and [0.500001, 0, 0]", other);
  other = same;
  other.chain.links[1].R = Eigen::AngleAxisd(1e-6, Eigen::Vector3d::UnitX()).toRotationMatrix();
  expect_refused("joint \"joint_2\": its axis z in the frame before it is [0, 0, 1] here", other);
  other = same;
  other.joints[0].name = "shoulder";
  expect_refused("joint 1 is \"joint_1\" here and \"shoulder\" there", other);
  other = same;
  other.joints[1].type = other.chain.links[1].type = JointType::prismatic;
  expect_refused("joint \"joint_2\": its type is revolute here and prismatic there", other);
  expect_refused("the number of joints is 2 here and 1 there", test::slider());
}

TEST_F(IdentifiedScara, InMemoryIsRefusedForAnotherRobot) {
  Robot other = robot();
  other.joints[0].friction = Friction::viscous;
  EXPECT_THROW((void)identified_model(other, result()), InputError);
  EXPECT_THROW((void)identified_model(other, result(), {.parameters = ParameterSet::estimate}), InputError);
  Identification plain = result();
  plain.physical.reset();
  EXPECT_THROW((void)identified_model(robot(), plain, {.parameters = ParameterSet::physical}), InputError);
}

}  // namespace
}  // namespace rivid
