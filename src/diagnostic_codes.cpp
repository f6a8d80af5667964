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

std::vector<Finding> told_once(std::span<const Finding> findings) {
  std::vector<Finding> out;
  std::vector<std::vector<std::string>> subjects;  // of each of them
  for (const Finding& finding : findings) {
    std::size_t k = finding.subject.empty() ? out.size() : 0;
    while (k < out.size() && (out[k].code != finding.code ||
                              std::ranges::find(subjects[k], finding.subject) != subjects[k].end())) {
      ++k;
    }
    if (k == out.size()) {
      out.push_back(finding);
      subjects.emplace_back();
    }
    subjects[k].push_back(finding.subject);
  }
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (subjects[k].size() > 1) {
      subjects[k].erase(subjects[k].begin());
      out[k].text += "; the same of " + listed(subjects[k]);
    }
  }
  return out;
}

}  // namespace rivid
