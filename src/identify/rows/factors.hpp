#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "identify/rows/kept_rows.hpp"
#include "identify/rows/row_source.hpp"
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

// Blocks of time, each the groups of all joints, of which neighbours with the fewest rows are merged until at most so many are left.
[[nodiscard]] std::vector<std::vector<RowGroup>> fewer_blocks(std::vector<std::vector<RowGroup>> blocks,
                                                              Index most);

// The factors of the rows of all logs.
//
// signals  one a log
// kept     gets the rows on the way, one entry a log, nullptr for logs whose rows are made anew; or is nullptr
[[nodiscard]] RowFactors all_factors(const Robot& robot, const BaseParameters& base,
                                     std::span<const Log> logs, std::span<const SignalOptions> signals,
                                     ThreadTeam& team, const Progress& progress,
                                     std::vector<std::unique_ptr<KeptRows>>* kept = nullptr);

}  // namespace rivid::detail
