#include <algorithm>
#include <nlohmann/json.hpp>

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

std::string to_json(std::span<const Finding> findings) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const Finding& f : findings) {
    list.push_back({{"severity", name(severity(f))},
                    {"code", f.code},
                    {"subject", f.subject},
                    {"text", f.text},
                    {"advice", cure(f)}});
  }
  const Json out = {{"format", 1},
                    {"usable", count(findings, Severity::error) == 0},
                    {"errors", count(findings, Severity::error)},
                    {"warnings", count(findings, Severity::warning)},
                    {"findings", std::move(list)}};
  // A path may hold any bytes; JSON is UTF-8.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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
