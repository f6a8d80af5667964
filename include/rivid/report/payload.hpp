#pragma once

#include <string>

#include "rivid/identify/payload.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// A payload for the screen: its values with their intervals, the gains where they were estimated, and the lines that a
/// controller takes.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string in_words(const Payload& payload, std::size_t screen = 0);

/// A payload as JSON: docs/payload.md lists the members.
[[nodiscard]] std::string to_json(const Payload& payload, const PayloadOptions& options);

}  // namespace rivid
