#pragma once

#include <span>
#include <vector>

#include "identify/row_source.hpp"
#include "rivid/solve/least_squares.hpp"

namespace rivid::detail {

// Takes the rows of a joint into its factor.
class FactorSink final : public RowSink {
 public:
  explicit FactorSink(StreamingQr& qr) : qr_(qr) {}
  RowsRoom room(Index wanted) override { return qr_.room(wanted); }
  void commit(std::span<const Index> samples) override { qr_.commit(static_cast<Index>(samples.size())); }

 private:
  StreamingQr& qr_;
};
static_assert(RowSource::most_wanted == StreamingQr::most_rows);

// Sinks into the factors of all joints.
class FactorSinks {
 public:
  explicit FactorSinks(std::span<RowGroup> groups) {
    own_.reserve(groups.size());
    sinks_.reserve(groups.size());
    for (RowGroup& group : groups) {
      sinks_.push_back(&own_.emplace_back(group.qr));
    }
  }
  [[nodiscard]] std::span<RowSink* const> sinks() const { return sinks_; }

 private:
  std::vector<FactorSink> own_;
  std::vector<RowSink*> sinks_;
};

// Groups of the same columns without any rows.
[[nodiscard]] inline std::vector<RowGroup> empty_groups(std::span<const RowGroup> like) {
  std::vector<RowGroup> out;
  out.reserve(like.size());
  for (const RowGroup& group : like) {
    out.push_back({group.columns, StreamingQr(static_cast<Index>(group.columns.size()))});
  }
  return out;
}

}  // namespace rivid::detail
