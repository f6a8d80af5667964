#pragma once

#include <cstddef>

#include "rivid/model/kinds.hpp"
#include "rivid/regressor/pack.hpp"
#include "rivid/regressor/vec3.hpp"

// The generator of rivid/regressor/regressor.hpp once more, for packs of samples and with all that is known of a
// chain beforehand put to use: which rotations between neighbours are quarter turns, which offsets are zero, which
// columns are wanted. Every link gets the step that was compiled for its case.
//
// This file is compiled once for each instruction set, by the files batch_<set>.cpp under flags of their own. An
// inline function or a template instance that such a file and another one both emit is kept once by the linker, for
// whichever machine it was compiled, and ends in an illegal instruction on an older one. Hence:
// - every template below is instantiated on a pack whose tag is of an unnamed namespace, so that it has internal
//   linkage; plain data alone crosses over;
// - nothing here calls Eigen or the standard library, save sin and cos of the C library, which are never inline;
// - rivid/types.hpp stays out: Eigen's alignment under these flags is not the library's.
// Files with flags were preferred to functions with attributes: clang does not inline across the latter.
namespace rivid::detail {

struct LinkPlan {
  double R[9];                      // rows of the rotation that `turn` speaks of
  double p[3];                      // origin of frame j in frame j−1
  double cos_theta, sin_theta;      // the constant angle about z_j
  double parent_w[3], parent_v[3];  // screw of joint j−1 in the axes of frame j at q_j = 0, θ = 0
  double accel[3];                  // of the base, turned likewise; for the first link
  double sign[10];                  // −1 where the link frame reverses the sign of a column of frame j
  unsigned mask;                    // wanted columns, XX in the lowest bit
  int step;                         // see step_number()
  bool revolute, shifted_angle;     // θ is not zero
};

// An own parameter of a joint, in the order of their columns.
struct OwnEntry {
  int joint;
  Basis basis;
  Direction direction;
  double sign_speed;
};

struct BatchPlan {
  const LinkPlan* links;
  std::size_t joints;
  const OwnEntry* own;
  std::size_t own_count;
};

// Doubles that a kernel of so many lanes writes its intermediate values to.
[[gnu::always_inline]] constexpr std::size_t kernel_scratch(std::size_t lanes, std::size_t joints) {
  return lanes * (18 + 8 * joints) + 16;
}

struct BatchInput {
  const double* q;  // of the first sample; a column a joint
  const double* qd;
  const double* qdd;
  std::ptrdiff_t q_stride, qd_stride, qdd_stride;
};

// What one file for an instruction set offers: rows of `packs` times `lanes` consecutive samples.
struct BatchKernel {
  int lanes;
  // columns: where each entry's column begins, in the order link j, joint i ≤ j, wanted column; then the own
  // entries. scratch: kernel_scratch(), aligned to 64 bytes.
  void (*fill)(const BatchPlan& plan, const BatchInput& input, std::size_t packs, double* const* columns,
               double* scratch);
};

[[nodiscard]] const BatchKernel& baseline_kernel();
[[nodiscard]] const BatchKernel& avx2_kernel();
[[nodiscard]] const BatchKernel& avx512_kernel();

// XX XY XZ YZ ZZ MX MY: what most links of a base regressor want.
inline constexpr unsigned usual_mask = 0xf7U;

// Number of a step in the table of BatchSteps: 5 turns × 8 offsets × revolute × usual mask.
[[gnu::always_inline]] constexpr int step_number(Turn turn, unsigned offsets, bool revolute, bool usual) {
  return ((static_cast<int>(turn) * 8 + static_cast<int>(offsets)) * 2 + (revolute ? 1 : 0)) * 2 +
         (usual ? 1 : 0);
}
inline constexpr int step_count = 5 * 8 * 2 * 2;

// What a step leaves to the next, followed in memory by the screws of all joints, then their angles.
template <typename Scalar>
struct BatchState {
  FrameMotion<Scalar> motion;
  Mat3<Scalar> U;
  // Inputs of the link at hand.
  const double* q;
  const double* qd;
  const double* qdd;
  const CosSin<Scalar>* angle;
};

// Where the next entry goes. Handed on by value: what is stored through it might else be itself.
struct Out {
  double* const* columns;
  std::ptrdiff_t row;
};

template <typename Scalar>
[[gnu::always_inline]] inline void put(Out& out, const Scalar& value) {
  value.store(*out.columns++ + out.row);
}

// The entries of one joint i and one link j: power of the link's wrenches on the joint's screw.
template <bool usual, typename Scalar>
[[gnu::always_inline]] inline void put_entries(Out& out, const LinkPlan& link, const Screw<Scalar>& s,
                                               const TensorMoments<Scalar>& moments, const Mat3<Scalar>& U,
                                               const Vec3<Scalar>& accel) {
  const Vec3<Scalar>& w = s.w;
  const Vec3<Scalar>& v = s.v;
  const auto mx = [&] { return U.r0.x * v.x + U.r1.x * v.y + U.r2.x * v.z + accel.y * w.z - accel.z * w.y; };
  const auto my = [&] { return U.r0.y * v.x + U.r1.y * v.y + U.r2.y * v.z + accel.z * w.x - accel.x * w.z; };
  if constexpr (usual) {
    put(out, dot(w, moments.k[0]));
    put(out, dot(w, moments.k[1]));
    put(out, dot(w, moments.k[2]));
    put(out, dot(w, moments.k[4]));
    put(out, dot(w, moments.k[5]));
    put(out, mx());
    put(out, my());
  } else {
    const auto wanted = [&](unsigned k) { return (link.mask >> k & 1U) != 0U; };
    for (unsigned k = 0; k < 6; ++k) {
      if (wanted(k)) {
        put(out, Scalar(link.sign[k]) * dot(w, moments.k[k]));
      }
    }
    if (wanted(6)) {
      put(out, Scalar(link.sign[6]) * mx());
    }
    if (wanted(7)) {
      put(out, Scalar(link.sign[7]) * my());
    }
    if (wanted(8)) {
      put(out, Scalar(link.sign[8]) *
                   (U.r0.z * v.x + U.r1.z * v.y + U.r2.z * v.z + accel.x * w.y - accel.y * w.x));
    }
    if (wanted(9)) {
      put(out, dot(v, accel));
    }
  }
}

// The same for joint j itself, whose screw is z.
template <bool usual, bool revolute, typename Scalar>
[[gnu::always_inline]] inline void put_own_entries(Out& out, const LinkPlan& link,
                                                   const TensorMoments<Scalar>& moments,
                                                   const Mat3<Scalar>& U, const Vec3<Scalar>& accel) {
  const Scalar zero(0.0);
  for (unsigned k = 0; k < 10; ++k) {
    if (usual ? (usual_mask >> k & 1U) == 0U : (link.mask >> k & 1U) == 0U) {
      continue;
    }
    Scalar value(0.0);
    if constexpr (revolute) {
      value = k < 6 ? moments.k[k < 6 ? k : 0].z : k == 6 ? accel.y : k == 7 ? -accel.x : zero;
    } else {
      value = k < 6 ? zero : k == 6 ? U.r2.x : k == 7 ? U.r2.y : k == 8 ? U.r2.z : accel.z;
    }
    put(out, usual ? value : Scalar(link.sign[k]) * value);
  }
}

template <typename Scalar>
[[gnu::always_inline]] inline CosSin<Scalar> joint_angle(const LinkPlan& link, const Scalar& q,
                                                         bool far_angles) {
  CosSin<Scalar> out;
  sin_cos_near(q, out.s, out.c);
  if (far_angles) [[unlikely]] {
    sin_cos_far(q, out.s, out.c);
  }
  if (link.shifted_angle) {
    const Scalar cos_theta(link.cos_theta);
    const Scalar sin_theta(link.sin_theta);
    const Scalar c = out.c;
    out.c = c * cos_theta - out.s * sin_theta;
    out.s = out.s * cos_theta + c * sin_theta;
  }
  return out;
}

// Link j ≥ 1: carries the screws of the joints before it and the motion into frame j, and puts the entries.
template <Turn turn, unsigned offsets, bool revolute, bool usual, typename Scalar>
double* const* step(const LinkPlan& link, BatchState<Scalar>& state, std::size_t j, Out out) {
  auto* const screws = reinterpret_cast<Screw<Scalar>*>(&state + 1);
  Scalar c(1.0);
  Scalar s(0.0);
  Scalar slide(0.0);
  if constexpr (revolute) {
    c = state.angle->c;
    s = state.angle->s;
  } else {
    slide = Scalar::load(state.q);
  }
  // Into the axes of frame j. A sliding joint stands turned by θ alone.
  if constexpr (!revolute) {
    c = Scalar(link.cos_theta);
    s = Scalar(link.sin_theta);
  }
  const auto into = [&](const Vec3<Scalar>& v) { return rotated(turned<turn>(link.R, v), c, s); };

  FrameMotion<Scalar> m = {into(state.motion.omega), into(state.motion.omega_dot),
                           into(accelerated<offsets>(state.motion.accel, state.U, link.p))};
  const Scalar qd = Scalar::load(state.qd);
  const Scalar qdd = Scalar::load(state.qdd);
  Mat3<Scalar> U;
  if constexpr (revolute) {
    // ω × z q̇ before the joint's own rate is added, which is along z.
    m.omega_dot.x = m.omega_dot.x + m.omega.y * qd;
    m.omega_dot.y = m.omega_dot.y - m.omega.x * qd;
    m.omega_dot.z = m.omega_dot.z + qdd;
    m.omega.z = m.omega.z + qd;
    U = acceleration_field(m);
  } else {
    U = acceleration_field(m);
    const Scalar twice = qd + qd;
    m.accel.x = m.accel.x + U.r0.z * slide + m.omega.y * twice;
    m.accel.y = m.accel.y + U.r1.z * slide - m.omega.x * twice;
    m.accel.z = m.accel.z + U.r2.z * slide + qdd;
  }
  const auto moments = TensorMoments<Scalar>::of(m, U);
  state.motion = m;
  state.U = U;

  for (std::size_t i = 0; i + 1 < j; ++i) {
    const Screw<Scalar>& before = screws[i];
    // NOLINTNEXTLINE(misc-const-correctness): prismatic joints change it
    Screw<Scalar> screw = {into(before.w), into(shifted<offsets>(before.v, before.w, link.p))};
    if constexpr (!revolute) {
      screw.v.x = screw.v.x + screw.w.y * slide;
      screw.v.y = screw.v.y - screw.w.x * slide;
    }
    screws[i] = screw;
    put_entries<usual>(out, link, screw, moments, U, m.accel);
  }
  // The joint before this one: its screw was constant in its own frame.
  // NOLINTNEXTLINE(misc-const-correctness): prismatic joints change it
  Screw<Scalar> parent = {rotated(constant<Scalar>(link.parent_w), c, s),
                          rotated(constant<Scalar>(link.parent_v), c, s)};
  if constexpr (!revolute) {
    parent.v.x = parent.v.x + parent.w.y * slide;
    parent.v.y = parent.v.y - parent.w.x * slide;
  }
  screws[j - 1] = parent;
  put_entries<usual>(out, link, parent, moments, U, m.accel);
  put_own_entries<usual, revolute>(out, link, moments, U, m.accel);
  return out.columns;
}

// The first link: the base does not move.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline double* const* first_step(const LinkPlan& link, BatchState<Scalar>& state,
                                                        Out out) {
  const Scalar zero(0.0);
  const Scalar qd = Scalar::load(state.qd);
  const Scalar qdd = Scalar::load(state.qdd);
  FrameMotion<Scalar> m = {{zero, zero, zero}, {zero, zero, zero}, constant<Scalar>(link.accel)};
  // NOLINTNEXTLINE(misc-const-correctness): revolute joints change it
  Mat3<Scalar> U = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
  if constexpr (revolute) {
    m.accel = rotated(m.accel, state.angle->c, state.angle->s);
    m.omega.z = qd;
    m.omega_dot.z = qdd;
    U.r0.x = -(qd * qd);
    U.r0.y = -qdd;
    U.r1.x = qdd;
    U.r1.y = U.r0.x;
  } else {
    m.accel = rotated(m.accel, Scalar(link.cos_theta), Scalar(link.sin_theta));
    m.accel.z = m.accel.z + qdd;
  }
  state.motion = m;
  state.U = U;
  put_own_entries<false, revolute>(out, link, TensorMoments<Scalar>::of(m, U), U, m.accel);
  return out.columns;
}

