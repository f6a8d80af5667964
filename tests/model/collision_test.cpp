#include "rivid/model/collision.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "rivid/error.hpp"
#include "rivid/model/urdf.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double digits = 1e-6;  // of single precision, and of the texts below [m]

// An arm whose first joint turns about x, tilted frames, a flange behind a fixed joint.
std::string arm(const std::string& of_base, const std::string& of_first, const std::string& of_flange) {
  const std::string inertial =
      R"(<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>)";
  return R"(<robot name="arm"><link name="base">)" + of_base + R"(</link>
<link name="first">)" +
         inertial + of_first + R"(</link>
<link name="flange">)" +
         of_flange + R"(</link>
<joint name="j1" type="revolute"><parent link="base"/><child link="first"/><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="9"/></joint>
<joint name="f" type="fixed"><parent link="first"/><child link="flange"/><origin xyz="0 0.5 0" rpy="1.5707963267948966 0 0"/></joint>
</robot>)";
}

std::string body(const std::string& geometry, const std::string& origin = "") {
  return "<collision>" + origin + "<geometry>" + geometry + "</geometry></collision>";
}

class Collision : public testing::Test {
 protected:
  CollisionModel read(const std::string& of_base, const std::string& of_first,
                      const std::string& of_flange = "") {
    folder_.write("pkg/urdf/arm.urdf", arm(of_base, of_first, of_flange));
    const std::filesystem::path file = folder_.path() / "pkg/urdf/arm.urdf";
    return read_collision(file, read_urdf(file));
  }

  std::string message(const std::string& of_first) {
    try {
      (void)read("", of_first);
    } catch (const InputError& e) {
      return e.what();
    }
    return "nothing was refused";
  }

  void write_mesh(const std::string& name, const std::string& content) {
    folder_.write("pkg/meshes/" + name, content);
  }

  test::TemporaryFolder folder_;
};

// The lowest and the highest corner of a body.
std::pair<Vector3d, Vector3d> extent(const Hull& hull) {
  return {hull.points.rowwise().minCoeff().array() - hull.radius,
          hull.points.rowwise().maxCoeff().array() + hull.radius};
}

void expect_extent(const Hull& hull, const Vector3d& low, const Vector3d& high, double tolerance) {
  const auto [lowest, highest] = extent(hull);
  EXPECT_TRUE(lowest.isApprox(low, tolerance) || (lowest - low).norm() < tolerance) << lowest.transpose();
  EXPECT_TRUE((highest - high).norm() < tolerance) << highest.transpose();
}

TEST_F(Collision, HasTheShapesWhereTheyAre) {
  const CollisionModel found = read(body(R"(<box size="0.2 0.4 0.6"/>)", R"(<origin xyz="0 0 0.3"/>)"),
                                    body(R"(<cylinder radius="0.05" length="0.4"/>)",
                                         R"(<origin xyz="0 0.2 0" rpy="1.5707963267948966 0 0"/>)") +
                                        body(R"(<sphere radius="0.07"/>)"),
                                    body(R"(<box size="0.1 0.2 0.3"/>)", R"(<origin xyz="0 0 -0.15"/>)"));
  ASSERT_EQ(found.hulls.size(), 4U);
  EXPECT_EQ(found.hulls[0].link, "base");
  expect_extent(found.hulls[0], {-0.1, -0.2, 0.0}, {0.1, 0.2, 0.6}, 1e-12);
  // Along y, within 0.5 % of its radius, and never inside of it.
  EXPECT_EQ(found.hulls[1].link, "first");
  expect_extent(found.hulls[1], {-0.05, 0, -0.05}, {0.05, 0.4, 0.05}, 1e-3);
  EXPECT_GT(extent(found.hulls[1]).second.y(), 0.4);
  expect_extent(found.hulls[2], Vector3d::Constant(-0.07), Vector3d::Constant(0.07), 1e-12);
  // The flange is part of the link; its z points along −y there.
  EXPECT_EQ(found.hulls[3].link, "first");
  expect_extent(found.hulls[3], {-0.05, 0.5, -0.1}, {0.05, 0.8, 0.1}, 1e-12);
  EXPECT_TRUE(found.findings.empty());
}

