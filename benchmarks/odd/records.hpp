#pragma once

#include <filesystem>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "odd/experiment.hpp"

namespace rivid::odd {

/// The file that records are appended to, one line each, so that a run that was stopped goes on where it was.
class RecordFile {
 public:
  /// Reads what is there already.
  ///
  /// @throws InputError  where the file is another one
  explicit RecordFile(std::filesystem::path file);

  [[nodiscard]] bool has(const Name& name, const std::string& method) const;
  void append(std::span<const Record> records);
  [[nodiscard]] const std::vector<Record>& records() const { return records_; }

 private:
  std::filesystem::path file_;
  std::vector<Record> records_;
  std::set<std::string> keys_;
  std::mutex mutex_;
};

/// Tables by kind and group in Markdown, one a method, and how the errors of IV compare with those of WLS.
[[nodiscard]] std::string tables(std::span<const Record> records);

/// Which warnings and which findings of check() are how frequent, kind by kind, in Markdown.
[[nodiscard]] std::string code_table(std::span<const Record> records);

/// How many intervals of each friction parameter hold its truth, kind by kind, in Markdown.
[[nodiscard]] std::string friction_table(std::span<const Record> records);

}  // namespace rivid::odd