template <typename Scalar>
[[gnu::always_inline]] inline Scalar own_entry(const OwnEntry& entry, const Scalar& qd, const Scalar& qdd) {
  return entry.basis == Basis::acceleration
             ? qdd
             : friction_entry(entry.basis, entry.direction, qd, entry.sign_speed);
}

template <typename Scalar>
struct BatchSteps {
  using Step = double* const* (*)(const LinkPlan&, BatchState<Scalar>&, std::size_t, Out);
  Step table[step_count] = {};

  constexpr BatchSteps() {
    add_turn<Turn::none>();
    add_turn<Turn::plus>();
    add_turn<Turn::minus>();
    add_turn<Turn::about_x>();
    add_turn<Turn::any>();
  }

 private:
  template <Turn turn>
  constexpr void add_turn() {
    if constexpr (turn == Turn::any || turn == Turn::about_x) {
      // Rotations cost more than what offsets that are zero would save.
      for (unsigned offsets = 0; offsets < 8; ++offsets) {
        add_as<turn, 7>(offsets);
      }
    } else {
      add_as<turn, 0>(0);
      add_as<turn, 1>(1);
      add_as<turn, 2>(2);
      add_as<turn, 3>(3);
      add_as<turn, 4>(4);
      add_as<turn, 5>(5);
      add_as<turn, 7>(6);
      add_as<turn, 7>(7);
    }
  }
  template <Turn turn, unsigned offsets>
  constexpr void add_as(unsigned wanted) {
    table[step_number(turn, wanted, true, true)] = &step<turn, offsets, true, true, Scalar>;
    table[step_number(turn, wanted, true, false)] = &step<turn, offsets, true, false, Scalar>;
    table[step_number(turn, wanted, false, true)] = &step<Turn::any, 7, false, true, Scalar>;
    table[step_number(turn, wanted, false, false)] = &step<Turn::any, 7, false, false, Scalar>;
  }
};

