#include <algorithm>

#include "report/document.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

std::ptrdiff_t count(std::span<const Finding> findings, Severity wanted) {
  return std::ranges::count(findings, wanted, severity);
}

std::string counts(std::span<const Finding> findings) {
  return counted(count(findings, Severity::error), "error") + ", " +
         counted(count(findings, Severity::warning), "warning") + ", " +
         counted(count(findings, Severity::note), "note");
}

}  // namespace

std::string with_cure(const Finding& finding) {
  const std::string_view known = detail::advice(finding);
  return in_words(finding) + (known.empty() ? "." : ". " + std::string(known));
}

std::string in_words(std::span<const Finding> findings) {
  std::string out;
  for (const Finding& f : findings) {
    out.append(with_cure(f)).append("\n");
  }
  return out + counts(findings) + '\n';
}

std::string in_one_line(const DiagnosticCode& code) {
  constexpr std::size_t width = 20;
  std::string out(code.code);
  out.resize(std::max(out.size() + 2, width), ' ');
  return out + std::string(code.meaning) + '\n';
}

std::string explained(const DiagnosticCode& code) {
  return std::string(code.code) + " (" + std::string(name(code.severity)) + ")\n  " +
         std::string(code.meaning) + "\n  Cause: " + std::string(code.cause) +
         "\n  Cure:  " + std::string(code.cure) + '\n';
}

}  // namespace rivid
