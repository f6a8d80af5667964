#include <gtest/gtest.h>

#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/model/urdf.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

class ParameterFile : public testing::Test {
 protected:
  ParameterFile() : robot_(read_urdf(RIVID_DATA "/scara/scara.urdf")) {
    for (Joint& joint : robot_.joints) {
      joint.friction = Friction::coulomb;
      joint.rotor_inertia = false;
    }
    base_ = base_parameters(robot_);
  }

  [[nodiscard]] Vector read(const std::string& name, const std::string& text) const {
    folder_.write(name, text);
    return read_parameters(folder_.path() / name, base_);
  }

  [[nodiscard]] std::string refusal(const std::string& name, const std::string& text) const {
    return test::complaint_of([&] { return read(name, text); });
  }

  void expect_refused(const std::string& name, const std::string& text, std::string_view words) const {
    const std::string told = refusal(name, text);
    EXPECT_NE(told.find(words), std::string::npos) << told << "\nis without\n" << words;
  }

  Robot robot_;
  BaseParameters base_;
  test::TemporaryFolder folder_;
  const Vector chi_{{3.4, 0.03, 0.8, 0.06, 0.2, 0.01, 0.02, 0.1}};
  const std::string toml_ =
      "ZZ1R = 3.4\nFv1 = 0.03\nFc1 = 0.8\nZZ2 = 0.06\nMX2 = 0.2\nMY2 = 0.01\nFv2 = 0.02\nFc2 = 0.1\n";
};

TEST_F(ParameterFile, OfBaseParametersIsReadInEveryForm) {
  const std::string csv =
      "name,unit,value\nFc2,Nm,0.1\nZZ1R,-,3.4\nFv1,-,0.03\nFc1,-,0.8\nZZ2,-,0.06\nMX2,-,0.2\nMY2,-,0."
      "01\nFv2,-,0.02\n";
  const std::string object =
      R"({"parameters": {"ZZ1R": 3.4, "Fv1": {"value": 0.03}, "Fc1": 0.8, "ZZ2": 0.06, "MX2": 0.2, "MY2": 0.01,
          "Fv2": 0.02, "Fc2": 0.1}, "robot": "scara"})";
  const std::string list =
      R"({"parameters": [{"name": "ZZ1R", "value": 3.4}, {"name": "Fv1", "value": 0.03}, {"name": "Fc1", "value": 0.8},
          {"name": "ZZ2", "value": 0.06}, {"name": "MX2", "value": 0.2}, {"name": "MY2", "value": 0.01},
          {"name": "Fv2", "value": 0.02}, {"name": "Fc2", "value": 0.1}]})";
  EXPECT_EQ(base_.from_standard(read("a.toml", toml_)), chi_);
  EXPECT_EQ(base_.from_standard(read("b.toml", "[parameters]\n" + toml_)), chi_);
  EXPECT_EQ(base_.from_standard(read("c.csv", csv)), chi_);
  EXPECT_EQ(base_.from_standard(read("d.json", object)), chi_);
  EXPECT_EQ(base_.from_standard(read("e.json", list)), chi_);
}

TEST_F(ParameterFile, OfStandardParametersIsTakenAsItIs) {
  const Vector chi_st = robot_.chi_st();
  std::string text = "name,value\n";
  for (std::size_t i = 0; i < base_.standard.size(); ++i) {
    text += base_.standard[i].name() + "," + std::to_string(chi_st[static_cast<Index>(i)]) + "\n";
  }
  EXPECT_LT((read("standard.csv", text) - chi_st).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(ParameterFile, RefusesNamesThatTheRobotDoesNotHave) {
  std::string text = toml_;
  text.replace(text.find("MX2"), 3, "mX2");
  expect_refused("a.toml", text, "\"mX2\" is none of the robot's 8 base parameters, ZZ1R, Fv1");
  expect_refused("a.toml", text, "did you mean \"MX2\"?");
  expect_refused("b.toml", toml_ + "off1 = 0\n", "\"off1\" is none of the robot's 8 base parameters");
}

TEST_F(ParameterFile, NamesWhatIsMissing) {
  expect_refused("a.toml", toml_.substr(0, toml_.find("Fv2")),
                 "Fv2, Fc2 are missing; a parameter file names all of the robot's 8 base or all of its 24");
}

TEST_F(ParameterFile, RefusesWhatIsNoNumber) {
  expect_refused("a.toml", "ZZ1R = \"3.4\"\n", "a.toml:1:8: ZZ1R must be a number");
  expect_refused("b.json", R"({"ZZ1R": null})",
                 "the value of \"ZZ1R\" is null, must be a number; null is a parameter not determined");
  expect_refused("c.csv", "name,value\nZZ1R,inf\n", "c.csv:2: column \"value\" holds \"inf\"");
  expect_refused("d.csv", "name,value\nZZ1R,1\nZZ1R,2\n", "\"ZZ1R\" is there twice");
  expect_refused("e.csv", "parameter,value\nZZ1R,1\n", "the header has no column \"name\"");
  expect_refused("f.json", "{", "f.json: ");
  expect_refused("g.json", "[1]", "each of \"parameters\" must have a name and a value");
  expect_refused("h.yaml", toml_, "h.yaml: a parameter file is called .json, .toml or .csv");
  EXPECT_THROW((void)read_parameters(folder_.path() / "none.toml", base_), InputError);
}

}  // namespace
}  // namespace rivid
