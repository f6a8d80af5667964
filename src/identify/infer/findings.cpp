#include "identify/infer/findings.hpp"

#include <algorithm>
#include <cassert>
#include <functional>
#include <utility>

namespace rivid::detail {

void Findings::add(FindingCode code, std::string subject, std::string text, std::vector<Change> changes) {
  assert(diagnostic_code(code.text()));
  Finding finding{std::string(code.text()), std::move(subject), std::move(text), std::move(changes)};
  // The pieces of one log say the same of their file.
  if (std::ranges::find(all_, finding) == all_.end()) {
    all_.push_back(std::move(finding));
  }
}

bool Findings::has(FindingCode code, std::string_view subject) const {
  return std::ranges::any_of(all_, [&](const Finding& f) {
    return f.code == code.text() && (subject.empty() || f.subject == subject);
  });
}

bool Findings::any(Severity of) const {
  return std::ranges::any_of(all_, [&](const Finding& f) { return severity(f) == of; });
}

void Findings::drop(FindingCode code) {
  std::erase_if(all_, [&](const Finding& f) { return f.code == code.text(); });
}

std::vector<Finding> Findings::sorted() && {
  std::ranges::stable_sort(all_, std::ranges::greater(), severity);
  return std::move(all_);
}

}  // namespace rivid::detail
