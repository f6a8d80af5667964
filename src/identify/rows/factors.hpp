#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/rows/kept_rows.hpp"
#include "identify/rows/row_source.hpp"
#include "ranges.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/rows.hpp"
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
[[nodiscard]] JointSinks<FactorSink> factor_sinks(std::span<RowGroup> groups);

// Groups of the same columns without any rows.
[[nodiscard]] std::vector<RowGroup> empty_groups(std::span<const RowGroup> like);

[[nodiscard]] Index rows_of(std::span<const RowGroup> groups);

// Adds the factors of other logs.
void add_factors(RowFactors& into, RowFactors part);

// Whether factors are of joints with these columns.
//
// carried  columns beside so many of a joint's own
template <typename Group, typename Carried>
[[nodiscard]] bool are_of(const std::vector<Group>& groups, std::span<const std::vector<Index>> columns,
                          const Carried& carried) {
  return std::ranges::equal(groups, columns, [&](const Group& group, const std::vector<Index>& own) {
    return group.columns == own && group.qr.columns() == std::ssize(own) &&
           group.qr.carried() == carried(std::ssize(own));
  });
}

// The columns that the factors of each joint touch.
template <typename Group>
[[nodiscard]] std::vector<std::vector<Index>> columns_of(const std::vector<Group>& groups) {
  return made_of(groups, &Group::columns);
}

// Adds the rows of other groups of the same columns; takes these where there are none yet.
template <typename Group>
void merge_groups(std::vector<Group>& into, std::vector<Group> groups) {
  if (into.empty()) {
    into = std::move(groups);
    return;
  }
  for (std::size_t g = 0; g < into.size(); ++g) {
    into[g].qr.merge(groups[g].qr);
  }
}

// Blocks of time, each the groups of all joints, of which neighbours with the fewest rows are merged until at
// most so many are left.
template <typename Group>
[[nodiscard]] std::vector<std::vector<Group>> fewer_blocks(std::vector<std::vector<Group>> blocks,
                                                           Index most) {
  const auto rows = [&](std::size_t g) {
    return sum_of(blocks[g], [&](const Group& group) { return group.qr.rows(); });
  };
  while (std::ssize(blocks) > most) {
    std::size_t least = 0;
    const auto pair_rows = [&](std::size_t g) { return rows(g) + rows(g + 1); };
    for (std::size_t g = 1; g + 1 < blocks.size(); ++g) {
      least = pair_rows(g) < pair_rows(least) ? g : least;
    }
    merge_groups(blocks[least], std::move(blocks[least + 1]));
    blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(least) + 1);
  }
  return blocks;
}

// The factors of the rows of all logs.
//
// signals  one a log
// kept     gets the rows on the way, one entry a log, nullptr for logs whose rows are made anew; or is
//          nullptr
[[nodiscard]] RowFactors all_factors(const Robot& robot, const BaseParameters& base,
                                     std::span<const Log> logs, std::span<const SignalOptions> signals,
                                     ThreadTeam& team, const Progress& progress,
                                     std::vector<std::unique_ptr<KeptRows>>* kept = nullptr);

}  // namespace rivid::detail
