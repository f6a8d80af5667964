// An arm with a box on every link and a tool of a mesh, above a floor and beside a table: the distances that
// are reported against those of FCL's boxes and triangles, with frames from urdfdom.

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "rivid/error.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/excitation.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

// A wedge on the flange, whose edge is 0.25 m before it.
constexpr std::array<std::array<double, 3>, 6> wedge = {{{-0.05, -0.08, 0},
                                                         {0.05, -0.08, 0},
                                                         {0.05, 0.08, 0},
                                                         {-0.05, 0.08, 0},
                                                         {0, -0.2, 0.25},
                                                         {0, 0.2, 0.25}}};
constexpr std::array<std::array<std::size_t, 3>, 8> faces = {
    {{0, 1, 2}, {0, 2, 3}, {0, 1, 4}, {2, 3, 5}, {1, 2, 5}, {1, 5, 4}, {3, 0, 4}, {3, 4, 5}}};

std::string link(const std::string& name, const std::string& geometry, double z) {
  return "<link name=\"" + name +
         "\"><inertial><origin xyz=\"0 0 0.2\"/><mass value=\"4\"/><inertia ixx=\"0.08\" ixy=\"0\" ixz=\"0\" "
         "iyy=\"0.08\" iyz=\"0\" izz=\"0.02\"/></inertial><collision><origin xyz=\"0 0 " +
         std::to_string(z) + "\"/><geometry>" + geometry + "</geometry></collision></link>\n";
}

std::string joint(const std::string& number, const std::string& parent, const std::string& axis, double z) {
  return "<joint name=\"j" + number + "\" type=\"revolute\"><parent link=\"" + parent +
         "\"/><child link=\"link" + number + "\"/><origin xyz=\"0 0 " + std::to_string(z) +
         "\"/><axis xyz=\"" + axis +
         "\"/><limit lower=\"-2.6\" upper=\"2.6\" velocity=\"2\" effort=\"300\"/></joint>\n";
}

class Bodies : public testing::Test {
 protected:
  Bodies() {
    folder_.write(
        "arm.urdf",
        "<robot name=\"arm\">\n" + link("base", R"(<box size="0.3 0.3 0.2"/>)", 0.1) +
            link("link1", R"(<box size="0.2 0.2 0.2"/>)", 0.1) +
            link("link2", R"(<box size="0.16 0.12 0.5"/>)", 0.2) +
            link("link3", R"(<box size="0.12 0.3 0.4"/>)", 0.15) +
            link("tool", R"(<mesh filename="tool.obj"/>)", 0.0) + joint("1", "base", "0 0 1", 0.2) +
            joint("2", "link1", "0 1 0", 0.2) + joint("3", "link2", "0 1 0", 0.45) +
            "<joint name=\"f\" type=\"fixed\"><parent link=\"link3\"/><child link=\"tool\"/><origin "
            "xyz=\"0 0 0.35\" rpy=\"0 0.4 0\"/></joint></robot>\n");
    std::ostringstream mesh;
    for (const auto& v : wedge) {
      mesh << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
    }
    folder_.write("tool.obj", mesh.str());
    folder_.write("excite.toml", R"([robot]
urdf = "arm.urdf"
[excitation]
duration = 8
rate_hz = 100
starts = 1
evaluations = 100
noise = [1, 1, 1]
[excitation.limits]
acceleration = [8, 8, 8]
[excitation.space]
floor = 0
boxes = [{ name = "table", min = [0.45, -0.4, 0], max = [0.9, 0.4, 0.3] }]
)");
    model_ = urdf::parseURDFFile((folder_.path() / "arm.urdf").string());
  }

  [[nodiscard]] ExcitationPlan plan(const std::vector<std::string>& settings = {}) const {
    return read_excitation(folder_.path() / "excite.toml", settings);
  }

  // Smallest distances of the links over a motion by FCL: {link, link or obstacle}.
  std::map<std::pair<std::string, std::string>, double> by_fcl(const Reference& reference) const;

  test::TemporaryFolder folder_;
  urdf::ModelInterfaceSharedPtr model_;
};

