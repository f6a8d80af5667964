#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"

namespace rivid {

/// How much a finding matters.
enum class Severity {
  note,     ///< worth knowing
  warning,  ///< may make a result wrong
  error     ///< makes an identification useless
};

/// "note", "warning", "error".
template <>
inline constexpr std::array names_of<Severity> =
    std::to_array<std::string_view>({"note", "warning", "error"});

/// What a Finding or the status of a result can be: docs/diagnostics.md lists them.
struct DiagnosticCode {
  std::string_view code;  ///< "torque_sign"
  Severity severity = Severity::note;
  std::string_view meaning;  ///< what is the matter
  std::string_view cause;    ///< how it is found, and what is usually behind it
  std::string_view cure;     ///< what to do
};

/// All codes, those of robots and logs first.
[[nodiscard]] std::span<const DiagnosticCode> diagnostic_codes();

/// The one of that name.
[[nodiscard]] std::optional<DiagnosticCode> diagnostic_code(std::string_view code);

/// A key of an experiment file and what becomes of its value: docs/diagnostics.md lists the keys.
struct Change {
  std::string key = {};  ///< "log.torque.scale", of a column of `joint`: a factor beside the one that it has
  std::string joint = {};  ///< by its name; empty where the key is not of a joint
  std::vector<double> numbers = {};
  std::string word = {};  ///< in place of numbers, or beside them

  [[nodiscard]] bool operator==(const Change& other) const = default;

  template <typename C = Change>
  static constexpr auto fields() {
    return std::tuple(Field{"key", &C::key, "of the experiment file"},
                      Field{"joint", &C::joint, "whose value it is; empty where the key is not of a joint"},
                      Field{"numbers", &C::numbers, "its value or what is done to it"},
                      Field{"word", &C::word, "in place of numbers, or beside them"});
  }
};

/// What readers of robots and logs, simulations, methods, check() and the write-back report.
struct Finding {
  std::string code = {};     ///< one of diagnostic_codes(), which have severity, cause and cure
  std::string subject = {};  ///< joint, log or parameter that it is about; empty where the text names it
  std::string text = {};     ///< the value that was found, and what is required
  std::vector<Change> changes = {};  ///< of the experiment, which its hint comes down to: see try_hint()

  [[nodiscard]] bool operator==(const Finding& other) const = default;
};

/// How much it matters, as the table of codes says; `warning` for a code that it does not hold.
[[nodiscard]] Severity severity(const Finding& finding);

/// What to do, as the table of codes says.
[[nodiscard]] std::string_view cure(const Finding& finding);

/// "joint_1: its torque has the other sign", without the full stop.
[[nodiscard]] std::string sentence(const Finding& finding);

/// One finding of each code, which names the subjects of the others: "…; the same of joint_2 and joint_3".
[[nodiscard]] std::vector<Finding> told_once(std::span<const Finding> findings);

/// One line: "error [torque_sign] joint_1: its torque has the other sign".
[[nodiscard]] std::string in_words(const Finding& finding);

}  // namespace rivid
