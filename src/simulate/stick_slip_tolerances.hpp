#pragma once

// Numbers of StickSlip that the kernels of LoopPack need as well.
namespace rivid::detail {

// Added to the diagonal of G, relative to it: makes λ unique where elements at rest depend on one another, and moves
// the instant of a release by as much of itself.
inline constexpr double stick_slip_regularisation = 1e-11;

}  // namespace rivid::detail
