#pragma once

#include <cstddef>

#include "rivid/model/kinds.hpp"
#include "rivid/regressor/pack.hpp"
#include "rivid/regressor/vec3.hpp"

// The generator of the regressor, for any Scalar: one sample, or a pack of samples. All that is known of a
// chain beforehand is put to use: which rotations between neighbours are quarter turns, which offsets are
// zero, which columns are wanted. For packs of the library's batches every link gets the step that was
// compiled for its case.
//
// For those it is compiled once for each instruction set, from src/pack_kernel.cpp.in under flags of its own.
// An inline function or a template instance that such a file and another one both emit is kept once by the
// linker, for whichever machine it was compiled, and ends in an illegal instruction on an older one. Hence:
// - every template below is instantiated there on a pack whose tag is of an unnamed namespace, so that it has
//   internal linkage; plain data alone crosses over;
// - nothing here calls Eigen or the standard library, save sin, cos, tanh and exp of the C library, never
//   inline;
// - rivid/types.hpp stays out: Eigen's alignment under these flags is not the library's.
// Files with flags were preferred to functions with attributes: clang does not inline across the latter.
namespace rivid::detail {

struct LinkPlan : Frame {
  double parent_w[3], parent_v[3];  // screw of joint j−1 in the axes of frame j at q_j = 0, θ = 0
  double accel[3];                  // of the base, turned likewise; for the first link
  double sign[10];                  // −1 where the link frame reverses the sign of a column of frame j
  unsigned mask;                    // wanted columns, XX in the lowest bit
  int step;                         // see step_number()
  int parent;                       // link that carries it; −1: the base
  int depth;                        // number of links that carry it
  int end;                          // behind the last link that it carries
  int fork;  // where links branch, place for what one of them leaves to the others; else −1
};

// An own parameter of a joint, in the order of their columns.
struct OwnEntry {
  int joint;
  Basis basis;
  Direction direction;
  double sign_speed;
};

struct RegressorPlan {
  const LinkPlan* links;
  std::size_t joints;
  const OwnEntry* own;
  std::size_t own_count;
  std::size_t forks;
};

// Values of the first sample; a column a joint. See Stored.
template <typename Value>
struct RegressorInput {
  const Value* q;
  const Value* qd;
  const Value* qdd;
  std::ptrdiff_t q_stride, qd_stride, qdd_stride;
};

// XX XY XZ YZ ZZ MX MY: what most links of a base regressor want.
inline constexpr unsigned usual_mask = 0xf7U;

// Number of a step in the table of RegressorSteps: 5 turns × 8 offsets × revolute × usual mask.
[[gnu::always_inline]] constexpr int step_number(Turn turn, unsigned offsets, bool revolute, bool usual) {
  return ((static_cast<int>(turn) * 8 + static_cast<int>(offsets)) * 2 + (revolute ? 1 : 0)) * 2 +
         (usual ? 1 : 0);
}
inline constexpr int step_count = 5 * 8 * 2 * 2;  // turns × offsets × types × masks

// State of a link on which several hang.
template <typename Scalar>
struct ForkState {
  FrameMotion<Scalar> motion;
  Mat3<Scalar> U;
};

// Scratch: one of each for a joint, then for a fork, with screws of all joints.
template <typename Scalar>
struct RegressorScratch {
  Screw<Scalar>* screws;
  CosSin<Scalar>* angles;
  ForkState<Scalar>* forks;
  Screw<Scalar>* fork_screws;
};

// What a step leaves to the next.
template <typename Scalar>
struct RegressorState {
  using Value = typename Stored<Scalar>::Value;
  FrameMotion<Scalar> motion;
  Mat3<Scalar> U;
  Screw<Scalar>* screws;
  // Inputs of the link at hand.
  const Value* q;
  const Value* qd;
  const Value* qdd;
  const CosSin<Scalar>* angle;
};

// Where the next entry goes. Handed on by value: what is stored through it might else be itself.
template <typename Scalar>
struct Out {
  typename Stored<Scalar>::Value* const* columns;
  std::ptrdiff_t row;

