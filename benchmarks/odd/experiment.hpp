#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "odd/judgement.hpp"
#include "odd/user_folder.hpp"

namespace rivid::odd {

/// What became of one experiment by one method: a line of the records.
struct Record {
  Name name;
  std::string method;   ///< that was asked for: "as-drafted", "wls", "iv"
  std::string used;     ///< that ran
  std::string status;   ///< of the result; of a refusal "input_error"
  std::string check;    ///< codes of the errors and warnings of check(); "-" where it was not asked
  std::string message;  ///< why it was refused or crashed
  Judgement judgement;
  int joints = 0;
  double rate_hz = 0.0;
  /// Share of the squared residual that is there for what is odd; not a number where it was not asked, or
  /// where one of the two has no fit.
  double visible = std::numeric_limits<double>::quiet_NaN();
  double written_s = 0.0;     ///< time to simulate and write
  double identified_s = 0.0;  ///< time from the draft to the result
};

struct Asked {
  std::vector<std::string> methods = {"as-drafted"};
  bool check = false;
  bool visible = false;             ///< whether a sound twin is carried out beside each
  std::filesystem::path keep = {};  ///< where folders are kept; empty: nowhere
  bool keep_all = false;            ///< not only those of what was confidently wrong or crashed
};

/// Writes one experiment into a folder of its own, drafts its experiment file as `rivid init` does,
/// and identifies as `rivid_identify FILE` does.
///
/// @return  one record a method
[[nodiscard]] std::vector<Record> carried_out(const Name& name, const Asked& asked);

}  // namespace rivid::odd
