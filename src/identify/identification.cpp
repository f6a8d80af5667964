#include "rivid/identify/identification.hpp"

#include <array>

namespace rivid {

std::string_view name(Status status) {
  constexpr std::array<std::string_view, 6> names = {"identified", "rank_deficient",   "not_converged",
                                                     "cycling",    "weak_instruments", "not_simulable"};
  return names[static_cast<std::size_t>(status)];
}

std::string_view name(Verdict verdict) {
  constexpr std::array<std::string_view, 3> names = {"identified", "weak", "not_excited"};
  return names[static_cast<std::size_t>(verdict)];
}

}  // namespace rivid