  [[gnu::always_inline]] void put(const Scalar& value) { Stored<Scalar>::store(value, *columns++ + row); }
};

// The entries of one joint i and one link j: power of the link's wrenches on the joint's screw.
template <bool usual, typename Scalar>
[[gnu::always_inline]] inline void put_entries(Out<Scalar>& out, const LinkPlan& link, const Screw<Scalar>& s,
                                               const TensorMoments<Scalar>& moments, const Mat3<Scalar>& U,
                                               const Vec3<Scalar>& accel) {
  const Vec3<Scalar>& w = s.w;
  const Vec3<Scalar>& v = s.v;
  const auto mx = [&]() -> Scalar {
    return U.r0.x * v.x + U.r1.x * v.y + U.r2.x * v.z + accel.y * w.z - accel.z * w.y;
  };
  const auto my = [&]() -> Scalar {
    return U.r0.y * v.x + U.r1.y * v.y + U.r2.y * v.z + accel.z * w.x - accel.x * w.z;
  };
  if constexpr (usual) {
    out.put(dot(w, moments.k[0]));
    out.put(dot(w, moments.k[1]));
    out.put(dot(w, moments.k[2]));
    out.put(dot(w, moments.k[4]));
    out.put(dot(w, moments.k[5]));
    out.put(mx());
    out.put(my());
  } else {
    const auto wanted = [&](unsigned k) { return (link.mask >> k & 1U) != 0U; };
    for (unsigned k = 0; k < 6; ++k) {
      if (wanted(k)) {
        out.put(Scalar(link.sign[k]) * dot(w, moments.k[k]));
      }
    }
    if (wanted(6)) {
      out.put(Scalar(link.sign[6]) * mx());
    }
    if (wanted(7)) {
      out.put(Scalar(link.sign[7]) * my());
    }
    if (wanted(8)) {
      out.put(Scalar(link.sign[8]) *
              (U.r0.z * v.x + U.r1.z * v.y + U.r2.z * v.z + accel.x * w.y - accel.y * w.x));
    }
    if (wanted(9)) {
      out.put(dot(v, accel));
    }
  }
}

// The same for joint j itself, whose screw is z.
template <bool usual, bool revolute, typename Scalar>
[[gnu::always_inline]] inline void put_own_entries(Out<Scalar>& out, const LinkPlan& link,
                                                   const TensorMoments<Scalar>& moments,
                                                   const Mat3<Scalar>& U, const Vec3<Scalar>& accel) {
  const Scalar zero(0.0);
  for (unsigned k = 0; k < 10; ++k) {
    if (usual ? (usual_mask >> k & 1U) == 0U : (link.mask >> k & 1U) == 0U) {
      continue;
    }
    Scalar value(0.0);
    if constexpr (revolute) {
      value = k < 6 ? moments.k[k < 6 ? k : 0].z : k == 6 ? accel.y : k == 7 ? Scalar(-accel.x) : zero;
    } else {
      value = k < 6 ? zero : k == 6 ? U.r2.x : k == 7 ? U.r2.y : k == 8 ? U.r2.z : accel.z;
    }
    if constexpr (usual) {
      out.put(value);
    } else {
      out.put(Scalar(link.sign[k]) * value);
    }
  }
}

// far_angles: whether some angle may be too large for the quick way of a pack
template <typename Scalar>
[[gnu::always_inline]] inline CosSin<Scalar> joint_angle(const LinkPlan& link, const Scalar& q,
                                                         [[maybe_unused]] bool far_angles) {
  CosSin<Scalar> out;
  if constexpr (requires { sin_cos_near(q, out.s, out.c); }) {
    sin_cos_near(q, out.s, out.c);
    if (far_angles) [[unlikely]] {
      sin_cos_far(q, out.s, out.c);
    }
  } else {
    sin_cos(q, out.s, out.c);
  }
  return with_theta(link, out);
}

// Whether an angle of any sample is too large for the quick way. One question for all samples: asked of every
// pack, it would cost as much as a sine.
template <typename Scalar, typename Value>
[[gnu::always_inline]] inline bool any_too_far([[maybe_unused]] const RegressorPlan& plan,
                                               [[maybe_unused]] const RegressorInput<Value>& input,
                                               [[maybe_unused]] std::size_t count) {
  if constexpr (requires(const Scalar& q) { too_far(q); }) {
    auto far_out = too_far(Scalar(0.0));
    for (std::size_t j = 0; j < plan.joints; ++j) {
      const Value* const q = input.q + static_cast<std::ptrdiff_t>(j) * input.q_stride;
      for (std::size_t k = 0; plan.links[j].revolute && k < count; ++k) {
        far_out = far_out |
                  too_far(Stored<Scalar>::load(q + static_cast<std::ptrdiff_t>(k) * Stored<Scalar>::lanes));
      }
    }
    return any(far_out);
  } else {
    return false;
  }
}

// Link that others carry: takes the screws of their joints and the motion into its frame, and puts the
// entries.
template <Turn turn, unsigned offsets, bool revolute, bool usual, typename Scalar>
auto step(const LinkPlan& link, RegressorState<Scalar>& state, Out<Scalar> out) {
  using Memory = Stored<Scalar>;
  const auto j = static_cast<std::size_t>(link.depth);
  Screw<Scalar>* const screws = state.screws;
  // A sliding joint stands turned by θ alone.
  CosSin<Scalar> angle = {Scalar(link.cos_theta), Scalar(link.sin_theta)};
  Scalar way(0.0);
  if constexpr (revolute) {
    angle = *state.angle;
  } else {
    way = Memory::load(state.q);
  }
  const auto into = [&](const Vec3<Scalar>& v) { return rotated(turned<turn>(link.R, v), angle.c, angle.s); };
  FrameMotion<Scalar> m = carried<turn, offsets>(link, state.motion, state.U, angle);
  const Scalar qd = Memory::load(state.qd);
  const Scalar qdd = Memory::load(state.qdd);
  Mat3<Scalar> U;
  if constexpr (revolute) {
    spin(m, qd);
    m.omega_dot.z = m.omega_dot.z + qdd;
    U = acceleration_field(m);
  } else {
    U = acceleration_field(m);
    slide(m, U, way, qd);
    m.accel.z = m.accel.z + qdd;
  }
  const auto moments = TensorMoments<Scalar>::of(m, U);
  state.motion = m;
  state.U = U;

  // A prismatic joint's way moves the origin of a screw.
  const auto moved = [&](Screw<Scalar>& screw) {
    if constexpr (!revolute) {
      screw.v.x = screw.v.x + screw.w.y * way;
      screw.v.y = screw.v.y - screw.w.x * way;
    }
  };
  for (std::size_t i = 0; i + 1 < j; ++i) {
    const Screw<Scalar>& before = screws[i];
    Screw<Scalar> screw = {into(before.w), into(shifted<offsets>(before.v, before.w, link.p))};
    moved(screw);
    screws[i] = screw;
    put_entries<usual>(out, link, screw, moments, U, m.accel);
  }
  // The joint before this one: its screw was constant in its own frame.
  Screw<Scalar> parent = {rotated(constant<Scalar>(link.parent_w), angle.c, angle.s),
                          rotated(constant<Scalar>(link.parent_v), angle.c, angle.s)};
  moved(parent);
  screws[j - 1] = parent;
  put_entries<usual>(out, link, parent, moments, U, m.accel);
  put_own_entries<usual, revolute>(out, link, moments, U, m.accel);
  return out.columns;
}

// A link on the base, which does not move.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline auto first_step(const LinkPlan& link, RegressorState<Scalar>& state,
                                              Out<Scalar> out) {
  const Scalar zero(0.0);
  const Scalar qd = Stored<Scalar>::load(state.qd);
  const Scalar qdd = Stored<Scalar>::load(state.qdd);
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
[[gnu::always_inline]] inline void copy_screws(const Screw<Scalar>* from, int count, Screw<Scalar>* to) {
  for (int i = 0; i < count; ++i) {
    to[i] = from[i];
  }
}

template <typename Scalar>
[[gnu::always_inline]] inline Scalar own_entry(const OwnEntry& entry, const Scalar& qd, const Scalar& qdd) {
  return entry.basis == Basis::acceleration
             ? qdd
             : friction_entry(entry.basis, entry.direction, qd, entry.sign_speed);
}

template <typename Scalar>
struct RegressorSteps {
  using Step = typename Stored<Scalar>::Value* const* (*)(const LinkPlan&, RegressorState<Scalar>&,
                                                          Out<Scalar>);
  Step table[step_count] = {};

  constexpr RegressorSteps() {
    if constexpr (has_quick_steps<Scalar>) {
      for_each_step([this]<Turn turn, unsigned offsets>(unsigned of) {
        table[step_number(turn, of, true, true)] = &step<turn, offsets, true, true, Scalar>;
        table[step_number(turn, of, true, false)] = &step<turn, offsets, true, false, Scalar>;
        table[step_number(turn, of, false, true)] = &step<Turn::any, 7, false, true, Scalar>;
        table[step_number(turn, of, false, false)] = &step<Turn::any, 7, false, false, Scalar>;
      });
    } else {
      for (int k = 0; k < step_count; k += 4) {
        table[k] = table[k + 1] = &step<Turn::any, 7, false, false, Scalar>;
        table[k + 2] = table[k + 3] = &step<Turn::any, 7, true, false, Scalar>;
      }
    }
  }
};

// Rows of `count` Scalars, one after the other.
//
// columns: where each entry's column begins, in the order link j, joint i that carries it or its own, wanted
// column; then the own entries.
template <typename Scalar, typename Value = typename Stored<Scalar>::Value>
[[gnu::always_inline]] inline void fill_rows(const RegressorPlan& plan, const RegressorInput<Value>& input,
                                             std::size_t count, Value* const* columns,
                                             const RegressorScratch<Scalar>& scratch) {
  using Memory = Stored<Scalar>;
  static constexpr RegressorSteps<Scalar> steps;
  RegressorState<Scalar> state;
  state.screws = scratch.screws;
  const bool far_angles = any_too_far<Scalar>(plan, input, count);
  for (std::size_t k = 0; k < count; ++k) {
    Out<Scalar> out = {columns, static_cast<std::ptrdiff_t>(k) * Memory::lanes};
    // All angles first: one sine is a long chain of operations, many beside each other fill the pipelines.
    for (std::size_t j = 0; j < plan.joints; ++j) {
      const LinkPlan& link = plan.links[j];
      if (link.revolute) {
        const Value* const q = input.q + static_cast<std::ptrdiff_t>(j) * input.q_stride + out.row;
        scratch.angles[j] = joint_angle(link, Memory::load(q), far_angles);
      }
    }
    for (std::size_t j = 0; j < plan.joints; ++j) {
      const auto column = static_cast<std::ptrdiff_t>(j);
      state.angle = scratch.angles + j;
      state.q = input.q + column * input.q_stride + out.row;
      state.qd = input.qd + column * input.qd_stride + out.row;
      state.qdd = input.qdd + column * input.qdd_stride + out.row;
      const LinkPlan& link = plan.links[j];
      if (link.depth == 0) {
        out.columns =
            link.revolute ? first_step<true>(link, state, out) : first_step<false>(link, state, out);
      } else {
        if (link.parent + 1 != static_cast<int>(j)) [[unlikely]] {
          const int fork = plan.links[link.parent].fork;
          state.motion = scratch.forks[fork].motion;
          state.U = scratch.forks[fork].U;
          copy_screws(scratch.fork_screws + static_cast<std::size_t>(fork) * plan.joints, link.depth - 1,
                      state.screws);
        }
        out.columns = steps.table[link.step](link, state, out);
      }
      if (link.fork >= 0) [[unlikely]] {
        scratch.forks[link.fork] = {state.motion, state.U};
        copy_screws(state.screws, link.depth,
                    scratch.fork_screws + static_cast<std::size_t>(link.fork) * plan.joints);
      }
    }
    for (std::size_t e = 0; e < plan.own_count; ++e) {
      const std::ptrdiff_t joint = plan.own[e].joint;
      const Scalar qd = Memory::load(input.qd + joint * input.qd_stride + out.row);
      const Scalar qdd = Memory::load(input.qdd + joint * input.qdd_stride + out.row);
      out.put(own_entry(plan.own[e], qd, qdd));
    }
  }
}

}  // namespace rivid::detail
