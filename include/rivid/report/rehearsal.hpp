#pragma once

#include <string>

#include "rivid/experiment/rehearsal.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// A rehearsal as JSON, the content of rehearsal.json; docs/excite.md describes its members.
[[nodiscard]] std::string to_json(const ExcitationPlan& plan, const Rehearsal& rehearsal,
                                  const Provenance& provenance);

/// For people: what will be known, what not, and which troubles would be found.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string summary(const Rehearsal& rehearsal, std::size_t screen = 0);

}  // namespace rivid
