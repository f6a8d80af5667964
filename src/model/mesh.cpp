#include "model/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/model/collision.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

// The words of a text, and where it is.
class Words {
 public:
  Words(std::string_view text, std::string where) : text_(text), where_(std::move(where)) {}

  std::optional<std::string_view> next() { return next_after(" \t\r\n"); }

  std::optional<std::string_view> next_of_line() { return next_after(" \t\r"); }

  double number() {
    const std::string_view word = next().value_or("");
    const std::optional<double> out = finite_number(word);
    if (!out) {
      throw InputError(where_ + ": " + in_quotes(word) + " at byte " + std::to_string(at_) +
                       " is no finite number");
    }
    return *out;
  }

  Vector3d point() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }

  // The whole number that a word begins with, as of a corner "3/1/2" of an OBJ.
  [[nodiscard]] long index(std::string_view word) const {
    long out = 0;
    if (std::from_chars(word.data(), word.data() + word.size(), out).ec != std::errc()) {
      throw InputError(where_ + ": " + in_quotes(word) + " at byte " + std::to_string(at_) +
                       " is no number of a point");
    }
    return out;
  }

  void end_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

 private:
  std::optional<std::string_view> next_after(std::string_view spaces) {
    const std::size_t from = text_.find_first_not_of(spaces, at_);
    if (from == std::string_view::npos || text_[from] == '\n') {
      return std::nullopt;
    }
    at_ = std::min(text_.find_first_of(" \t\r\n", from), text_.size());
    return text_.substr(from, at_ - from);
  }

  std::string_view text_;
  std::string where_;
  std::size_t at_ = 0;
};

// 80 bytes of anything, the number of triangles, and of each its normal, three corners and two bytes.
constexpr std::size_t stl_header = 84;
constexpr std::size_t stl_triangle = 50;

std::uint32_t triangles_of(std::string_view bytes) {
  std::uint32_t out = 0;
  std::memcpy(&out, bytes.data() + stl_header - sizeof out, sizeof out);
  return out;
}

Points read_stl(std::string_view bytes, const std::string& where) {
  static_assert(std::endian::native == std::endian::little);
  Points out;
  // A binary file may begin with "solid" as well; its size tells.
  if (bytes.size() < stl_header || bytes.size() != stl_header + stl_triangle * triangles_of(bytes)) {
    if (!bytes.starts_with("solid")) {
      throw InputError(where + ": is no STL: its " + std::to_string(bytes.size()) +
                       " bytes are neither text that begins with \"solid\" nor those of its triangles");
    }
    Words words(bytes, where);
    words.end_line();
    while (const auto word = words.next()) {
      if (*word == "vertex") {
        out.push_back(words.point());
      }
    }
    return out;
  }
  for (std::size_t at = stl_header; at < bytes.size(); at += stl_triangle) {
    std::array<float, 12> numbers = {};
    std::memcpy(numbers.data(), bytes.data() + at, sizeof numbers);
    for (std::size_t corner = 3; corner < numbers.size(); corner += 3) {
      out.emplace_back(numbers[corner], numbers[corner + 1], numbers[corner + 2]);
      if (!out.back().allFinite()) {
        throw InputError(where + ": triangle " + std::to_string((at - stl_header) / stl_triangle + 1) +
                         " has a corner that is not finite");
      }
    }
  }
  return out;
}

// The points that are corners of faces, or all where there are no faces: others are no part of the body.
Points corners(const Points& points, const std::vector<long>& faces, const std::string& where) {
  std::vector<bool> is_corner(points.size(), faces.empty());
  for (const long point : faces) {
    if (point < 0 || point >= std::ssize(points)) {
      throw InputError(where + ": a face has point " + std::to_string(point + 1) + " of " +
                       std::to_string(points.size()));
    }
    is_corner[static_cast<std::size_t>(point)] = true;
  }
  Points out;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (is_corner[k]) {
      out.push_back(points[k]);
    }
  }
  return out;
}

Points read_obj(std::string_view bytes, const std::string& where) {
  Points points;
  std::vector<long> faces;
  Words words(bytes, where);
  while (const auto word = words.next()) {
    if (*word == "v") {
      points.push_back(words.point());
    } else if (*word == "f") {
      for (auto corner = words.next_of_line(); corner && !corner->starts_with('#');
           corner = words.next_of_line()) {
        // From 1, or back from the last one.
        const long point = words.index(*corner);
        faces.push_back(point < 0 ? std::ssize(points) + point : point - 1);
      }
    }
    words.end_line();
  }
  return corners(points, faces, where);
}

// The geometries of a COLLADA scene, each where its nodes put it.
class Collada {
 public:
  Collada(std::string_view bytes, std::string where) : where_(std::move(where)) {
    const pugi::xml_parse_result parsed = document_.load_buffer(bytes.data(), bytes.size());
    if (!parsed || !document_.child("COLLADA")) {
      throw InputError(where_ + ": is no COLLADA: " + (parsed ? "no <COLLADA>" : parsed.description()));
    }
    for (const pugi::xpath_node& found : document_.select_nodes("//*[@id]")) {
      by_id_.emplace(found.node().attribute("id").value(), found.node());
    }
  }

  Points points() {
    const pugi::xml_node root = document_.child("COLLADA");
    const double metre = root.child("asset").child("unit").attribute("meter").as_double(1.0);
    const Eigen::Affine3d scale(Eigen::Scaling(metre));
    const pugi::xml_node scene = at(root.child("scene").child("instance_visual_scene"), "url");
    for (const pugi::xml_node node : scene.children("node")) {
      place(node, scale, 0);
    }
    return std::move(out_);
  }