fcl::Transform3d pose_of(const urdf::Pose& pose) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z)
                     .toRotationMatrix();
  out.translation() = fcl::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return out;
}

struct Solid {
  std::string owner;  // link of the robot, or obstacle
  std::string frame;
  std::shared_ptr<fcl::CollisionGeometryd> shape;
  fcl::Transform3d at;
};

std::shared_ptr<fcl::CollisionGeometryd> triangles() {
  auto out = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  std::vector<fcl::Vector3d> points;
  for (const auto& v : wedge) {
    points.emplace_back(v[0], v[1], v[2]);
  }
  std::vector<fcl::Triangle> all;
  for (const auto& f : faces) {
    all.emplace_back(f[0], f[1], f[2]);
  }
  out->beginModel();
  out->addSubModel(points, all);
  out->endModel();
  return out;
}

std::map<std::pair<std::string, std::string>, double> Bodies::by_fcl(const Reference& reference) const {
  std::vector<Solid> solids;
  for (const auto& [name, item] : model_->links_) {
    const auto& geometry = item->collision->geometry;
    std::shared_ptr<fcl::CollisionGeometryd> shape;
    if (const auto box = std::dynamic_pointer_cast<urdf::Box>(geometry)) {
      shape = std::make_shared<fcl::Boxd>(box->dim.x, box->dim.y, box->dim.z);
    } else {
      shape = triangles();
    }
    solids.push_back({name == "tool" ? "link3" : name, name, shape, pose_of(item->collision->origin)});
  }
  const auto add = [&](const std::string& name, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const Eigen::Vector3d size = high - low;
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.translation() = 0.5 * (low + high);
    solids.push_back({name, "", std::make_shared<fcl::Boxd>(size.x(), size.y(), size.z()), at});
  };
  add("table", {0.45, -0.4, 0}, {0.9, 0.4, 0.3});
  add("floor", {-5, -5, -1}, {5, 5, 0});
  std::map<std::pair<std::string, std::string>, double> out;
  constexpr Index intervals = 1600;
  Vector q(3);
  Vector qd(3);
  Vector qdd(3);
  for (Index k = 0; k <= intervals; ++k) {
    reference.at(reference.duration() * static_cast<double>(k) / intervals, q, qd, qdd);
    std::map<std::string, fcl::Transform3d> frames = {{"", fcl::Transform3d::Identity()}};
    for (const auto& [name, item] : model_->links_) {
      fcl::Transform3d at = fcl::Transform3d::Identity();
      for (urdf::LinkConstSharedPtr up = item; up->parent_joint;
           up = model_->getLink(up->parent_joint->parent_link_name)) {
        const urdf::Joint& j = *up->parent_joint;
        fcl::Transform3d turn = fcl::Transform3d::Identity();
        if (j.type != urdf::Joint::FIXED) {
          turn.linear() =
              Eigen::AngleAxisd(q[j.name.back() - '1'], Eigen::Vector3d(j.axis.x, j.axis.y, j.axis.z))
                  .toRotationMatrix();
        }
        at = pose_of(j.parent_to_joint_origin_transform) * turn * at;
      }
      frames[name] = at;
    }
    for (const Solid& a : solids) {
      for (const Solid& b : solids) {
        if (a.frame.empty() || a.owner == b.owner) {
          continue;
        }
        fcl::DistanceRequestd request;
        request.gjk_solver_type = fcl::GST_LIBCCD;
        request.distance_tolerance = 1e-8;
        fcl::DistanceResultd result;
        fcl::distance(a.shape.get(), frames[a.frame] * a.at, b.shape.get(), frames[b.frame] * b.at, request,
                      result);
        double& least =
            out.try_emplace({a.owner, b.owner}, std::numeric_limits<double>::infinity()).first->second;
        least = std::min(least, result.min_distance);
      }
    }
  }
  return out;
}