template <typename Scalar>
void fill_packs(const BatchPlan& plan, const BatchInput& input, std::size_t packs, double* const* columns,
                double* scratch) {
  static constexpr BatchSteps<Scalar> steps;
  BatchState<Scalar>& state = *reinterpret_cast<BatchState<Scalar>*>(scratch);
  // One question for all samples: asked of every pack, it would cost as much as a sine.
  auto far_out = too_far(Scalar(0.0));
  for (std::size_t j = 0; j < plan.joints; ++j) {
    const double* const q = input.q + static_cast<std::ptrdiff_t>(j) * input.q_stride;
    for (std::size_t k = 0; plan.links[j].revolute && k < packs; ++k) {
      far_out = far_out | too_far(Scalar::load(q + k * static_cast<std::size_t>(Scalar::lanes)));
    }
  }
  const bool far_angles = any(far_out);
  auto* const angles =
      reinterpret_cast<CosSin<Scalar>*>(reinterpret_cast<Screw<Scalar>*>(&state + 1) + plan.joints);
  for (std::size_t k = 0; k < packs; ++k) {
    Out out = {columns, static_cast<std::ptrdiff_t>(k) * Scalar::lanes};
    // All angles first: one sine is a long chain of operations, many beside each other fill the pipelines.
    for (std::size_t j = 0; j < plan.joints; ++j) {
      const LinkPlan& link = plan.links[j];
      if (link.revolute) {
        const double* const q = input.q + static_cast<std::ptrdiff_t>(j) * input.q_stride + out.row;
        angles[j] = joint_angle(link, Scalar::load(q), far_angles);
      }
    }
    for (std::size_t j = 0; j < plan.joints; ++j) {
      const auto column = static_cast<std::ptrdiff_t>(j);
      state.angle = angles + j;
      state.q = input.q + column * input.q_stride + out.row;
      state.qd = input.qd + column * input.qd_stride + out.row;
      state.qdd = input.qdd + column * input.qdd_stride + out.row;
      const LinkPlan& link = plan.links[j];
      if (j == 0) {
        out.columns =
            link.revolute ? first_step<true>(link, state, out) : first_step<false>(link, state, out);
      } else {
        out.columns = steps.table[link.step](link, state, j, out);
      }
    }
    for (std::size_t e = 0; e < plan.own_count; ++e) {
      const std::ptrdiff_t joint = plan.own[e].joint;
      const Scalar qd = Scalar::load(input.qd + joint * input.qd_stride + out.row);
      const Scalar qdd = Scalar::load(input.qdd + joint * input.qdd_stride + out.row);
      put(out, own_entry(plan.own[e], qd, qdd));
    }
  }
}

}  // namespace rivid::detail
