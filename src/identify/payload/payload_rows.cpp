#include "identify/payload/payload_rows.hpp"

#include "identify/rows/row_source.hpp"

namespace rivid::detail {

PayloadLog payload_rows(const Robot& robot, const PayloadColumns& columns, const Log& log,
                        const SignalOptions& signal, bool loaded, ThreadTeam& team) {
  RowSource source(robot, columns.all, log, signal, team);
  JointSinks<HeldRows> held(source.joints());
  for (std::size_t j = 0; j < source.joints(); ++j) {
    held.add(source.rows() + RowSource::most_wanted, static_cast<Index>(source.columns(j).size()) + 1);
  }
  source.send(held.sinks());
  PayloadLog out{loaded, log.f_m, log.samples(), stride_of(signal), {}};
  for (std::size_t j = 0; j < source.joints(); ++j) {
    const Matrix rows = held[j].rows();
    const Index own = rows.cols() - 1;
    out.joints.push_back(
        {j, source.columns(j), rows.leftCols(own), rows.col(own), std::move(held[j].samples())});
  }
  return out;
}

}  // namespace rivid::detail
