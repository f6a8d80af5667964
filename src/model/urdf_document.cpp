#include "urdf_document.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

namespace rivid::detail {

namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> out;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const std::size_t end = std::min(text.find_first_of(blanks), text.size());
    out.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return out;
}

std::optional<double> finite(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.remove_prefix(1);
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string as_written(pugi::xml_node node, const char* attribute) {
  return std::string("<") + node.name() + ' ' + attribute + "=\"" + node.attribute(attribute).value() + "\">";
}

bool is_xacro(std::string_view value) {
  return value.find("${") != std::string_view::npos || value.find("$(") != std::string_view::npos;
}

}  // namespace

UrdfDocument::UrdfDocument(std::string_view xml, std::string source) : source_(std::move(source)) {
  if (trimmed(xml).empty()) {
    throw InputError(source_ + ": is empty, must be a URDF");
  }
  for (std::size_t i = xml.find('\n'); i != std::string_view::npos; i = xml.find('\n', i + 1)) {
    newlines_.push_back(i);
  }
  check_well_formed(document_.load_buffer(xml.data(), xml.size()));
  check_elements();
}

void UrdfDocument::check_well_formed(const pugi::xml_parse_result& result) const {
  if (result.status == pugi::status_no_document_element) {
    throw InputError(source_ + ": is not XML, must be a URDF");
  }
  if (!result) {
    throw InputError(where(result.offset) + "not well-formed XML: " + result.description());
  }
  const pugi::xml_node root = document_.document_element();
  if (std::string_view(root.name()) != "robot") {
    const bool sdf = std::string_view(root.name()) == "sdf";
    refuse(root, std::string("is not a URDF: the outermost element is <") + root.name() +
                     ">, must be <robot>" + (sdf ? "; convert the SDF to a URDF first" : ""));
  }
  for (pugi::xml_node next = root.next_sibling(); next; next = next.next_sibling()) {
    if (next.type() == pugi::node_element) {
      refuse(next, std::string("not well-formed XML: <") + next.name() + "> follows the end of <robot>");
    }
  }
}

void UrdfDocument::check_elements() const {
  const std::string advice = "; this is a xacro file, expand it first: xacro in.xacro > out.urdf";
  const pugi::xml_node root = robot();
  // Without recursion: a hostile file can nest deeper than the stack.
  pugi::xml_node node = root;
  while (node) {
    if (std::string_view(node.name()).starts_with("xacro:")) {
      refuse(node, std::string("<") + node.name() + "> is not URDF" + advice);
    }
    for (const pugi::xml_attribute attribute : node.attributes()) {
      if (is_xacro(attribute.value())) {
        refuse(node, as_written(node, attribute.name()) + " holds an expression" + advice);
      }
      for (pugi::xml_attribute other = attribute.next_attribute(); other; other = other.next_attribute()) {
        if (std::string_view(attribute.name()) == other.name()) {
          refuse(node, std::string("not well-formed XML: <") + node.name() + "> has two attributes " +
                           attribute.name());
        }
      }
    }
    if (node.first_child()) {
      node = node.first_child();
      continue;
    }
    while (node != root && !node.next_sibling()) {
      node = node.parent();
    }
    node = node == root ? pugi::xml_node() : node.next_sibling();
  }
}

std::string UrdfDocument::where(std::ptrdiff_t offset) const {
  if (offset < 0) {
    return source_ + ": ";
  }
  const auto line = std::lower_bound(newlines_.begin(), newlines_.end(), static_cast<std::size_t>(offset));
  return source_ + ':' + std::to_string(line - newlines_.begin() + 1) + ": ";
}

std::string UrdfDocument::where(pugi::xml_node node) const { return where(node.offset_debug()); }

void UrdfDocument::refuse(pugi::xml_node node, const std::string& message) const {
  throw InputError(where(node) + message);
}

pugi::xml_node UrdfDocument::only_child(pugi::xml_node parent, const char* name,
                                        const std::string& who) const {
  const pugi::xml_node child = parent.child(name);
  if (const pugi::xml_node second = child.next_sibling(name)) {
    refuse(second, who + ": has a second <" + name + ">, must have one at most");
  }
  return child;
}

std::string UrdfDocument::text(pugi::xml_node node, const char* attribute, const std::string& who) const {
  if (trimmed(node.attribute(attribute).value()).empty()) {
    refuse(node, who + ": <" + node.name() + "> has no " + attribute);
  }
  return node.attribute(attribute).value();
}

double UrdfDocument::number(pugi::xml_node node, const char* attribute, const std::string& who) const {
  if (!node.attribute(attribute)) {
    refuse(node, who + ": <" + node.name() + "> has no " + attribute);
  }
  const std::optional<double> value = finite(node.attribute(attribute).value());
  if (!value) {
    refuse(node, who + ": " + as_written(node, attribute) + " must be a finite number, such as 1.5e-3");
  }
  return *value;
}

double UrdfDocument::number_or(double fallback, pugi::xml_node node, const char* attribute,
                               const std::string& who) const {
  return node.attribute(attribute) ? number(node, attribute, who) : fallback;
}

Eigen::Vector3d UrdfDocument::triple_or(const Eigen::Vector3d& fallback, pugi::xml_node node,
                                        const char* attribute, const std::string& who) const {
  if (!node.attribute(attribute)) {
    return fallback;
  }
  const std::vector<std::string_view> parts = words(node.attribute(attribute).value());
  Eigen::Vector3d out = fallback;
  bool good = parts.size() == 3;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::optional<double> value = finite(parts[i]);
    good = value.has_value();
    out[static_cast<Eigen::Index>(i)] = value.value_or(0.0);
  }
  if (!good) {
    refuse(node, who + ": " + as_written(node, attribute) +
                     " must be three finite numbers with blanks between them, such as \"0 0 1.5e-3\"");
  }
  return out;
}

}  // namespace rivid::detail
