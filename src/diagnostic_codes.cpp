#include <algorithm>

#include "finding_codes.hpp"

namespace rivid {

std::span<const DiagnosticCode> diagnostic_codes() { return detail::codes; }

std::optional<DiagnosticCode> diagnostic_code(std::string_view code) {
  const auto* const at = std::ranges::find(detail::codes, code, &DiagnosticCode::code);
  return at == detail::codes.end() ? std::nullopt : std::optional<DiagnosticCode>(*at);
}

Severity severity(const Finding& finding) {
  const std::optional<DiagnosticCode> known = diagnostic_code(finding.code);
  return known ? known->severity : Severity::warning;
}

std::string_view cure(const Finding& finding) {
  const std::optional<DiagnosticCode> known = diagnostic_code(finding.code);
  return known ? known->cure : std::string_view();
}

std::string sentence(const Finding& finding) {
  return finding.subject.empty() ? finding.text : finding.subject + ": " + finding.text;
}

std::string in_words(const Finding& finding) {
  return std::string(name(severity(finding))) + " [" + finding.code + "] " + sentence(finding);
}

}  // namespace rivid
