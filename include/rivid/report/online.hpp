#pragma once

#include <string>

#include "rivid/experiment/online_replay.hpp"

namespace rivid {

/// The records as CSV, a header line first.
///
/// @throws InputError  where the series have other lengths than `t` or there is not one column for each joint
[[nodiscard]] std::string to_csv(const OnlineReplay& replay);
/// For the screen: events, and the payload at the end with the lines that controllers take.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string in_words(const OnlineReplay& replay, std::size_t screen = 0);
/// A page with plots, in one file.
///
/// @throws InputError  where to_csv() throws it, or there is no record
[[nodiscard]] std::string to_html(const OnlineReplay& replay);

}  // namespace rivid
