#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// The standard parameters of one joint and its link, as robot descriptions have them.
struct JointValues {
  Inertial inertial = Inertial::Zero();  // in rivid's link frame
  double Ia = 0.0;
  std::optional<double> damping;     // Fv, the mean of both directions; none where the law has none
  std::optional<double> friction;    // Fc, likewise
  std::string rotor;                 // "Ia1 = 0.3 kg·m²"; empty where it is zero
  std::vector<std::string> rest;     // the same of asymmetric friction, offsets, coupled motors
  std::vector<std::string> coupled;  // those of `rest` that belong to coupled motors

  /// value × function(speed, sign) in the friction of the joint alone.
  struct FrictionTerm {
    double value = 0.0;
    std::string_view function;  // BasisRow::in_c
    Direction direction = Direction::both;
  };
  std::vector<FrictionTerm> friction_terms;
  double load_friction = 0.0;  // Fl: friction per |τ_load| of the joint

  /// What has no place beside inertial, damping and friction.
  [[nodiscard]] std::vector<std::string> unsaid(bool with_rotor) const;
};

/// @param who  the function that was called, in messages
/// @throws InputError  a wrong number of values, or one that is not finite
[[nodiscard]] std::vector<JointValues> joint_values(const Robot& robot,
                                                    const Eigen::Ref<const Vector>& chi_st,
                                                    std::string_view who);

/// "a, b, c".
[[nodiscard]] std::string joined(const std::vector<std::string>& parts);

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