TEST_F(Collision, OfALinkWithoutShapeIsAGuessAboutItsFrames) {
  const CollisionModel found = read("", "");
  ASSERT_EQ(found.hulls.size(), 2U);
  EXPECT_TRUE(found.hulls[0].is_assumed);
  expect_extent(found.hulls[0], {0, 0, 0}, {0, 0, 1}, 1e-12);
  // To the flange, which has no joint.
  EXPECT_EQ(found.hulls[1].link, "first");
  expect_extent(found.hulls[1], {0, 0, 0}, {0, 0.5, 0}, 1e-12);
}

// A finger whose joint follows the first one, turned where that one is at 0.
TEST_F(Collision, OfADependentJointIsInItsOwnFrame) {
  std::string text = arm("", body(R"(<sphere radius="0.07"/>)"), "");
  text.replace(text.find("</robot>"), 8,
               R"(<link name="finger">)" +
                   body(R"(<box size="0.1 0.2 0.6"/>)", R"(<origin xyz="0 0 0.3"/>)") +
                   R"(</link><joint name="j2" type="revolute"><parent link="first"/><child link="finger"/>
<origin xyz="0 0.1 0"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="9"/>
<mimic joint="j1" multiplier="2" offset="0.5"/></joint></robot>)");
  folder_.write("arm.urdf", text);
  const Robot robot = read_urdf(folder_.path() / "arm.urdf");
  ASSERT_EQ(robot.chain.dependents.size(), 1U);
  const CollisionModel found = read_collision(folder_.path() / "arm.urdf", robot);
  const auto finger = std::ranges::find(found.hulls, "finger", &Hull::link);
  ASSERT_NE(finger, found.hulls.end());
  EXPECT_FALSE(finger->is_assumed);
  expect_extent(*finger, {-0.05, -0.1, 0.0}, {0.05, 0.1, 0.6}, 1e-12);
}

