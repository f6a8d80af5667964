#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "odd/records.hpp"

namespace rivid::odd {

/// Which experiments.
struct Series {
  std::uint64_t seed = 1;
  std::vector<const Kind*> kinds;            ///< taken in turn
  std::vector<const Way*> ways = {nullptr};  ///< each kind in each of them
  std::uint64_t first = 0;                   ///< of each kind
  std::uint64_t count = 0;                   ///< of all kinds together
  int threads = 1;
};

/// Kinds by their names or by those of their groups, comma between; "all" is all but no_rotor.
///
/// @throws InputError  for a name that there is none of
[[nodiscard]] std::vector<const Kind*> kinds_of(const std::string& names);

/// Ways by their names, comma between; "all" is all.
///
/// @throws InputError  for a name that there is none of
[[nodiscard]] std::vector<const Way*> ways_of(const std::string& names);

/// Carries out what the file does not hold yet.
///
/// @param loud  a line on standard error now and then
void run_series(const Series& series, const Asked& asked, RecordFile& file, bool loud);

}  // namespace rivid::odd
