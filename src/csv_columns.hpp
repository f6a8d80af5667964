#pragma once

#include <string>
#include <utility>
#include <vector>

#include "rivid/text.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Columns of numbers as a CSV file: a line of headings, then a line a row.
class CsvColumns {
 public:
  using Format = std::string (*)(double);

  explicit CsvColumns(Index rows) : rows_(rows) {}

  /// @param values  of all rows, not copied
  void add(std::string heading, const double* values, Format format = &exact) {
    columns_.push_back({std::move(heading), values, format});
  }
  /// The columns of a matrix, not copied, as "q1", "q2" …
  void add_each(const std::string& prefix, const Matrix& values, Format format = &exact) {
    for (Index c = 0; c < values.cols(); ++c) {
      add(prefix + std::to_string(c + 1), values.col(c).data(), format);
    }
  }

  /// @param before  what each line begins with
  [[nodiscard]] std::string lines(const std::string& before = {}) const {
    std::string out;
    for (Index k = 0; k < rows_; ++k) {
      out += before;
      for (const Column& column : columns_) {
        out.append(&column == columns_.data() ? "" : ",").append(column.format(column.values[k]));
      }
      out += '\n';
    }
    return out;
  }
  [[nodiscard]] std::string text() const {
    std::string out;
    for (const Column& column : columns_) {
      out.append(out.empty() ? "" : ",").append(column.heading);
    }
    return out + '\n' + lines();
  }

 private:
  struct Column {
    std::string heading;
    const double* values;
    Format format;
  };
  Index rows_;
  std::vector<Column> columns_;
};

}  // namespace rivid::detail