std::string binary_stl(const Matrix3Xd& corners) {
  std::string out(80, ' ');
  out.replace(0, 5, "solid");  // as some programs begin binary files
  const auto add = [&](const auto& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  add(static_cast<std::uint32_t>(corners.cols() / 3));
  for (Index k = 0; k < corners.cols(); k += 3) {
    for (int normal = 0; normal < 3; ++normal) {
      add(0.0F);
    }
    for (Index corner = k; corner < k + 3; ++corner) {
      for (const double x : corners.col(corner)) {
        add(static_cast<float>(x));
      }
    }
    add(std::uint16_t{0});
  }
  return out;
}

TEST_F(Collision, MeshesOfAllFormatsAreTheSame) {
  Matrix3Xd corners(3, 6);
  corners << 0, 1, 0, 0, 1, 0,  //
      0, 0, 2, 0, 0, 2,         //
      0, 0, 0, 3, 0, 0;
  write_mesh("binary.STL", binary_stl(corners));
  write_mesh(
      "text.stl",
      "solid thing vertex\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2e0 0\n"
      "endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 3\nendloop\nendfacet\nendsolid\n");
  write_mesh(
      "text.obj",
      "# v 9 9 9\nvn 7 7 7\nv 0 0 0\nv 1 0 0 1.0\r\nv 0 2 0\nv 5 5 5\nv 0 0 3 # tip\nf 1/1 2//1 3/1/1 # one\n"
      "f -1 1 2\nvt 5 5\n");
  // In millimetres, moved by its node and back by the parent of that, with a point that no face has.
  write_mesh("scene.dae",
             R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="15">
0 0 0 9 9 9000 0 500 0  -1000 0 0 0 0 1500</float_array></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="NORMAL" offset="0"/><input semantic="VERTEX" offset="1"/><p>1 0 1 2 1 3</p></triangles>
<polygons count="1"><input semantic="VERTEX" offset="0"/><p>0 2 4</p></polygons></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">
<node><translate>0 0 -40</translate><node><matrix>2 0 0 0  0 2 0 0  0 0 2 40  0 0 0 1</matrix>
<rotate>0 0 1 -90</rotate><instance_geometry url="#g"/></node></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
  for (const std::string name : {"binary.STL", "text.stl", "text.obj", "scene.dae"}) {
    for (const std::string path : {"package://pkg/meshes/", "../meshes/"}) {
      const CollisionModel found =
          read("", body("<mesh filename=\"" + path + name + R"(" scale="0.1 0.1 -0.2"/>)"));
      const auto hull = std::ranges::find(found.hulls, "first", &Hull::link);
      ASSERT_NE(hull, found.hulls.end());
      EXPECT_EQ(hull->points.cols(), 4) << name;
      EXPECT_FALSE(hull->is_assumed) << name;
      expect_extent(*hull, {0, 0, -0.6}, {0.1, 0.2, 0}, digits);
      EXPECT_EQ(found.meshes.size(), 1U);
    }
  }
}

TEST_F(Collision, SaysWhichMeshIsMissing) {
  const CollisionModel found = read("", body(R"(<mesh filename="package://pkg/meshes/no.stl"/>)"));
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings[0].code, "mesh_missing");
  EXPECT_NE(found.findings[0].text.find("arm.urdf:2: collision of link \"first\": its mesh "
                                        "\"package://pkg/meshes/no.stl\" is not found"),
            std::string::npos)
      << found.findings[0].text;
  EXPECT_TRUE(found.hulls.back().is_assumed);
}

TEST_F(Collision, RefusesWhatIsNone) {
  const auto expect = [&](const std::string& geometry, const std::string& words) {
    const std::string said = message(body(geometry));
    EXPECT_NE(said.find(words), std::string::npos) << said;
  };
  expect(R"(<box size="1 0 1"/>)",
         "arm.urdf:2: collision of link \"first\": its size must be three positive numbers");
  expect(R"(<box size="1 1"/>)", "must be three finite numbers");
  expect(R"(<sphere radius="-1"/>)", "its radius is -1 m, must be positive");
  expect(R"(<cylinder radius="1"/>)", "<cylinder> has no length");
  expect(R"(<cone/>)", "must be a box, cylinder, sphere or mesh");
  expect(R"(<mesh/>)", "<mesh> has no filename");
  const auto of = [&](const std::string& name, const std::string& content, const std::string& words) {
    write_mesh(name, content);
    expect("<mesh filename=\"../meshes/" + name + "\"/>", name + ": " + words);
  };
  const Matrix3Xd corners = Matrix3Xd::Constant(3, 3, std::nan(""));
  of("nan.stl", binary_stl(corners), "triangle 1 has a corner that is not finite");
  of("cut.stl", binary_stl(corners).substr(5, 100), "is no STL");
  of("empty.stl", binary_stl(Matrix3Xd(3, 0)), "has no points");
  of("word.stl", "solid\nvertex 1 2 three\n", "\"three\" at byte");
  of("short.obj", "v 1 2\nv", "\"v\" at byte");
  of("huge.obj", "v 1e999 0 0\n", "\"1e999\" at byte 7 is no finite number");
  of("face.obj", "v 1 2 3\nf 1 2 x\n", "\"x\" at byte 15 is no number of a point");
  of("far.obj", "v 1 2 3\nf 1 2\n", "a face has point 2 of 1");
  of("a.ply", "ply\n", "is no mesh that can be read, must be STL, OBJ or DAE");
  of("a.dae", "<COLLADA>", "is no COLLADA");
  of("b.dae", "<COLLADA><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>",
     "has nothing of the id");
  of("c.dae",
     "<COLLADA><scene><instance_visual_scene url=\"#s\"/></scene><node id=\"s\"><node id=\"n\">"
     "<instance_node url=\"#n\"/></node></node></COLLADA>",
     "its nodes are more than 100 deep");
  const std::filesystem::path large = folder_.path() / "pkg/meshes/large.stl";
  std::ofstream(large) << "solid";
  std::filesystem::resize_file(large, mesh_limit + 1);
  expect(R"(<mesh filename="../meshes/large.stl"/>)", "large.stl");
}

}  // namespace
}  // namespace rivid
