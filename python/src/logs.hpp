#pragma once

#include <span>
#include <vector>

#include "rivid/data/log.hpp"

namespace rivid::python {

/// Logs of Python side by side; one is not copied.
class Logs {
 public:
  explicit Logs(const std::vector<const Log*>& logs) {
    if (logs.size() == 1) {
      all_ = std::span(logs.front(), 1);
      return;
    }
    copies_.reserve(logs.size());
    for (const Log* const log : logs) {
      copies_.push_back(*log);
    }
    all_ = copies_;
  }

  [[nodiscard]] std::span<const Log> all() const { return all_; }

 private:
  std::vector<Log> copies_;
  std::span<const Log> all_;
};

}  // namespace rivid::python
