#pragma once

#include <string>

#include "rivid/identify/payload.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// Payloads for the screen: values with their intervals, differences, the gains where they were estimated,
/// and the lines that a controller takes.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string in_words(const PayloadReport& found, std::size_t screen = 0);

/// The same as JSON: docs/payload.md lists the members.
[[nodiscard]] std::string to_json(const PayloadReport& found, const PayloadOptions& options);

}  // namespace rivid
