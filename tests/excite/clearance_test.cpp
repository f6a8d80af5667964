// Distances against those of FCL, and their derivatives against differences.

#include "excite/clearance.hpp"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <kdl/treefksolverpos_recursive.hpp>
#include <map>
#include <random>

#include "rivid/model/dependent.hpp"
#include "rivid/model/urdf.hpp"
#include "support/random_matrix.hpp"
#include "support/random_tree.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

struct Segment {
  Eigen::Vector3d from;
  Eigen::Vector3d to;

  [[nodiscard]] Eigen::Matrix3Xd points() const {
    Eigen::Matrix3Xd out(3, 2);
    out << from, to;
    return out;
  }
};

double distance_between(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return detail::separation({a}, {b}).distance;
}

Eigen::Matrix3Xd corners(const Box& box) {
  Eigen::Matrix3Xd out(3, 8);
  for (int k = 0; k < 8; ++k) {
    out.col(k) << ((k & 1) != 0 ? box.max : box.min).x(), ((k & 2) != 0 ? box.max : box.min).y(),
        ((k & 4) != 0 ? box.max : box.min).z();
  }
  return out;
}

// FCL's capsules lie along z about their middle.
fcl::Transform3d placed(const Segment& line) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), line.to - line.from).toRotationMatrix();
  out.translation() = 0.5 * (line.from + line.to);
  return out;
}

double distance_of(const fcl::CollisionGeometryd& a, const fcl::Transform3d& at,
                   const fcl::CollisionGeometryd& b, const fcl::Transform3d& bt) {
  fcl::DistanceRequestd request;
  request.gjk_solver_type = fcl::GST_LIBCCD;
  request.distance_tolerance = 1e-10;
  fcl::DistanceResultd result;
  fcl::distance(&a, at, &b, bt, request, result);
  return result.min_distance;
}

Segment random_segment(std::mt19937_64& random) {
  return {test::random_vector(random, 1.0), test::random_vector(random, 1.0)};
}

// What FCL leaves of its iteration.
constexpr double oracle_tolerance = 2e-5;

TEST(Distance, OfCapsulesIsThatOfFcl) {
  std::mt19937_64 random(5);
  int apart = 0;
  for (int k = 0; k < 500; ++k) {
    const Segment a = random_segment(random);
    const Segment b = random_segment(random);
    const double radius = 0.05;
    const double own = distance_between(a.points(), b.points()) - 2.0 * radius;
    if (own < 0.01) {
      continue;
    }
    ++apart;
    const fcl::Capsuled first(radius, (a.to - a.from).norm());
    const fcl::Capsuled second(radius, (b.to - b.from).norm());
    EXPECT_NEAR(own, distance_of(first, placed(a), second, placed(b)), oracle_tolerance) << "draw " << k;
  }
  EXPECT_GE(apart, 300);
}

TEST(Distance, FromABoxIsThatOfFcl) {
  std::mt19937_64 random(6);
  int apart = 0;
  for (int k = 0; k < 500; ++k) {
    const Segment a = random_segment(random);
    const Eigen::Vector3d corner = test::random_vector(random, 1.0);
    const Box box{.min = corner, .max = corner + Eigen::Vector3d(0.3, 0.5, 0.2)};
    const double radius = 0.05;
    const double own = distance_between(a.points(), corners(box)) - radius;
    if (own < 0.01) {
      continue;
    }
    ++apart;
    const fcl::Capsuled first(radius, (a.to - a.from).norm());
    const fcl::Boxd second(0.3, 0.5, 0.2);
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.translation() = 0.5 * (box.min + box.max);
    EXPECT_NEAR(own, distance_of(first, placed(a), second, at), oracle_tolerance) << "draw " << k;
  }
  EXPECT_GE(apart, 200);
}

