#pragma once

#include <cstddef>
#include <ostream>
#include <span>
#include <string>

#include "rivid/experiment/hint.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/identification.hpp"

namespace rivid {

/// Columns of a line of words: longer ones are hard to read.
inline constexpr std::size_t longest_line = 100;

/// Words in lines that end at a column, from the column `indent` on, where the first one stands already.
[[nodiscard]] std::string folded(const std::string& text, std::size_t indent,
                                 std::size_t line_width = longest_line);

/// Prints a result for people: verdict, findings, parameters with their statistics and regrouping, fit joint
/// by joint, validation, the physically consistent parameters and their price. UTF-8, sentences at most 100
/// columns wide.
///
/// @param screen  columns of the terminal: tables that are wider go on below. 0: for a file or another
///                program, where they do not
[[nodiscard]] std::string in_words(const Identification& result, std::size_t screen = 0);

/// The first screen of it, at most 40 lines of 100 columns for seven joints: verdict and forecast, the
/// joints, three findings at most.
///
/// @param screen  columns of the terminal; 0: 100
[[nodiscard]] std::string first_screen(const Robot& robot, const Identification& result,
                                       std::size_t screen = 0);

/// in_words() of a result.
std::ostream& operator<<(std::ostream& out, const Identification& result);

/// in_words() of a finding as a full sentence and, unless it is a note, what to do.
[[nodiscard]] std::string with_cure(const Finding& finding);

/// Findings for the screen: each code once, the gravest first, and a last line that counts them.
///
/// @param screen  columns of the terminal; 0: 100
[[nodiscard]] std::string in_words(std::span<const Finding> findings, std::size_t screen = 0);

/// Findings as JSON: docs/diagnostics.md lists the members.
[[nodiscard]] std::string to_json(std::span<const Finding> findings);

/// A hint that was taken, with the lines of the experiment file at its end; and as JSON.
[[nodiscard]] std::string in_words(const HintTrial& trial);
[[nodiscard]] std::string to_json(const HintTrial& trial);

/// A code in one line for a list, and all that is known of it.
[[nodiscard]] std::string in_one_line(const DiagnosticCode& code);
[[nodiscard]] std::string explained(const DiagnosticCode& code);

}  // namespace rivid
