#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rivid/regressor/kinematics.hpp"

namespace rivid {

/// Positions, velocities and accelerations of the n joints at one instant.
template <typename Scalar>
struct State {
  std::span<const Scalar> q;    ///< (n) [rad | m]
  std::span<const Scalar> qd;   ///< (n) [rad/s | m/s]
  std::span<const Scalar> qdd;  ///< (n) [rad/s² | m/s²]
};

/// Scratch of inertial_regressor(), made once for a chain and used for any number of samples.
template <typename Scalar>
class RegressorWorkspace {
 public:
  explicit RegressorWorkspace(const Chain& chain) : screws_(chain.links.size()) {}

  [[nodiscard]] std::span<detail::Screw<Scalar>> screws() { return screws_; }

 private:
  std::vector<detail::Screw<Scalar>> screws_;
};

/// Set of inertial columns of a link, one bit for each of XX XY XZ YY YZ ZZ MX MY MZ M.
using InertialMask = std::uint16_t;
inline constexpr InertialMask all_inertials = 0x3ff;

namespace detail {

template <typename Scalar>
using InertialEntries = std::array<Scalar, inertial_count>;

}  // namespace detail

/// Inertial part of IDM_st of Eq. (2) of [RIV], block by block: the torque of joint i per unit of each inertial
/// parameter of link j, for all i ≤ j. The blocks below are zero and never made. Parameters and entries are those
/// of the chain's frames j (see inertial_column() for the way to link frames).
///
/// Every link's motion is carried from base to tip (recursive Newton-Euler), and with it the screws of all joints
/// before it; a joint's torque is the power of the link's wrench on that joint's screw.
///
/// @param state   (n) joint positions, velocities, accelerations
/// @param wanted  columns to fill for each link, (n); the other entries of a block are undefined
/// @param emit    called as emit(i, j, entries) with ten entries, j from 0 to n − 1, i from 0 to j
///
/// No allocation. Scalar is double, float, Pack, Eigen::AutoDiffScalar (for derivatives by q, q̇ and
/// q̈), or any number type with + − ×, sin and cos.
template <typename Scalar, typename Emit>
void inertial_regressor(const Chain& chain, const State<Scalar>& state, std::span<const InertialMask> wanted,
                        RegressorWorkspace<Scalar>& workspace, Emit&& emit) {
  using namespace detail;
  const std::span<Screw<Scalar>> screws = workspace.screws();
  FrameMotion<Scalar> motion = base_motion<Scalar>(chain);
  InertialEntries<Scalar> entries;
  for (std::size_t j = 0; j < chain.links.size(); ++j) {
    const Passage<Scalar> passage(chain.links[j], state.q[j]);
    for (std::size_t i = 0; i < j; ++i) {
      screws[i] = passage.carried(screws[i]);
    }
    screws[j] = passage.own_screw();
    motion = passage.carried(motion, state.qd[j], state.qdd[j]);

    const InertialMask mask = wanted[j];
    if (mask == 0) {
      continue;
    }
    const Mat3<Scalar> U = acceleration_field(motion);
    const auto moments = TensorMoments<Scalar>::of(motion, U);
    for (std::size_t i = 0; i <= j; ++i) {
      const Screw<Scalar>& s = screws[i];
      for (std::size_t k = 0; k < 6; ++k) {
        if ((mask >> k & 1U) != 0U) {
          entries[k] = dot(s.w, moments.k[k]);
        }
      }
      if ((mask >> 6 & 7U) != 0U) {
        // Force U MS through the linear part, moment MS × accel through the angular one.
        const Vec3<Scalar> first = U.transposed_times(s.v) + cross(motion.accel, s.w);
        entries[6] = first.x;
        entries[7] = first.y;
        entries[8] = first.z;
      }
      entries[9] = dot(s.v, motion.accel);
      emit(i, j, static_cast<const InertialEntries<Scalar>&>(entries));
    }
  }
}

}  // namespace rivid
