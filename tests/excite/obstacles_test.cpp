// Designed motions among obstacles, checked by FCL with frames from the URDF. RIVID_OBSTACLE_SEEDS says how
// many seeds an arm; by default one, which takes seconds.

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cstdlib>
#include <filesystem>

#include "rivid/error.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/simulate/references.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

struct Arm {
  std::string name;
  std::filesystem::path file;  // in RIVID_DATA, or RIVID_REAL_DATA
  double floor;                // m, below what moves over it
  double reach;                // m
};

void PrintTo(const Arm& arm, std::ostream* out) { *out << arm.name; }

fcl::Transform3d pose_of(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix();
  out.translation() = fcl::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return out;
}

// Frame of a link in that of the base, joint by joint of the file.
fcl::Transform3d frame_of(const urdf::ModelInterface& model, const Robot& robot, const std::string& link,
                          const Vector& q) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  for (std::string at = link; at != robot.base;) {
    const urdf::JointConstSharedPtr joint = model.getLink(at)->parent_joint;
    fcl::Transform3d turn = fcl::Transform3d::Identity();
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      if (robot.joints[j].name == joint->name) {
        turn.linear() =
            Eigen::AngleAxisd(q[static_cast<Index>(j)],
                              Eigen::Vector3d(joint->axis.x, joint->axis.y, joint->axis.z).normalized())
                .toRotationMatrix();
      }
    }
    out = pose_of(joint->parent_to_joint_origin_transform) * turn * out;
    at = joint->parent_link_name;
  }
  return out;
}

struct Placed {
  std::string name;
  std::shared_ptr<fcl::CollisionGeometryd> shape;
  fcl::Transform3d at;
};

Placed capsule(const std::string& name, const fcl::Vector3d& from, const fcl::Vector3d& to, double radius) {
  fcl::Transform3d at = fcl::Transform3d::Identity();
  at.translation() = 0.5 * (from + to);
  const double length = (to - from).norm();
  if (length < 1e-9) {
    return {name, std::make_shared<fcl::Sphered>(radius), at};
  }
  at.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), to - from).toRotationMatrix();
  return {name, std::make_shared<fcl::Capsuled>(radius, length), at};
}

Placed plate(const Box& box) {
  const Eigen::Vector3d side = box.max - box.min;
  fcl::Transform3d at = fcl::Transform3d::Identity();
  at.translation() = 0.5 * (box.min + box.max);
  return {box.name, std::make_shared<fcl::Boxd>(side.x(), side.y(), side.z()), at};
}

double distance_of(const Placed& a, const Placed& b) {
  fcl::DistanceRequestd request;
  request.gjk_solver_type = fcl::GST_LIBCCD;
  request.distance_tolerance = 1e-8;
  fcl::DistanceResultd result;
  fcl::distance(a.shape.get(), a.at, b.shape.get(), b.at, request, result);
  return result.min_distance;
}

// The default bodies of arms of revolute joints, between the origins of their frames.
std::vector<Placed> bodies(const urdf::ModelInterface& model, const Robot& robot, const Vector& q,
                           double radius) {
  std::vector<fcl::Vector3d> origins = {fcl::Vector3d::Zero()};
  std::vector<Placed> out;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    origins.push_back(frame_of(model, robot, robot.joints[j].link, q).translation());
    const auto parent = static_cast<std::size_t>(robot.chain.parent(j) + 1);
    out.push_back(capsule(parent == 0 ? robot.base : robot.joints[parent - 1].link, origins[parent],
                          origins[j + 1], radius));
  }
  return out;
}

class Obstacles : public testing::TestWithParam<Arm> {};

// A floor, two walls and a table within the reach.
Space cell(const Arm& arm) {
  Space out;
  out.half_spaces = {{.name = "floor", .normal = {0, 0, 1}, .offset = arm.floor},
                     {.name = "wall", .normal = {1, 0, 0}, .offset = -0.7 * arm.reach},
                     {.name = "other_wall", .normal = {0, -1, 0}, .offset = -0.8 * arm.reach}};
  out.boxes = {{.name = "table",
                .min = {0.5 * arm.reach, -0.4 * arm.reach, arm.floor},
                .max = {0.9 * arm.reach, 0.4 * arm.reach, arm.floor + 0.15 * arm.reach}}};
  return out;
}

