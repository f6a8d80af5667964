#pragma once

#include "rivid/types.hpp"

namespace rivid {

/// Rows in memory of somebody else's: entry (row, column) is data[row + column * ld].
struct RowsTarget {
  double* data = nullptr;
  Index ld = 0;
};

/// Room for rows in the memory of whoever consumes them, so that a producer writes each row once.
struct RowsRoom {
  RowsTarget target;
  Index rows = 0;  ///< that fit
};

}  // namespace rivid
