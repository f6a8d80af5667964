#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/loop_factors.hpp"

// Factors of logs as files, so that each log is read where it is, and the files are merged elsewhere.
namespace rivid {

/// A log that factors were made of.
struct FactoredLog {
  std::string path;
  std::string sha256;  ///< of its content
};

/// Factors of logs, and what they were made from.
struct FactorsFile {
  LogFactors factors;
  std::vector<FactoredLog> logs;
  std::string run;  ///< run_id() of the run that wrote the file; empty where a program made it, or rivid
                    ///< before it had any
  std::filesystem::path experiment;   ///< absolute; empty where a program made them
  std::vector<std::string> settings;  ///< that were laid over the experiment, and the rows that were chosen
  /// Key and value, as JSON, of what decides about rows: of the robot, of the reading of logs and of the
  /// signal chain.
  std::vector<std::pair<std::string, std::string>> made_with;
};

/// Factors of given logs.
///
/// @param experiment  whose signal options leave nothing open, see chosen_signal()
/// @param logs        that read_logs() made of these
/// @throws InputError  as log_factors() does
[[nodiscard]] FactorsFile factors_of(const Experiment& experiment, std::span<const Log> logs,
                                     std::span<const FactoredLog> files, int blocks);

/// Adds the logs of another file. What comes of it is of neither run: `into.run` is empty then.
///
/// @param source  the other file, for messages
/// @throws InputError  where it was made of another robot or with other settings, which the message names, or
///                     of the same log
void merge(FactorsFile& into, const FactorsFile& other, std::string_view source);

/// The identification that identify() makes of the factors, validated on the validation logs of the
/// experiment.
///
/// @param experiment  as the factors were made with it, save [method], which may be another one
/// @param source      the factors, for messages
/// @param ask         for the closed loops of the logs, of instrumental variables
/// @throws InputError  where that is not so, and as identify() does
[[nodiscard]] Identification identify_factors(const Experiment& experiment, const FactorsFile& file,
                                              std::string_view source, const LoopAsk& ask = {});

/// "signal.decimation=[20]" and what else chosen_signal() decides, to be laid over an experiment file.
[[nodiscard]] std::vector<std::string> row_settings(const SignalOptions& signal);

/// Content of a .factors file. Every number comes back bit for bit. All values are little-endian, whatever
/// the machine:
///
/// | bytes | what |
/// |---|---|
/// | 8 | `rivid-LF` |
/// | 4, 4 | version of the format, 1; the number 0x01020304, which shows the order of the bytes |
/// | 8, … | bytes of a JSON text, and the text: run, robot, settings, logs, columns of each joint, counts |
/// | 8, … each | bytes of a factor, and the factor as encoded(const StreamingQr&) |
/// | 8 | FNV-1a checksum of all bytes before it |
///
/// Factors are of all rows joint by joint; where convention `matlab` decimates, of those before decimation;
/// then block by block.
[[nodiscard]] std::string encoded(const FactorsFile& file);

/// What encoded() wrote.
///
/// @param source  a name for messages, such as the path of the file
/// @throws InputError  where the content is none of that: another kind of file, another version, truncated,
///                     damaged
[[nodiscard]] FactorsFile decoded_factors(std::string_view content, std::string_view source);

/// The factors in a file.
///
/// @throws InputError  where the file can not be read, and as decoded_factors() does
[[nodiscard]] FactorsFile read_factors(const std::filesystem::path& path);

[[nodiscard]] std::string encoded(const LoopRequest& request);

/// What encoded() wrote.
///
/// @param source  a name for messages
/// @throws InputError  where the content is none of that: another kind of content, another version,
///                     truncated, damaged
[[nodiscard]] LoopRequest decoded_loop_request(std::string_view content, std::string_view source);

/// Laid out as encoded(const FactorsFile&), with `rivid-LQ` before a request and `rivid-LL` before factors:
/// these of all rows joint by joint, of [W Y] where W took columns of V, then block by block.
[[nodiscard]] std::string encoded(const LoopFactors& factors);

/// @copydoc decoded_loop_request
[[nodiscard]] LoopFactors decoded_loop_factors(std::string_view content, std::string_view source);

}  // namespace rivid