// The half-spaces of a cell as thick plates, of which FCL knows distances.
std::vector<Placed> obstacles(const Arm& arm, const Space& space) {
  constexpr double far = 8.0;
  constexpr double thick = 2.0;
  const double wall = -0.7 * arm.reach;
  const double other = 0.8 * arm.reach;
  return {plate({.name = "floor", .min = {-far, -far, arm.floor - thick}, .max = {far, far, arm.floor}}),
          plate({.name = "wall", .min = {wall - thick, -far, -far}, .max = {wall, far, far}}),
          plate({.name = "other_wall", .min = {-far, other, -far}, .max = {far, other + thick, far}}),
          plate(space.boxes.front())};
}

TEST_P(Obstacles, AreKeptAwayFromOrTheirPairIsNamed) {
  const Arm& arm = GetParam();
  if (!std::filesystem::exists(arm.file)) {
    GTEST_SKIP() << arm.file << " is not there";
  }
  const char* const text = std::getenv("RIVID_OBSTACLE_SEEDS");
  const int seeds = text != nullptr ? std::atoi(text) : 1;
  const Robot robot = read_urdf(arm.file.string());
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDFFile(arm.file.string());
  ExcitationOptions options{
      .duration = 10.0, .rate_hz = 200.0, .starts = 1, .evaluations = seeds > 1 ? 400 : 40};
  options.limits.acceleration = Vector::Constant(robot.size(), 8.0);
  options.noise.sigma = Vector::Constant(robot.size(), 1.0);
  options.space = cell(arm);
  const std::vector<Placed> around = obstacles(arm, options.space);
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    try {
      const Excitation found = design(robot, options);
      // Twice as many instants as are played.
      const std::unique_ptr<const Reference> reference = found.reference();
      constexpr Index intervals = 4000;
      std::map<std::pair<std::string, std::string>, double> nearest;
      Vector q(robot.size());
      Vector qd(q.size());
      Vector qdd(q.size());
      for (Index k = 0; k <= intervals; ++k) {
        reference->at(options.duration * static_cast<double>(k) / intervals, q, qd, qdd);
        const std::vector<Placed> links = bodies(*model, robot, q, options.space.radius);
        for (const ClearanceUse& use : found.forecast.clearances) {
          const auto first = std::ranges::find(links, use.first, &Placed::name);
          const auto obstacle = std::ranges::find(around, use.second, &Placed::name);
          const auto second =
              obstacle != around.end() ? obstacle : std::ranges::find(links, use.second, &Placed::name);
          double& least =
              nearest.try_emplace({use.first, use.second}, std::numeric_limits<double>::infinity())
                  .first->second;
          least = std::min(least, distance_of(*first, *second));
        }
      }
      std::size_t kept = 0;
      for (const ClearanceUse& use : found.forecast.clearances) {
        const double distance = nearest.at({use.first, use.second});
        if (std::isnan(use.wanted)) {
          continue;
        }
        ++kept;
        EXPECT_GE(distance, use.wanted - 1e-3) << "seed " << seed << ": " << use.first << ", " << use.second;
        // GJK to 2e-5, and other instants.
        EXPECT_NEAR(distance, use.distance, 2e-4)
            << "seed " << seed << ": " << use.first << ", " << use.second;
      }
      const ClearanceUse& least = found.forecast.clearances.front();
      std::cout << arm.name << ", seed " << seed << ": log det " << found.forecast.log_det << ", " << kept
                << " of " << nearest.size() << " pairs, nearest by FCL "
                << nearest.at({least.first, least.second}) << " m, " << least.first << " from "
                << least.second << '\n';
    } catch (const InputError& e) {
      const std::string said = e.what();
      EXPECT_NE(said.find(" m where it must be at least 0.03 m"), std::string::npos) << said;
      std::cout << arm.name << ", seed " << seed << ": " << said << '\n';
    }
  }
}

// A search that ends beyond its limits between the instants: what is left was a motion half as large.
TEST(ObstaclesOfASixAxisArm, CostTheFinishedMotionLittle) {
  const Arm arm{"six_axis", std::filesystem::path(RIVID_DATA) / "six_axis/six_axis.urdf", 0.0, 0.5};
  const Robot robot = read_urdf(arm.file.string());
  ExcitationOptions options{.duration = 10.0, .rate_hz = 200.0, .starts = 1, .seed = 800, .evaluations = 400};
  options.limits.acceleration = Vector::Constant(robot.size(), 8.0);
  options.noise.sigma = Vector::Constant(robot.size(), 1.0);
  options.space = cell(arm);
  const Excitation found = design(robot, options);
  EXPECT_GE(found.forecast.log_det, -found.starts.front().objective_end - 1.0);
  EXPECT_TRUE(std::ranges::none_of(found.forecast.findings, [](const Finding& each) {
    return each.code == std::string_view("polishing_lost");
  }));
}