TEST(Distance, OfParallelAndShortSegmentsIsTheirs) {
  const auto of = [](const Segment& a, const Segment& b) { return distance_between(a.points(), b.points()); };
  const Segment a{{0, 0, 0}, {1, 0, 0}};
  EXPECT_NEAR(of(a, {{0.5, 1, 0}, {3, 1, 0}}), 1.0, 1e-9);
  EXPECT_NEAR(of(a, {{2, 1, 0}, {3, 1, 0}}), std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(of(a, {{-1, 0, 0}, {-1, 0, 0}}), 1.0, 1e-9);
  EXPECT_NEAR(of({{2, 2, 0}, {2, 2, 0}}, a), std::sqrt(5.0), 1e-9);
  const Box box{.min = {2, -1, -1}, .max = {3, 1, 1}};
  EXPECT_NEAR(distance_between(a.points(), corners(box)), 1.0, 1e-9);
  EXPECT_NEAR(distance_between(Segment{{0, 0, 0}, {5, 0, 0}}.points(), corners(box)), -1.0, 1e-9);
  EXPECT_NEAR(distance_between(Segment{{0, 0, 0}, {0, 0, 1}}.points(), corners(box)), 2.0, 1e-9);
}

Matrix along(const detail::Clearances& clearances, const Vector& q, std::vector<Matrix>* slopes = nullptr) {
  return clearances.along(q.transpose(), 0.0, slopes);
}

Vector at(const detail::Clearances& clearances, const Vector& q) {
  return along(clearances, q).row(0).transpose();
}

Space surroundings() {
  Space out;
  out.half_spaces = {{.name = "floor", .normal = {0, 0, 2}, .offset = -3.0},
                     {.name = "wall", .normal = {1, 1, 0}, .offset = -4.0}};
  out.boxes = {{.name = "table", .min = {1.5, -1.0, -1.0}, .max = {2.0, 1.0, 0.2}}};
  return out;
}

// One joint of a tree follows two others by a sum, another one by a curve.
Robot dependent_tree() {
  test::RandomChain draw(4);
  const Robot tree = test::frictionless(test::random_tree(draw, 9));
  const Vector x = Vector::LinSpaced(200, -2.5, 2.5);
  return with_dependents(
      tree, std::vector<DependentJoint>{{.joint = tree.joints[2].name,
                                         .of = {{tree.joints[1].name, -0.7}, {tree.joints[4].name, 1.2}},
                                         .offset = 0.3},
                                        {.joint = tree.joints[0].name,
                                         .of = {{tree.joints[3].name, 1.0}},
                                         .curve = spline_through(x, x.array().sin().matrix())}});
}

TEST(Clearances, HaveExactSlopes) {
  std::mt19937_64 random(9);
  std::vector<Robot> robots = {read_urdf(RIVID_DATA "/six_axis/six_axis.urdf"), test::random_robot(6, random),
                               dependent_tree()};
  for (int k = 0; k < 5; ++k) {
    test::RandomChain draw(static_cast<std::uint64_t>(k));
    robots.push_back(test::frictionless(test::random_tree(draw, 8)));
  }
  for (const Robot& robot : robots) {
    const Index n = robot.size();
    std::vector<Finding> findings;
    detail::Clearances clearances(robot, surroundings(), Vector::Constant(n, -2.0), Vector::Constant(n, 2.0),
                                  findings);
    ASSERT_GE(clearances.size(), 6);
    std::uniform_real_distribution<double> within(-2.0, 2.0);
    constexpr double h = 1e-6;
    for (int k = 0; k < 20; ++k) {
      const Vector q = Vector::NullaryExpr(n, [&] { return within(random); });
      std::vector<Matrix> slopes;
      const Vector d = along(clearances, q, &slopes).row(0).transpose();
      for (Index j = 0; j < n; ++j) {
        const Vector up = at(clearances, q + h * Vector::Unit(n, j));
        const Vector down = at(clearances, q - h * Vector::Unit(n, j));
        for (Index p = 0; p < clearances.size(); ++p) {
          // Where the nearest points jump, or bodies overlap, there is no derivative.
          const double left = (d[p] - down[p]) / h;
          const double right = (up[p] - d[p]) / h;
          if (std::abs(left - right) < 1e-3 && d[p] > 0.0) {
            EXPECT_NEAR(slopes[static_cast<std::size_t>(p)](0, j), 0.5 * (left + right), 2e-5)
                << robot.name << ": " << clearances.first(p) << ", " << clearances.second(p) << ", joint "
                << j + 1;
          }
        }
      }
    }
  }
}

// What is shown of one pose by the one before changes nothing that matters.
TEST(Clearances, AlongAMotionAreThoseOfItsPoses) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> within(-0.3, 0.3);
  const auto point = [&] { return Eigen::Vector3d::NullaryExpr([&] { return within(random); }).eval(); };
  constexpr double beyond = 0.02;
  Index near = 0;
  Index bounds = 0;
  for (int k = 0; k < 6; ++k) {
    const Robot robot = test::random_robot(6, random);
    Space space = surroundings();
    for (const Joint& joint : robot.joints) {
      for (int part = 0; part < 3; ++part) {
        space.capsules.push_back({.link = joint.link, .from = point(), .to = point(), .radius = 0.02});
      }
    }
    const Vector bound = Vector::Constant(6, 2.0);
    std::vector<Finding> findings;
    const detail::Clearances clearances(robot, space, -bound, bound, findings);
    constexpr Index samples = 300;
    Matrix q(samples, 6);
    for (Index j = 0; j < q.cols(); ++j) {
      const double phase = within(random);
      q.col(j) =
          Vector::LinSpaced(samples, 0.0, 6.0 + static_cast<double>(j)).array().unaryExpr([&](double t) {
            return 1.5 * std::sin(t + phase);
          });
    }
    std::vector<Matrix> slopes;
    const Matrix along = clearances.along(q, beyond, &slopes);
    const std::vector<ClearanceUse> whole =
        detail::checked_clearances(robot, space, clearances.kept(), q, 1.0);
    for (Index p = 0; p < clearances.size(); ++p) {
      double least = 1e9;
      for (Index i = 0; i < samples; ++i) {
        std::vector<Matrix> slope;
        const double d = rivid::along(clearances, q.row(i).transpose(), &slope)(0, p);
        if (d <= 0.0) {
          least = 0.0;  // of overlapping bodies each has a direction of its own
          break;
        }
        const bool is_bound = along(i, p) > least + beyond;
        near += is_bound ? 0 : 1;
        bounds += is_bound ? 1 : 0;
        if (is_bound) {
          EXPECT_LE(along(i, p), d + 1e-8);
        } else {
          EXPECT_NEAR(along(i, p), d, 1e-8);
          const auto of_pair = static_cast<std::size_t>(p);
          EXPECT_LT((slopes[of_pair].row(i) - slope[of_pair]).cwiseAbs().maxCoeff(), 1e-3);
        }
        least = std::min(least, d);
      }
      const auto use = std::ranges::find_if(whole, [&](const ClearanceUse& each) {
        return each.first == clearances.first(p) && each.second == clearances.second(p);
      });
      ASSERT_NE(use, whole.end());
      if (least > 0.0) {
        EXPECT_NEAR(use->distance, least, 1e-7) << use->first << ", " << use->second;
      }
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(bounds, 2 * near);
}

// The planar arm of the paper, whose joints are 0.5 m apart: by hand.
TEST(Clearances, AreThoseOfAPlanarArm) {
  Robot robot = test::scara();
  robot.base = "base";
  Space space;
  space.radius = 0.1;
  space.capsules = {{.link = "link_2", .from = {0, 0, 0}, .to = {0.4, 0, 0}, .radius = 0.1}};
  space.half_spaces = {{.name = "wall", .normal = {1, 0, 0}, .offset = -1.0}};
  std::vector<Finding> findings;
  detail::Clearances clearances(robot, space, Vector::Constant(2, -1.0), Vector::Constant(2, 1.0), findings);
  const Vector d = at(clearances, Eigen::Vector2d(3.14159265358979, 0.0));
  for (Index p = 0; p < clearances.size(); ++p) {
    if (clearances.second(p) == "wall") {
      const double reach = clearances.first(p) == "link_1" ? 0.5 : 0.9;
      EXPECT_NEAR(d[p], 1.0 - reach - 0.1, 1e-9) << clearances.first(p);
    }
  }
}

std::vector<std::string> seconds(const detail::Clearances& clearances, const std::string& first) {
  std::vector<std::string> out;
  for (Index p = 0; p < clearances.size(); ++p) {
    if (clearances.first(p) == first) {
      out.push_back(clearances.second(p));
    }
  }
  return out;
}

TEST(Clearances, NeverLeaveOutAnObstacleThatALinkMovesBeside) {
  const Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  Space space;
  space.half_spaces = {{.name = "ceiling", .normal = {0, 0, -1}, .offset = 5.0}};  // below the arm
  space.boxes = {{.name = "crate", .min = {-3, -3, -3}, .max = {3, 3, 3}}};        // around it
  std::vector<Finding> findings;
  const detail::Clearances clearances(robot, space, Vector::Constant(6, -2.0), Vector::Constant(6, 2.0),
                                      findings);
  for (const std::string link : {"arm", "elbow"}) {
    const std::vector<std::string> others = seconds(clearances, link);
    for (const std::string obstacle : {"ceiling", "crate"}) {
      EXPECT_NE(std::ranges::find(others, obstacle), others.end()) << link << ", " << obstacle;
    }
  }
  EXPECT_EQ(std::ranges::find(findings, "clearance_fixed", &Finding::code), findings.end());
}

// The first link of the KUKA and its like begins on the floor: no motion changes that, and none has to.
TEST(Clearances, TellHowFarTheFirstLinkIsFromWhatItStandsOn) {
  Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  Space space;
  space.capsules = {{.link = "shoulder", .from = {0, 0, -0.3}, .to = {0, 0, 0}, .radius = 0.06}};
  space.self_collision = false;
  space.half_spaces = {{.name = "floor", .normal = {0, 0, 1}, .offset = 0.0}};
  space.boxes = {{.name = "plinth", .min = {-0.2, -0.2, -0.5}, .max = {0.2, 0.2, 0.02}}};
  std::vector<Finding> findings;
  const Vector bound = Vector::Constant(6, 2.0);
  const detail::Clearances over(robot, space, -bound, bound, findings);
  EXPECT_TRUE(seconds(over, "shoulder").empty());
  const auto told = std::ranges::find(findings, "clearance_fixed", &Finding::code);
  ASSERT_NE(told, findings.end());
  EXPECT_EQ(told->subject, "shoulder");
  EXPECT_EQ(told->text,
            "is -0.04 m from floor in every pose, where 0.03 m is asked: it stands there, and no motion "
            "changes that");
  // A floor above that link, as of a number in millimetres, is not what it stands on.
  space.half_spaces.front().offset = 300.0;
  space.boxes.front().max.z() = 0.5;
  findings.clear();
  const detail::Clearances under(robot, space, -bound, bound, findings);
  const std::vector<std::string> others = seconds(under, "shoulder");
  EXPECT_EQ(std::ranges::count(others, std::string("floor")), 1);
  EXPECT_EQ(std::ranges::count(others, std::string("plinth")), 1);
}

// Beside a thick base the upper arm is always, and the flange in most poses.
TEST(Clearances, LeaveOutLinksThatAreNearInEveryPoseAlone) {
  const Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  Space space;
  space.capsules = {{.link = "base", .from = {0, 0, 0}, .to = {0, 0, 0.32}, .radius = 0.3},
                    {.link = "flange", .from = {0, 0, 0}, .to = {0, 0, 0.1}, .radius = 0.05}};
  std::vector<Finding> findings;
  const Vector bound = Vector::Constant(6, 2.0);
  detail::Clearances clearances(robot, space, -bound, bound, findings);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(-2.0, 2.0);
  const Matrix q = Matrix::NullaryExpr(2000, 6, [&] { return within(random); });
  Vector near = Vector::Zero(clearances.size());
  ASSERT_GT(near.size(), 0);
  for (Index k = 0; k < q.rows(); ++k) {
    const Vector d = at(clearances, q.row(k).transpose());
    near.array() += (d.array() < space.clearance).cast<double>();
  }
  // Some pair is near in most poses, and kept apart all the same.
  EXPECT_GT(near.maxCoeff(), 0.5 * static_cast<double>(q.rows()));
  EXPECT_LT(near.maxCoeff(), static_cast<double>(q.rows()));
  const std::vector<ClearanceUse> all = detail::checked_clearances(robot, space, clearances.kept(), q, 1.0);
  const auto left_out =
      std::ranges::count_if(all, [](const ClearanceUse& use) { return std::isnan(use.wanted); });
  EXPECT_EQ(std::ssize(all) - left_out, clearances.size());
  // One for each pair, and one that no shape is known of the others.
  EXPECT_EQ(std::ssize(findings), left_out + 1);
}

// A tree whose segments end where they turn or slide, along z of their tip.
KDL::Tree tree_along_z(test::RandomChain& draw, int segments) {
  KDL::Tree out("base");
  for (int i = 0; i < segments; ++i) {
    const KDL::Frame tip(draw.rotation(), draw.vector(0.5));
    const auto type = draw.integer(0, 3) == 0 ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
    const int hook = draw.integer(0, i);
    out.addSegment(KDL::Segment("link_" + std::to_string(i + 1),
                                KDL::Joint("joint_" + std::to_string(i + 1), tip.p, tip.M.UnitZ(), type), tip,
                                draw.body()),
                   hook == 0 ? "base" : "link_" + std::to_string(hook));
  }
  return out;
}

// Frames by KDL, distances by FCL: capsules of links of a tree, and of the base.
TEST(Clearances, OfTreesAreThoseOfFcl) {
  std::mt19937_64 random(5);
  int apart = 0;
  for (int k = 0; k < 20; ++k) {
    test::RandomChain draw(static_cast<std::uint64_t>(k));
    // A copy numbers the joints depth first, as that of the solver does.
    const KDL::Tree drawn = tree_along_z(draw, 8);
    const KDL::Tree tree(drawn);
    Robot robot = robot_from(tree);
    robot.base = "base";
    const auto n = static_cast<unsigned>(robot.size());
    std::map<std::string, Segment> lines = {{"base", random_segment(random)}};
    for (const Joint& joint : robot.joints) {
      lines[joint.link] = random_segment(random);
    }
    Space space;
    for (const auto& [link, line] : lines) {
      space.capsules.push_back({.link = link, .from = line.from, .to = line.to, .radius = 0.03});
    }
    std::vector<Finding> findings;
    const Vector bound = Vector::Constant(n, 2.0);
    const detail::Clearances clearances(robot, space, -bound, bound, findings);
    KDL::JntArray at(n);
    const Vector q = test::random_matrix(n, 1, static_cast<std::uint64_t>(k));
    for (unsigned j = 0; j < n; ++j) {
      at(GetTreeElementQNr(tree.getSegment(robot.joints[j].link)->second)) = q[j];
    }
    KDL::TreeFkSolverPos_recursive solver(tree);
    for (auto& [link, line] : lines) {
      KDL::Frame frame;
      ASSERT_EQ(solver.JntToCart(at, frame, link), 0);
      for (Eigen::Vector3d* const end : {&line.from, &line.to}) {
        const KDL::Vector x = frame * KDL::Vector(end->x(), end->y(), end->z());
        *end = {x.x(), x.y(), x.z()};
      }
    }
    const Vector d = rivid::at(clearances, q);
    for (Index p = 0; p < d.size(); ++p) {
      const Segment& a = lines.at(clearances.first(p));
      const Segment& b = lines.at(clearances.second(p));
      if (d[p] < 0.01) {
        continue;
      }
      ++apart;
      const fcl::Capsuled first(0.03, (a.to - a.from).norm());
      const fcl::Capsuled second(0.03, (b.to - b.from).norm());
      EXPECT_NEAR(d[p], distance_of(first, placed(a), second, placed(b)), oracle_tolerance)
          << k << ": " << clearances.first(p) << ", " << clearances.second(p);
    }
  }
  EXPECT_GE(apart, 200);
}

// Two codes that have nothing in common.
TEST(CheckedClearances, AreThoseOfTheSearch) {
  std::mt19937_64 random(12);
  for (const Robot& robot :
       {read_urdf(RIVID_DATA "/six_axis/six_axis.urdf"), test::random_robot(6, random), dependent_tree()}) {
    const Index n = robot.size();
    Space space = surroundings();
    space.capsules = {
        {.link = robot.joints[4].link, .from = {0.1, 0, 0}, .to = {0, 0.2, -0.1}, .radius = 0.02},
        {.link = robot.base, .from = {0, 0.1, 0}, .to = {0.3, 0, 0.2}, .radius = 0.03}};
    std::vector<Finding> findings;
    const Vector bound = Vector::Constant(n, 2.0);
    detail::Clearances clearances(robot, space, -bound, bound, findings);
    std::uniform_real_distribution<double> within(-2.0, 2.0);
    for (int k = 0; k < 50; ++k) {
      const Vector q = Vector::NullaryExpr(n, [&] { return within(random); });
      const Vector d = at(clearances, q);
      const std::vector<ClearanceUse> found =
          detail::checked_clearances(robot, space, clearances.kept(), q.transpose(), 1.0);
      EXPECT_TRUE(
          std::ranges::is_sorted(found.begin(), found.begin() + d.size(), {}, &ClearanceUse::distance));
      for (Index p = 0; p < d.size(); ++p) {
        const auto use = std::ranges::find_if(found, [&](const ClearanceUse& each) {
          return each.first == clearances.first(p) && each.second == clearances.second(p);
        });
        ASSERT_NE(use, found.end());
        EXPECT_NEAR(use->distance, d[p], 1e-7) << use->first << ", " << use->second;
        EXPECT_EQ(use->wanted, space.clearance);
      }
    }
  }
}

TEST(Space, RefusesWhatIsNoSpace) {
  const Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  Space space;
  space.capsules = {{.link = "forerm"}};
  EXPECT_NE(space.complaint(robot)->find("capsules: the robot has no link \"forerm\""), std::string::npos);
  space = {.boxes = {{.name = "table", .min = {1, 0, 0}, .max = {0, 1, 1}}}};
  EXPECT_EQ(*space.complaint(robot), "boxes: min of \"table\" must lie below its max along each axis");
  space = {.half_spaces = {{.name = "floor", .normal = {0, 0, 0}}}};
  EXPECT_EQ(*space.complaint(robot), "half_spaces: the normal of \"floor\" must not be zero");
  space = {.clearance = -1.0};
  EXPECT_EQ(*space.complaint(robot), "clearance is -1 m, must not be negative");
}

}  // namespace
}  // namespace rivid
