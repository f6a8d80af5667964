#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/finding.hpp"

// What a tool says on standard output and standard error.
namespace rivid::apps {

/// The value of --color: "auto", "always" or "never".
[[nodiscard]] std::string& when_coloured();

/// One line on standard error: "rivid: error: what".
void complain(std::string_view name, std::string_view kind, std::string_view what);

/// Standard output, words such as "error" in colour where --color says so.
///
/// @throws InputError  where it can not be written to
void print(const std::string& text);

/// Columns of the terminal on standard output; 0 where that is no terminal.
[[nodiscard]] std::size_t screen_width();

/// Lines on standard error.
void tell(const std::string& text);

/// One line each on standard error, the kind in colour where --color says so: "warning: …".
void tell(std::string_view kind, const std::vector<std::string>& lines);
/// The same of findings: "warning [code] …".
void tell(const std::vector<Finding>& findings);

/// A file that a tool will write, and the extension of such files.
struct PlannedFile {
  std::filesystem::path path;
  std::string extension;
  bool continued = false;  ///< what is there is read and carried on by the run
};

/// "wrote FILE" on standard error, one line each.
void tell_written(const std::vector<PlannedFile>& files);

/// Names a page on standard error and, where a person sits at a screen, opens it in a browser.
void show_page(const std::filesystem::path& page);

/// A progress bar on standard error: on a terminal only, and only for work that takes longer than a second.
class ProgressBar {
 public:
  /// @param wanted  false never draws
  explicit ProgressBar(bool wanted);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  void operator()(std::string_view stage, double fraction);
  /// Takes the bar off the terminal, so that other output can follow.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool wanted_;
  bool drawn_ = false;
  Clock::time_point next_;
};

}  // namespace rivid::apps
