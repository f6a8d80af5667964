#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rivid {

/// How much a finding matters.
enum class Severity {
  note,     ///< worth knowing
  warning,  ///< may make a result wrong
  error     ///< makes an identification useless
};

/// "note", "warning", "error".
[[nodiscard]] std::string_view name(Severity severity);

/// What a finding of check(), a Warning or the status of a result can be: docs/diagnostics.md shows the same table.
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

/// Something that may make a result wrong.
struct Warning {
  std::string code;  ///< one of diagnostic_codes(), which tell cause and cure
  std::string text;  ///< what it is about, the value that was found, and what is required

  [[nodiscard]] bool operator==(const Warning& other) const = default;
};

}  // namespace rivid