std::string arm_text(const std::string& side, double y) {
  std::ostringstream out;
  std::string parent = "torso";
  const auto add = [&](const std::string& name, const std::string& axis, double x, double shift) {
    const std::string link = side + name;
    out << "<link name=\"" << link
        << "\"><inertial><origin xyz=\"0.15 0 0.02\"/><mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" "
           "ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.02\"/></inertial></link><joint name=\"to_"
        << link << "\" type=\"revolute\"><parent link=\"" << parent << "\"/><child link=\"" << link
        << "\"/><origin xyz=\"" << x << " " << shift << " 0\"/><axis xyz=\"" << axis
        << "\"/><limit lower=\"-1.6\" upper=\"1.6\" velocity=\"2\" effort=\"80\"/></joint>\n";
    parent = link;
  };
  add("shoulder", "0 0 1", 0.0, y);
  add("arm", "0 1 0", 0.05, 0.0);
  add("forearm", "0 0 1", 0.35, 0.0);
  add("hand", "1 0 0", 0.3, 0.0);
  return out.str();
}

// Two arms 0.5 m apart that reach 0.7 m: a design of both at once keeps each clear of the other.
TEST(ObstaclesOfTwoArms, AreEachOther) {
  test::TemporaryFolder folder;
  folder.write("two.urdf", "<robot name=\"two\"><link name=\"torso\"/>\n" + arm_text("left_", 0.25) +
                               arm_text("right_", -0.25) + "</robot>\n");
  const std::string file = (folder.path() / "two.urdf").string();
  const Robot robot = read_urdf(file);
  ASSERT_TRUE(robot.chain.branches());
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDFFile(file);
  ExcitationOptions options{.duration = 10.0, .rate_hz = 200.0, .starts = 1, .evaluations = 60};
  options.limits.acceleration = Vector::Constant(robot.size(), 8.0);
  options.noise.sigma = Vector::Constant(robot.size(), 1.0);
  const auto nearest = [&] {
    const Excitation found = design(robot, options);
    const std::unique_ptr<const Reference> reference = found.reference();
    double least = std::numeric_limits<double>::infinity();
    constexpr Index intervals = 4000;
    Vector q(robot.size());
    Vector qd(q.size());
    Vector qdd(q.size());
    for (Index k = 0; k <= intervals; ++k) {
      reference->at(options.duration * static_cast<double>(k) / intervals, q, qd, qdd);
      const std::vector<Placed> all = bodies(*model, robot, q, options.space.radius);
      for (const Placed& a : all) {
        for (const Placed& b : all) {
          if (a.name.starts_with("left_") && b.name.starts_with("right_")) {
            least = std::min(least, distance_of(a, b));
          }
        }
      }
    }
    return least;
  };
  EXPECT_LE(nearest(), 0.0);
  options.space.half_spaces = {{.name = "floor", .normal = {0, 0, 1}, .offset = -1.0}};  // out of reach
  EXPECT_GE(nearest(), options.space.clearance - 1e-3);
}

const std::filesystem::path data = RIVID_DATA;
const std::filesystem::path real = RIVID_REAL_DATA;

INSTANTIATE_TEST_SUITE_P(
    Arms, Obstacles,
    testing::Values(Arm{"six_axis", data / "six_axis/six_axis.urdf", 0.0, 0.5},
                    Arm{"scara", data / "scara/scara.urdf", -0.2, 1.0},
                    Arm{"ur5", std::filesystem::path(RIVID_TEST_DATA) / "excite/ur5.urdf", -0.05, 0.9},
                    Arm{"ur10e", real / "ur10e/ur10e.urdf", 0.0, 1.3},
                    Arm{"ur10", real / "ur10_vrep/ur10.urdf", 0.0, 1.3},
                    Arm{"panda", real / "panda/panda.urdf", 0.0, 0.85},
                    Arm{"kr300", real / "kuka_kr300/kr300.urdf", 0.0, 2.5}),
    [](const testing::TestParamInfo<Arm>& arm) { return arm.param.name; });

}  // namespace
}  // namespace rivid