TEST_F(Bodies, OfAnArmWithABoxOnEveryLinkAreKeptClear) {
  const ExcitationPlan asked = plan();
  EXPECT_EQ(asked.inputs().back().filename(), "tool.obj");
  const Excitation found = design(asked.experiment.robot, asked.options);
  const auto nearest = by_fcl(*found.reference());
  int kept = 0;
  for (const ClearanceUse& use : found.forecast.clearances) {
    const double distance = nearest.at({use.first, use.second});
    if (!std::isnan(use.wanted)) {
      ++kept;
      EXPECT_GE(distance, 0.03 - 1e-3) << use.first << ", " << use.second;
      EXPECT_NEAR(distance, use.distance, 5e-4) << use.first << ", " << use.second;
    }
  }
  // Each of three links from floor and table, the first one from the table alone: it stands there; the base
  // from the second and third link, and the first from the third.
  EXPECT_GE(kept, 7);
  // What touches in all poses is said.
  const auto said = std::ranges::find(found.forecast.findings, "clearance_left_out", &Finding::code);
  ASSERT_NE(said, found.forecast.findings.end());
  EXPECT_NE(said->text.find("base and link1"), std::string::npos) << said->text;
  EXPECT_EQ(std::ranges::find(found.forecast.findings, "body_assumed", &Finding::code),
            found.forecast.findings.end());
}

// Without shapes, as before there were any, the same arm goes through the floor and nobody says so.
TEST_F(Bodies, MakeADifference) {
  ExcitationPlan asked = plan();
  asked.options.space.model = {};
  const Excitation found = design(asked.experiment.robot, asked.options);
  EXPECT_GE(found.forecast.clearances.front().distance, 0.03 - 1e-3);
  EXPECT_LE(by_fcl(*found.reference()).at({"link3", "floor"}), 0.0);
  const auto said = std::ranges::find(found.forecast.findings, "body_assumed", &Finding::code);
  ASSERT_NE(said, found.forecast.findings.end());
  EXPECT_NE(said->text.find("0.06 m"), std::string::npos) << said->text;
}

// Beside the table, on the side where the straight way to the other passes through it.
TEST_F(Bodies, AreKeptClearOnTheWayToTheMotionAndBack) {
  ExcitationPlan asked = plan({"excitation.evaluations=20", "excitation.start=[-2.0, 1.3, 0.9]",
                               "excitation.lead_from=[2.0, 1.3, 0.9]"});
  const Excitation found = design(asked.experiment.robot, asked.options);
  EXPECT_EQ(found.lead_in.value().via.rows(), 3);
  const auto nearest = by_fcl(*found.reference());
  for (const ClearanceUse& use : found.forecast.clearances) {
    if (!std::isnan(use.wanted)) {
      EXPECT_GE(nearest.at({use.first, use.second}), 0.03 - 1e-3) << use.first << ", " << use.second;
      EXPECT_GE(use.distance, 0.03 - 1e-3) << use.first << ", " << use.second;
    }
  }
}

TEST_F(Bodies, ThatKeepFromAPoseAreNamedWithThePlace) {
  ExcitationPlan asked = plan({"excitation.evaluations=20", "excitation.lead_from=[0.0, 1.5, 0.8]"});
  try {
    (void)design(asked.experiment.robot, asked.options);
    FAIL() << "no message";
  } catch (const InputError& e) {
    const std::string said = e.what();
    EXPECT_NE(said.find("lead_from: on the straight way at "), std::string::npos) << said;
    EXPECT_NE(said.find("link3 is "), std::string::npos) << said;
    EXPECT_NE(said.find(" m from table where it must be at least 0.03 m"), std::string::npos) << said;
  }
}

TEST_F(Bodies, NeedNoDistanceWhereTheyAreIgnored) {
  const ExcitationPlan asked =
      plan({"excitation.space.ignored=[{first=\"link3\", second=\"base\"}]", "excitation.evaluations=20"});
  const Excitation found = design(asked.experiment.robot, asked.options);
  const auto use = std::ranges::find_if(found.forecast.clearances, [](const ClearanceUse& each) {
    return each.first == "base" && each.second == "link3";
  });
  ASSERT_NE(use, found.forecast.clearances.end());
  EXPECT_TRUE(std::isnan(use->wanted));
}

}  // namespace
}  // namespace rivid
