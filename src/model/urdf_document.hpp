#pragma once

#include <Eigen/Core>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/error.hpp"

namespace rivid::detail {

/// The XML of a URDF: well formed, with one <robot>, no xacro; and its numbers, read strictly. Every fault throws
/// an InputError that begins with source and line.
class UrdfDocument {
 public:
  UrdfDocument(std::string_view xml, std::string source);

  [[nodiscard]] const std::string& source() const { return source_; }
  [[nodiscard]] pugi::xml_node robot() const { return document_.child("robot"); }

  /// "scara.urdf:42: "
  [[nodiscard]] std::string where(pugi::xml_node node) const;
  [[noreturn]] void refuse(pugi::xml_node node, const std::string& message) const;

  /// The only child of that name, null if there is none.
  /// @param who  what `parent` is, in messages: `link "link_1"`
  [[nodiscard]] pugi::xml_node only_child(pugi::xml_node parent, const char* name,
                                          const std::string& who) const;

  /// A required attribute with text.
  [[nodiscard]] std::string text(pugi::xml_node node, const char* attribute, const std::string& who) const;

  /// A required attribute that is a finite number.
  [[nodiscard]] double number(pugi::xml_node node, const char* attribute, const std::string& who) const;
  [[nodiscard]] double number_or(double fallback, pugi::xml_node node, const char* attribute,
                                 const std::string& who) const;

  /// Three finite numbers, `fallback` where the element or the attribute is missing.
  [[nodiscard]] Eigen::Vector3d triple_or(const Eigen::Vector3d& fallback, pugi::xml_node node,
                                          const char* attribute, const std::string& who) const;

 private:
  [[nodiscard]] std::string where(std::ptrdiff_t offset) const;
  void check_well_formed(const pugi::xml_parse_result& result) const;
  void check_elements() const;

  std::string source_;
  std::vector<std::size_t> newlines_;  // their byte offsets
  pugi::xml_document document_;
};

}  // namespace rivid::detail
