#pragma once

#include <span>
#include <vector>

#include "identify/infer/scores.hpp"
#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::detail {

// Columns of the arm's base parameters, and of those standard parameters of a link that are none of
// them.
struct PayloadColumns : BodyColumns {
  PayloadColumns(const Robot& robot, int link) : PayloadColumns(base_parameters(robot), link) {}
  PayloadColumns(const BaseParameters& of_arm, int link) : BodyColumns(link, of_arm), base(of_arm) {}

  BaseParameters base;  // of the arm, friction by load aside
};

// The rows of one joint from one log.
struct PayloadRows {
  std::size_t joint = 0;
  std::vector<Index> columns;  // of PayloadColumns::all
  Matrix W;
  Vector y;
  std::vector<Index> samples;
};

// The rows of one log.
struct PayloadLog {
  static constexpr Index no_load = -1;

  Index load = no_load;  // which of the payloads it has
  double f_m = 0.0;
  Index samples = 0;
  Index stride = 1;
  std::vector<PayloadRows> joints;
};

// All rows of a log, which are held: a payload is identified from minutes.
//
// robot  without friction by load
[[nodiscard]] PayloadLog payload_rows(const Robot& robot, const PayloadColumns& columns, const Log& log,
                                      const SignalOptions& signal, Index load, ThreadTeam& team);

// The rows of logs without and with payloads. Where the signal leaves them open they are chosen by the noise
// of those without, if there are any, else of the first with one; `estimation` has them then.
[[nodiscard]] std::vector<PayloadLog> stacked_rows(const Robot& robot, const PayloadColumns& columns,
                                                   std::span<const Log> without,
                                                   std::span<const LoadedLogs> with, Estimation& estimation);

}  // namespace rivid::detail