 private:
  pugi::xml_node at(pugi::xml_node node, const char* attribute) const {
    const std::string_view name = node.attribute(attribute).value();
    const auto found = by_id_.find(name.substr(std::min<std::size_t>(1, name.size())));
    if (found == by_id_.end()) {
      throw InputError(where_ + ": has nothing of the id " + in_quotes(name) + " that <" + node.name() +
                       "> names");
    }
    return found->second;
  }

  [[nodiscard]] Eigen::Affine3d transform(pugi::xml_node node) const {
    const std::string_view kind = node.name();
    Words words(node.child_value(), where_);
    Eigen::Affine3d out = Eigen::Affine3d::Identity();
    if (kind == "matrix") {
      for (Index row = 0; row < 3; ++row) {
        for (Index column = 0; column < 4; ++column) {
          out(row, column) = words.number();
        }
      }
    } else if (kind == "translate") {
      out.translation() = words.point();
    } else if (kind == "scale") {
      out.linear() = words.point().asDiagonal();
    } else if (kind == "rotate") {
      const Vector3d axis = words.point();
      const double angle = words.number() * std::numbers::pi / 180.0;
      out.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    }
    return out;
  }

  void place(pugi::xml_node node, Eigen::Affine3d pose, int depth) {
    constexpr int deepest = 100;  // nodes; any number that the stack has room for
    if (depth > deepest) {
      throw InputError(where_ + ": its nodes are more than " + std::to_string(deepest) + " deep");
    }
    for (const pugi::xml_node child : node.children()) {
      const std::string_view kind = child.name();
      if (kind == "node") {
        place(child, pose, depth + 1);
      } else if (kind == "instance_node") {
        place(at(child, "url"), pose, depth + 1);
      } else if (kind == "instance_geometry") {
        add(at(child, "url").child("mesh"), pose);
      } else {
        pose = pose * transform(child);
      }
    }
  }

  void add(pugi::xml_node mesh, const Eigen::Affine3d& pose) {
    const pugi::xml_node input = mesh.child("vertices").find_child_by_attribute("semantic", "POSITION");
    const pugi::xml_node numbers = at(input, "source").child("float_array");
    Words words(numbers.child_value(), where_);
    const auto count = numbers.attribute("count").as_ullong();
    Points points;
    for (unsigned long long k = 0; k + 2 < count; k += 3) {
      if (out_.size() + points.size() > mesh_limit / sizeof(Vector3d)) {
        throw InputError(where_ + ": its scene has more points than rivid reads");
      }
      points.emplace_back(pose * words.point());
    }
    std::vector<long> faces;
    for (const pugi::xml_node primitives : mesh.children()) {
      add_faces(primitives, faces);
    }
    std::ranges::copy(corners(points, faces, where_), std::back_inserter(out_));
  }

  // Of each corner of <triangles>, <polylist> … the number of its point, which stands among others.
  void add_faces(pugi::xml_node primitives, std::vector<long>& faces) const {
    std::optional<unsigned> point;
    unsigned each = 0;
    for (const pugi::xml_node input : primitives.children("input")) {
      const unsigned offset = input.attribute("offset").as_uint();
      each = std::max(each, offset + 1);
      if (std::string_view(input.attribute("semantic").value()) == "VERTEX") {
        point = offset;
      }
    }
    for (const pugi::xpath_node& found : point ? primitives.select_nodes("p|ph/p") : pugi::xpath_node_set()) {
      Words words(found.node().child_value(), where_);
      unsigned at = 0;
      for (auto word = words.next(); word; word = words.next(), at = (at + 1) % each) {
        if (at == *point) {
          faces.push_back(words.index(*word));
        }
      }
    }
  }

  std::string where_;
  pugi::xml_document document_;
  std::map<std::string, pugi::xml_node, std::less<>> by_id_;
  Points out_;
};

}  // namespace

std::optional<std::filesystem::path> found_mesh(const std::string& name,
                                                const std::filesystem::path& folder) {
  using Path = std::filesystem::path;
  constexpr std::string_view package = "package://";
  constexpr std::string_view file = "file://";
  constexpr int least_above = 6;  // folders that are tried at least; a choice
  std::error_code none;
  std::vector<Path> places;
  if (name.starts_with(package)) {
    // A URDF lies in its package, or in one beside it; a package may have a folder of another name.
    const Path whole = name.substr(package.size());
    const Path within = whole.empty() ? whole : whole.lexically_relative(*whole.begin());
    for (const Path& inside : {whole, within}) {
      Path above = std::filesystem::absolute(folder, none).lexically_normal();
      for (int k = 0; k < least_above || above.has_relative_path(); ++k, above = above.parent_path()) {
        places.push_back(above / inside);
      }
    }
  } else if (name.starts_with(file)) {
    const Path path = name.substr(file.size());
    places = {folder / path, path};
  } else {
    places = {folder / name};
  }
  const auto at = std::ranges::find_if(
      places, [&](const Path& path) { return std::filesystem::is_regular_file(path, none); });
  return at == places.end() ? std::nullopt : std::optional(*at);
}

Eigen::Matrix3Xd read_mesh(const std::filesystem::path& path) {
  const std::string where = path.string();
  refuse_larger(path, mesh_limit);
  const InputText text = read_input(path);
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  Points points;
  if (ending == ".stl") {
    points = read_stl(text.bytes(), where);
  } else if (ending == ".obj") {
    points = read_obj(text.bytes(), where);
  } else if (ending == ".dae") {
    points = Collada(text.bytes(), where).points();
  } else {
    throw InputError(where + ": is no mesh that can be read, must be STL, OBJ or DAE");
  }
  if (points.empty()) {
    throw InputError(where + ": has no points, must be a mesh");
  }
  return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, static_cast<Index>(points.size()));
}

}  // namespace rivid::detail
