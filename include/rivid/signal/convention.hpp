#pragma once

namespace rivid {

/// Whose habits decide where a choice is free: the padding of zero_phase(), and the padding, the scale and
/// the kept samples of decimate(). Once the border samples are dropped (settling_samples()) the padding no
/// longer matters.
enum class Convention {
  standard,  ///< rivid's own, argued at the functions that take it
  matlab     ///< that of MATLAB's filtfilt and decimate, to reproduce what was published with them
};

}  // namespace rivid
