#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rivid::detail {

/// A start tag of well-formed XML by its places in the text.
struct StartTag {
  struct Attribute {
    std::string_view name;
    std::string_view value;  // as written
    std::size_t begin = 0;   // of the value
  };

  std::string_view name;
  std::size_t name_end = 0;
  std::size_t end = 0;  // behind its '>'
  bool closed = false;  // "/>"
  std::vector<Attribute> attributes;

  /// Null where there is none of that name.
  [[nodiscard]] const Attribute* attribute(std::string_view wanted) const;
};

/// @param name_begin  offset of the element's name
[[nodiscard]] StartTag start_tag(std::string_view text, std::size_t name_begin);

/// `key="value"` with a blank before it.
[[nodiscard]] std::string xml_attribute(std::string_view key, std::string_view value);
[[nodiscard]] std::string xml_attribute(std::string_view key, double value);

/// Replacements in a text, put in all at once. What is not replaced keeps every byte.
class Splice {
 public:
  explicit Splice(std::string_view text) : text_(text) {}

  [[nodiscard]] std::string_view text() const { return text_; }

  void replace(std::size_t begin, std::size_t length, std::string content);

  /// Gives an attribute another value; it is added behind the element's name where there is none.
  void set(const StartTag& tag, std::string_view attribute, const std::string& value);

  /// Puts lines of an element into another one, first of its children, indented as these are.
  ///
  /// @param lines  the element's; each begins with two blanks for each level below the first
  void insert_child(const StartTag& parent, const std::vector<std::string>& lines);

  [[nodiscard]] std::string result() const;

 private:
  struct Edit {
    std::size_t begin;
    std::size_t length;
    std::string content;
  };

  std::string_view text_;
  std::vector<Edit> edits_;
};

}  // namespace rivid::detail
