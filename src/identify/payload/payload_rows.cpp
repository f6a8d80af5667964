#include "identify/choose/row_choice.hpp"
#include "identify/payload/payload_model.hpp"
#include "identify/rows/row_source.hpp"

namespace rivid::detail {

PayloadLog payload_rows(const Robot& robot, const PayloadColumns& columns, const Log& log,
                        const SignalOptions& signal, Index load, ThreadTeam& team) {
  RowSource source(robot, columns.all, log, signal, team);
  JointSinks<HeldRows> held(source.joints(), [&](std::size_t j) {
    return HeldRows(source.rows() + RowSource::most_wanted, std::ssize(source.columns(j)) + 1);
  });
  source.send(held.sinks());
  PayloadLog out{load, log.f_m, log.samples(), stride_of(signal), {}};
  for (std::size_t j = 0; j < source.joints(); ++j) {
    const Matrix rows = held[j].rows();
    const Index own = rows.cols() - 1;
    out.joints.push_back(
        {j, source.columns(j), rows.leftCols(own), rows.col(own), std::move(held[j].samples())});
  }
  return out;
}

std::vector<PayloadLog> stacked_rows(const Robot& robot, const PayloadColumns& columns,
                                     std::span<const Log> without, std::span<const LoadedLogs> with,
                                     Estimation& estimation) {
  estimation.method = Wls{};
  if (estimation.signal.automatic()) {
    static_cast<void>(choose_rows(robot, without.empty() ? with.front().logs : without, estimation));
  }
  ThreadTeam team(estimation.threads);
  std::vector<PayloadLog> out;
  const auto add = [&](std::span<const Log> logs, Index load) {
    for (const Log& log : logs) {
      out.push_back(payload_rows(robot, columns, log, estimation.signal, load, team));
    }
  };
  add(without, PayloadLog::no_load);
  for (std::size_t k = 0; k < with.size(); ++k) {
    add(with[k].logs, static_cast<Index>(k));
  }
  return out;
}

}  // namespace rivid::detail
