#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "identify/rows/row_source.hpp"

namespace rivid::detail {

/// The rows of a log for several passes: [W Y] is made and decimated by the first one and held, so that later
/// ones make V alone. To decimate costs more than all else in a pass; rows that are not decimated are made
/// anew in less time than memory takes to give them back, and are many more.
class KeptRows {
 public:
  /// Memory of the kept rows of all logs of an identification [bytes]. Logs that it does not suffice for are
  /// read again in each pass.
  static constexpr std::size_t budget = std::size_t{64} << 20U;

  /// Whether rows of these options are worth it.
  [[nodiscard]] static bool worthwhile(const SignalOptions& signal);

  /// Log and options are referred to, not copied.
  ///
  /// @throws InputError  where RowSource does
  KeptRows(const Robot& robot, const BaseParameters& base, const Log& log, const SignalOptions& signal,
           ThreadTeam& team)
      : source_(robot, base, log, signal, team) {}

  [[nodiscard]] const RowSource& source() const { return source_; }
  /// Memory that this takes [bytes].
  [[nodiscard]] std::size_t bytes() const;

  /// What RowSource::send() sends, bit by bit.
  void send(std::span<RowSink* const> sinks, std::span<const Motion> others = {},
            const std::function<void(double)>& progress = {});

 private:
  void send_kept(std::span<RowSink* const> sinks) const;

  RowSource source_;
  std::vector<HeldRows> rows_;  // [W Y] of each joint, once they were sent
};

}  // namespace rivid::detail
