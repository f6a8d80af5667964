#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid {

/// A motion to be designed, [excitation], for the robot of an experiment file.
struct ExcitationPlan {
  Experiment experiment;      ///< the robot, and the sections that are there
  ExcitationOptions options;  ///< without the information of `known`, which known_information() reads
  std::vector<std::filesystem::path> known;  ///< earlier results, and logs, written as [log] says
  std::vector<std::string> settings;         ///< of the command line, which were laid over the file

  template <typename E = ExcitationPlan>
  static constexpr auto fields() {
    return std::tuple(
        embedded(&E::options),
        Field{"known",
              &E::known,
              "earlier results (`result.json`) or logs, to whose information the design adds; `[log]` and "
              "`[signal]` say how logs are read",
              {.otherwise = "–"}});
  }

  /// All files that a design reads, the experiment file first.
  [[nodiscard]] std::vector<std::filesystem::path> inputs() const;
};

/// Reads an experiment file for its [robot] and [excitation]; the other sections may be absent.
///
/// @param settings  as for read_experiment()
/// @throws InputError  as read_experiment() does
[[nodiscard]] ExcitationPlan read_excitation(const std::filesystem::path& path,
                                             std::span<const std::string> settings = {});

/// What a file of ExcitationPlan::known ends in if it is a result.
inline constexpr const char* result_ending = ".json";

/// Information of the plan's earlier logs, Σ Wᵀ W / σ², with the rows that [signal] makes of them, and of its
/// results, C_χχ⁻¹ of the parameters that they determine, (b × b).
///
/// @throws InputError  where a log can not be used, or there is no [signal] for it; as read_identified_arm()
[[nodiscard]] Matrix known_information(const ExcitationPlan& plan);

/// All settings of a plan, defaults included.
[[nodiscard]] std::vector<Setting> settings(const ExcitationPlan& plan);

/// The experiment file for the log that a designed motion will give: the sections of the plan's file with the
/// motion as [reference] and log.csv beside it as [log]. What is missing is filled in: decimation after the
/// highest frequency, weighted least squares, and where there is a [control], a [simulation] with the plan's
/// noise, so that rivid simulate makes the log.
///
/// @param folder  that the file is written to: paths in it are relative to that
/// @throws InputError  where the plan's file can not be read again
[[nodiscard]] std::string experiment_text(const ExcitationPlan& plan, const Excitation& excitation,
                                          const std::filesystem::path& folder);

}  // namespace rivid
