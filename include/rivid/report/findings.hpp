#pragma once

#include <span>
#include <string>

#include "rivid/identify/check.hpp"

namespace rivid {

/// Findings for the screen: one line each, the gravest first, and a last line that counts them.
[[nodiscard]] std::string in_words(std::span<const Finding> findings);

/// Findings as JSON: docs/diagnostics.md lists the members.
[[nodiscard]] std::string to_json(std::span<const Finding> findings);

/// A code in one line for a list, and all that is known of it.
[[nodiscard]] std::string in_one_line(const DiagnosticCode& code);
[[nodiscard]] std::string explained(const DiagnosticCode& code);

}  // namespace rivid
