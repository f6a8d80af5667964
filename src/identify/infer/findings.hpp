#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "finding_codes.hpp"

namespace rivid::detail {

// What has been found so far, in the order in which it came.
class Findings {
 public:
  // changes  of the experiment, which the hint comes down to
  void add(FindingCode code, std::string subject, std::string text, std::vector<Change> changes = {});
  void add(const std::vector<Finding>& some) { all_.insert(all_.end(), some.begin(), some.end()); }

  [[nodiscard]] bool has(FindingCode code, std::string_view subject = {}) const;
  [[nodiscard]] bool any(Severity of) const;
  void drop(FindingCode code);
  [[nodiscard]] const std::vector<Finding>& all() const { return all_; }
  // The gravest first.
  [[nodiscard]] std::vector<Finding> sorted() &&;

 private:
  std::vector<Finding> all_;
};

}  // namespace rivid::detail
