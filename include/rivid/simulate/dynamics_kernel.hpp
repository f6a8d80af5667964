#pragma once

#include <cstddef>

#include "rivid/regressor/pack.hpp"
#include "rivid/regressor/vec3.hpp"

// M(q) and N(q, q̇) of a chain or a tree: Newton-Euler with q̈ = 0 for N, composite bodies for M, both in the
// frames of the links with z along the axes, and both in one pass from base to tip and one back.
//
// Three things make it short:
// - What turns with a joint without showing it belongs to the link before: of a revolute joint's link YY
//   (taken off XX), MZ and M, of a prismatic one's the inertia tensor. DynamicsTables moves these, by the
//   rules of Gautier & Khalil (1990), and a chain of revolute joints is left without any mass: forces are U
//   MS alone.
// - The wrenches that the passes carry towards the base, that of N and one for each column of M, go through
//   the same turns: they are columns of one table, and where a Scalar is one number two of them go through a
//   register.
// - Every frame may be turned about its own z for good: DynamicsTables leaves one angle about x between
//   neighbours and one about z, which joins the joint's. Quarter turns and offsets of zero are put to use as
//   in the vector kernels of the regressor: every link gets the step compiled for its case.
//
// The file is compiled for several instruction sets; rivid/regressor/kernel.hpp says what that forbids.
namespace rivid::detail {

// Number: double, or the Scalar itself where every lane has inertias of its own.
template <typename Number>
struct BasicDynamicsLink : Frame {
  Number inertial[10];  // XX XY XZ YY YZ ZZ MX MY MZ M of what is left to the link
  int step;             // see dynamics_step()
  // Where links branch, places for what one of them leaves to the others; −1: none.
  int fork;  // of this link, on which several hang
  int from;  // of the link that carries this one, if that is not the link before; on_base if it is the base
};

inline constexpr int on_base = -2;  // mark, beside −1 for none
using DynamicsLink = BasicDynamicsLink<double>;

template <typename Number>
struct BasicDynamicsPlan {
  const BasicDynamicsLink<Number>* links;
  std::size_t joints;
  double accel[3];      // of the base, less that of free fall, turned like the first link's constant rotation
  const Number* rotor;  // in the layout of M below
  double base[3];       // the same acceleration in the axes of the base, for further links on it
  std::size_t forks;
};
using DynamicsPlan = BasicDynamicsPlan<double>;

// Tag of packs whose lanes are states of different robots, which differ in their inertias alone.
template <typename Tag>
struct OwnInertias;

template <typename Scalar>
struct InertiaOf {
  using Number = double;
};
template <int Lanes, typename Tag>
struct InertiaOf<BasicPack<Lanes, OwnInertias<Tag>>> {
  using Number = BasicPack<Lanes, OwnInertias<Tag>>;
};
template <typename Scalar>
using DynamicsLinkOf = BasicDynamicsLink<typename InertiaOf<Scalar>::Number>;
template <typename Scalar>
using DynamicsPlanOf = BasicDynamicsPlan<typename InertiaOf<Scalar>::Number>;

// Steps: five turns times eight offsets of revolute joints whose composite body has no mass, then any
// revolute joint, then any prismatic one.
[[gnu::always_inline]] constexpr int dynamics_step(Turn turn, unsigned offsets) {
  return static_cast<int>(turn) * 8 + static_cast<int>(offsets);
}
inline constexpr int revolute_step = 40;   // 5 turns × 8 offsets come before it
inline constexpr int prismatic_step = 41;  // of any prismatic joint

// Table of wrenches, one column each, stored by component: fx fy fz nx ny nz. Column r is that of joint n − 1
// − r: what its unit acceleration asks of the frame at hand. M is stored from the tip on as well: row r
// belongs to joint n − 1 − r and holds the columns 0 … r. Both have rows of this length, so that registers of
// two may read and write over their ends. No multiple of four packs either: columns of a power of two fall
// into few sets of the cache.
[[gnu::always_inline]] constexpr std::size_t dynamics_stride(std::size_t joints) {
  const std::size_t even = (joints + 3) / 2 * 2;
  return even % 4 == 0 ? even + 2 : even;
}

// Distance from 1 to the next number.
template <typename Scalar>
inline constexpr double rounding_unit = 0x1p-52;  // of all but float
template <>
inline constexpr double rounding_unit<float> = 0x1p-23;  // of float

template <typename Scalar>
struct Wrench {
  Vec3<Scalar> f, n;
};

// Inertia of all bodies behind a joint, about the origin of the frame at hand.
template <typename Scalar>
struct Composite {
  Scalar XX, XY, XZ, YY, YZ, ZZ;
  Vec3<Scalar> h;
  Scalar m;
};

// What is kept of a link on which several hang: its motion for those to come, and towards the base the sum of
// what has come.
template <typename Scalar>
struct DynamicsFork {
  FrameMotion<Scalar> motion;
  Mat3<Scalar> U;
  Wrench<Scalar> bias;
  Composite<Scalar> composite;
};
// Scalars that a fork takes, its table of wrenches among them.
[[gnu::always_inline]] constexpr std::size_t fork_scalars(std::size_t stride) { return 34 + 6 * stride; }

// Scratch of one evaluation.
template <typename Scalar>
struct DynamicsScratch {
  Scalar* cosines;      // (joints + 1)
  Scalar* sines;        // (joints + 1)
  Wrench<Scalar>* own;  // (joints), of each link's motion
  Scalar* wrenches;     // (6 × stride)
  std::size_t stride;
  DynamicsFork<Scalar>* forks;
  Scalar* fork_wrenches;  // (6 × stride) each
};

// What runs through a register while wrenches are carried: columns of the table, as many as fit.
template <typename Scalar>
struct WrenchColumns {
  using Values = Scalar;
  static constexpr std::size_t lanes = 1;  // of anything but doubles
  [[gnu::always_inline]] static Values load(const Scalar* from) { return *from; }
  [[gnu::always_inline]] static void store(const Values& x, Scalar* to) { *to = x; }
};
template <>
struct WrenchColumns<double> {
  using Values = BasicPack<2>;
  static constexpr std::size_t lanes = 2;  // of BasicPack<2>
  [[gnu::always_inline]] static Values load(const double* from) { return Values::load(from); }
  [[gnu::always_inline]] static void store(const Values& x, double* to) { x.store(to); }
  [[gnu::always_inline]] static Values pair(double a, double b) {
    const double both[2] = {a, b};
    return Values::load(both);
  }
};

// From the axes of frame j to those of frame j−1 at q_j = 0, θ = 0: the inverse of turned().
template <Turn turn, typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> turned_back(const double* R, const Vec3<Scalar>& v) {
  if constexpr (turn == Turn::none) {
    return v;
  } else if constexpr (turn == Turn::plus) {
    return {v.x, -v.z, v.y};
  } else if constexpr (turn == Turn::minus) {
    return {v.x, v.z, -v.y};
  } else if constexpr (turn == Turn::about_x) {
    return {v.x, Scalar(R[4]) * v.y + Scalar(R[5]) * v.z, Scalar(R[7]) * v.y + Scalar(R[8]) * v.z};
  } else {
    return {Scalar(R[0]) * v.x + Scalar(R[1]) * v.y + Scalar(R[2]) * v.z,
            Scalar(R[3]) * v.x + Scalar(R[4]) * v.y + Scalar(R[5]) * v.z,
            Scalar(R[6]) * v.x + Scalar(R[7]) * v.y + Scalar(R[8]) * v.z};
  }
}

template <typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> rotated_back(const Vec3<Scalar>& a, const Scalar& c,
                                                        const Scalar& s) {
  return {c * a.x - s * a.y, s * a.x + c * a.y, a.z};
}

// The symmetric tensor (aa ab; ab bb) turned by an angle, with ca, cb its row towards a third axis:
// c² + s² = 1 leaves four products to the first three.
template <typename Scalar>
[[gnu::always_inline]] inline void turn_tensor(Scalar& aa, Scalar& ab, Scalar& bb, Scalar& ca, Scalar& cb,
                                               const Scalar& c, const Scalar& s) {
  const Scalar g = s * (aa - bb) + c * (ab + ab);
  const Scalar sg = s * g;
  aa = aa - sg;
  bb = bb + sg;
  ab = c * g - ab;
  const Scalar first = ca;
  ca = c * first - s * cb;
  cb = s * first + c * cb;
}

template <Turn turn, typename Scalar>
[[gnu::always_inline]] inline void turn_back(Composite<Scalar>& b, const double* R) {
  b.h = turned_back<turn>(R, b.h);
  if constexpr (turn == Turn::plus) {
    const Composite<Scalar> a = b;
    b.XY = -a.XZ;
    b.XZ = a.XY;
    b.YY = a.ZZ;
    b.YZ = -a.YZ;
    b.ZZ = a.YY;
  } else if constexpr (turn == Turn::minus) {
    const Composite<Scalar> a = b;
    b.XY = a.XZ;
    b.XZ = -a.XY;
    b.YY = a.ZZ;
    b.YZ = -a.YZ;
    b.ZZ = a.YY;
  } else if constexpr (turn == Turn::about_x) {
    turn_tensor(b.YY, b.YZ, b.ZZ, b.XY, b.XZ, Scalar(R[4]), Scalar(R[7]));
  } else if constexpr (turn == Turn::any) {
    const Mat3<Scalar> I = {{b.XX, b.XY, b.XZ}, {b.XY, b.YY, b.YZ}, {b.XZ, b.YZ, b.ZZ}};
    const Vec3<Scalar> x = constant<Scalar>(R);
    const Vec3<Scalar> y = constant<Scalar>(R + 3);
    const Vec3<Scalar> z = constant<Scalar>(R + 6);
    const Vec3<Scalar> Ix = I.times(x);
    const Vec3<Scalar> Iy = I.times(y);
    const Vec3<Scalar> Iz = I.times(z);
    b.XX = dot(x, Ix);
    b.XY = dot(y, Ix);
    b.XZ = dot(z, Ix);
    b.YY = dot(y, Iy);
    b.YZ = dot(z, Iy);
    b.ZZ = dot(z, Iz);
  }
}

// Moves the tensor's point of reference by p; h is the first moment before, or that half-way for a body with
// mass.
template <unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline void shift(Composite<Scalar>& b, const Vec3<Scalar>& h, const Vec3<Scalar>& p) {
  if constexpr ((offsets & 1U) != 0U) {
    const Scalar twice = (p.x + p.x) * h.x;
    b.YY = b.YY + twice;
    b.ZZ = b.ZZ + twice;
    b.XY = b.XY - p.x * h.y;
    b.XZ = b.XZ - p.x * h.z;
  }
  if constexpr ((offsets & 2U) != 0U) {
    const Scalar twice = (p.y + p.y) * h.y;
    b.XX = b.XX + twice;
    b.ZZ = b.ZZ + twice;
    b.XY = b.XY - p.y * h.x;
    b.YZ = b.YZ - p.y * h.z;
  }
  if constexpr ((offsets & 4U) != 0U) {
    const Scalar twice = (p.z + p.z) * h.z;
    b.XX = b.XX + twice;
    b.YY = b.YY + twice;
    b.XZ = b.XZ - p.z * h.x;
    b.YZ = b.YZ - p.z * h.y;
  }
}

// n + p × f.
template <unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> levered(const Vec3<Scalar>& n, const Vec3<Scalar>& p,
                                                   const Vec3<Scalar>& f) {
  Vec3<Scalar> out = n;
  if constexpr ((offsets & 1U) != 0U) {
    out.y = out.y - p.x * f.z;
    out.z = out.z + p.x * f.y;
  }
  if constexpr ((offsets & 2U) != 0U) {
    out.x = out.x + p.y * f.z;
    out.z = out.z - p.y * f.x;
  }
  if constexpr ((offsets & 4U) != 0U) {
    out.x = out.x - p.z * f.y;
    out.y = out.y + p.z * f.x;
  }
  return out;
}

// What is handed from step to step.
template <typename Scalar>
struct DynamicsState {
  FrameMotion<Scalar> motion;  // towards the tip
  Mat3<Scalar> U;
  Wrench<Scalar> bias;          // towards the base, in frame j without link j's own: N
  Composite<Scalar> composite;  // towards the base, in frame j without link j's own
};

// Motion of link j ≥ 1 while q̈ = 0, and the wrench that it takes.
template <Turn turn, unsigned offsets, typename Scalar>
void revolute_forward(const DynamicsLinkOf<Scalar>& link, DynamicsState<Scalar>& state, const Scalar& c,
                      const Scalar& s, const Scalar& qd, Wrench<Scalar>& own) {
  FrameMotion<Scalar> m = carried<turn, offsets>(link, state.motion, state.U, CosSin<Scalar>{c, s});
  spin(m, qd);
  const Mat3<Scalar> U = acceleration_field(m);
  state.motion = m;
  state.U = U;
  const auto hx = Scalar(link.inertial[6]);
  const auto hy = Scalar(link.inertial[7]);
  own.f = {U.r0.x * hx + U.r0.y * hy, U.r1.x * hx + U.r1.y * hy, U.r2.x * hx + U.r2.y * hy};
  // YY and MZ are the link's before.
  const auto moments = TensorMoments<Scalar>::of(m, U);
  const auto sum = [&](auto component) -> Scalar {
    return Scalar(link.inertial[0]) * component(moments.k[0]) +
           Scalar(link.inertial[1]) * component(moments.k[1]) +
           Scalar(link.inertial[2]) * component(moments.k[2]) +
           Scalar(link.inertial[4]) * component(moments.k[4]) +
           Scalar(link.inertial[5]) * component(moments.k[5]);
  };
  own.n.x = sum([](const Vec3<Scalar>& k) { return k.x; }) + hy * m.accel.z;
  own.n.y = sum([](const Vec3<Scalar>& k) { return k.y; }) - hx * m.accel.z;
  own.n.z = sum([](const Vec3<Scalar>& k) { return k.z; }) + hx * m.accel.y - hy * m.accel.x;
}

template <typename Scalar>
void prismatic_forward(const DynamicsLinkOf<Scalar>& link, DynamicsState<Scalar>& state, const Scalar& q,
                       const Scalar& qd, Wrench<Scalar>& own) {
  const CosSin<Scalar> theta = {Scalar(link.cos_theta), Scalar(link.sin_theta)};
  FrameMotion<Scalar> m = carried<Turn::any, 7>(link, state.motion, state.U, theta);
  const Mat3<Scalar> U = acceleration_field(m);
  slide(m, U, q, qd);
  state.motion = m;
  state.U = U;
  const Vec3<Scalar> h = {Scalar(link.inertial[6]), Scalar(link.inertial[7]), Scalar(link.inertial[8])};
  const auto mass = Scalar(link.inertial[9]);
  own.f = Vec3<Scalar>{mass * m.accel.x, mass * m.accel.y, mass * m.accel.z} + U.times(h);
  own.n = cross(h, m.accel);
}

// The first link: the base does not move, and a joint feels one component alone.
template <typename Scalar>
[[gnu::always_inline]] inline void first_forward(const DynamicsPlanOf<Scalar>& plan,
                                                 DynamicsState<Scalar>& state, const Scalar& c,
                                                 const Scalar& s, const Scalar& qd, Wrench<Scalar>& own) {
  const DynamicsLinkOf<Scalar>& link = plan.links[0];
  const auto zero = Scalar(0.0);
  const Vec3<Scalar> none = {zero, zero, zero};
  state.motion = {none, none, constant<Scalar>(plan.accel)};
  state.U = {none, none, none};
  own = {none, none};
  Vec3<Scalar>& accel = state.motion.accel;
  if (link.revolute) {
    accel = rotated(accel, c, s);
    state.motion.omega.z = qd;
    state.U.r0.x = -(qd * qd);
    state.U.r1.y = state.U.r0.x;
    own.n.z = Scalar(link.inertial[6]) * accel.y - Scalar(link.inertial[7]) * accel.x;
  } else {
    accel = rotated(accel, Scalar(link.cos_theta), Scalar(link.sin_theta));
    own.f.z = Scalar(link.inertial[9]) * accel.z;
  }
}

// Takes link j into its composite body.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline void take(const DynamicsLinkOf<Scalar>& link, Composite<Scalar>& b) {
  const auto add = [&](Scalar& sum, int k) { sum = sum + Scalar(link.inertial[k]); };
  add(b.h.x, 6);
  add(b.h.y, 7);
  if constexpr (revolute) {
    add(b.XX, 0);
    add(b.XY, 1);
    add(b.XZ, 2);
    add(b.YZ, 4);
    add(b.ZZ, 5);
  } else {
    add(b.h.z, 8);
    add(b.m, 9);
  }
}

// What a unit acceleration of joint j asks of its composite body.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline Wrench<Scalar> own_column(const Composite<Scalar>& b) {
  const auto zero = Scalar(0.0);
  if constexpr (revolute) {
    return {{-b.h.y, b.h.x, zero}, {b.XZ, b.YZ, b.ZZ}};
  } else {
    return {{zero, zero, b.m}, {b.h.y, -b.h.x, zero}};
  }
}

// The component of a wrench that a joint feels.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline const Scalar& felt(const Wrench<Scalar>& w) {
  if constexpr (revolute) {
    return w.n.z;
  } else {
    return w.f.z;
  }
}

// What stands by for a row of M and an entry of N.
template <typename Scalar>
struct DynamicsRow {
  std::size_t r;
  const typename InertiaOf<Scalar>::Number* rotor;
  Scalar* M;
  Scalar* N;
};

// Row r of M where the columns before it have been carried to frame j, and the entry of N.
template <bool revolute, typename Scalar>
[[gnu::always_inline]] inline void put_row(const DynamicsRow<Scalar>& row,
                                           const DynamicsScratch<Scalar>& scratch, const Wrench<Scalar>& bias,
                                           const Wrench<Scalar>& column) {
  using Columns = WrenchColumns<Scalar>;
  const Scalar* const feels = scratch.wrenches + (revolute ? 5 : 2) * scratch.stride;
  for (std::size_t k = 0; k < row.r; k += Columns::lanes) {
    if constexpr (Columns::lanes > 1) {
      Columns::store(Columns::load(feels + k) + Columns::load(row.rotor + k), row.M + k);
    } else {
      row.M[k] = feels[k] + Scalar(row.rotor[k]);
    }
  }
  row.M[row.r] = felt<revolute>(column) + Scalar(row.rotor[row.r]);
  *row.N = felt<revolute>(bias);
}

// A wrench from frame j to frame j−1.
template <Turn turn, unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline Wrench<Scalar> carried(const Frame& link, const Wrench<Scalar>& w,
                                                     const Scalar& c, const Scalar& s,
                                                     const Vec3<Scalar>& p) {
  const Vec3<Scalar> f = turned_back<turn>(link.R, rotated_back(w.f, c, s));
  const Vec3<Scalar> n = turned_back<turn>(link.R, rotated_back(w.n, c, s));
  return {f, levered<offsets>(n, p, f)};
}

// The columns 0 … r − 1 of the table, the wrench of N and the new column r from frame j to frame j−1.
template <Turn turn, unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline void carry_wrenches(const DynamicsLinkOf<Scalar>& link,
                                                  const DynamicsScratch<Scalar>& scratch, std::size_t r,
                                                  const Scalar& c, const Scalar& s, const Vec3<Scalar>& p,
                                                  Wrench<Scalar>& bias, const Wrench<Scalar>& column) {
  using Columns = WrenchColumns<Scalar>;
  using Values = typename Columns::Values;
  const std::size_t stride = scratch.stride;
  // Values may be Scalar itself, or packs of it.
  const Values cosine(c);  // NOLINT(performance-unnecessary-copy-initialization)
  const Values sine(s);    // NOLINT(performance-unnecessary-copy-initialization)
  const Vec3<Values> lever = {Values(p.x), Values(p.y), Values(p.z)};
  for (std::size_t k = 0; k < r; k += Columns::lanes) {
    Scalar* const w = scratch.wrenches + k;
    const auto at = [&](std::size_t component) { return Columns::load(w + component * stride); };
    const Wrench<Values> out = carried<turn, offsets>(
        link, Wrench<Values>{{at(0), at(1), at(2)}, {at(3), at(4), at(5)}}, cosine, sine, lever);
    Columns::store(out.f.x, w);
    Columns::store(out.f.y, w + stride);
    Columns::store(out.f.z, w + 2 * stride);
    Columns::store(out.n.x, w + 3 * stride);
    Columns::store(out.n.y, w + 4 * stride);
    Columns::store(out.n.z, w + 5 * stride);
  }
  Scalar* const w = scratch.wrenches + r;
  const auto put = [&](const auto& of, auto part) {
    w[0] = part(of.f.x);
    w[stride] = part(of.f.y);
    w[2 * stride] = part(of.f.z);
    w[3 * stride] = part(of.n.x);
    w[4 * stride] = part(of.n.y);
    w[5 * stride] = part(of.n.z);
  };
  if constexpr (Columns::lanes > 1) {
    const auto both = [](const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
      return Vec3<Values>{Columns::pair(a.x, b.x), Columns::pair(a.y, b.y), Columns::pair(a.z, b.z)};
    };
    const Wrench<Values> out = carried<turn, offsets>(
        link, Wrench<Values>{both(bias.f, column.f), both(bias.n, column.n)}, cosine, sine, lever);
    bias = {{out.f.x[0], out.f.y[0], out.f.z[0]}, {out.n.x[0], out.n.y[0], out.n.z[0]}};
    put(out, [](const Values& x) { return x[1]; });
  } else {
    bias = carried<turn, offsets>(link, bias, c, s, p);
    put(carried<turn, offsets>(link, column, c, s, p), [](const Scalar& x) { return x; });
  }
}

// The composite body from frame j to frame j−1.
template <Turn turn, unsigned offsets, bool with_mass, typename Scalar>
[[gnu::always_inline]] inline void carry_composite(const DynamicsLinkOf<Scalar>& link, Composite<Scalar>& b,
                                                   const Scalar& c, const Scalar& s, const Vec3<Scalar>& p) {
  turn_tensor(b.XX, b.XY, b.YY, b.XZ, b.YZ, c, s);
  b.h = rotated_back(b.h, c, s);
  turn_back<turn>(b, link.R);
  if constexpr (with_mass) {
    // First moments half-way, h + m p / 2, so that the cross terms cancel.
    const Vec3<Scalar> way = scaled(Scalar(Scalar(0.5) * b.m), p);
    b.h = b.h + way;
    shift<offsets>(b, b.h, p);
    b.h = b.h + way;
  } else {
    shift<offsets>(b, b.h, p);
  }
}

template <typename Scalar>
[[gnu::always_inline]] inline Wrench<Scalar> operator+(const Wrench<Scalar>& a, const Wrench<Scalar>& b) {
  return {a.f + b.f, a.n + b.n};
}

template <typename Scalar>
[[gnu::always_inline]] inline void add(Composite<Scalar>& sum, const Composite<Scalar>& b) {
  sum = {sum.XX + b.XX, sum.XY + b.XY, sum.XZ + b.XZ, sum.YY + b.YY,
         sum.YZ + b.YZ, sum.ZZ + b.ZZ, sum.h + b.h,   sum.m + b.m};
}

// Link j ≥ 1 towards the base: its row of M and N, then everything into frame j−1.
template <Turn turn, unsigned offsets, bool with_mass, typename Scalar>
void revolute_backward(const DynamicsLinkOf<Scalar>& link, DynamicsState<Scalar>& state,
                       const DynamicsScratch<Scalar>& scratch, const Scalar& c, const Scalar& s,
                       const Wrench<Scalar>& own, const DynamicsRow<Scalar>& row) {
  Composite<Scalar> b = state.composite;
  take<true>(link, b);
  const Wrench<Scalar> column = own_column<true>(b);
  Wrench<Scalar> bias = state.bias + own;
  put_row<true>(row, scratch, bias, column);
  const Vec3<Scalar> p = constant<Scalar>(link.p);
  carry_wrenches<turn, offsets>(link, scratch, row.r, c, s, p, bias, column);
  state.bias = bias;
  carry_composite<turn, offsets, with_mass>(link, b, c, s, p);
  state.composite = b;
}

template <typename Scalar>
void prismatic_backward(const DynamicsLinkOf<Scalar>& link, DynamicsState<Scalar>& state,
                        const DynamicsScratch<Scalar>& scratch, const Scalar& q, const Wrench<Scalar>& own,
                        const DynamicsRow<Scalar>& row) {
  const auto c = Scalar(link.cos_theta);
  const auto s = Scalar(link.sin_theta);
  Composite<Scalar> b = state.composite;
  take<false>(link, b);
  const Wrench<Scalar> column = own_column<false>(b);
  Wrench<Scalar> bias = state.bias + own;
  put_row<false>(row, scratch, bias, column);
  const auto zero = Scalar(0.0);
  const Vec3<Scalar> p =
      constant<Scalar>(link.p) + turned_back<Turn::any>(link.R, Vec3<Scalar>{zero, zero, q});
  carry_wrenches<Turn::any, 7>(link, scratch, row.r, c, s, p, bias, column);
  state.bias = bias;
  carry_composite<Turn::any, 7, true>(link, b, c, s, p);
  state.composite = b;
}

// As has_quick_steps for the regressor, and the single samples of simulations.
template <typename Scalar>
inline constexpr bool has_quick_dynamics = has_quick_steps<Scalar>;
template <>
inline constexpr bool has_quick_dynamics<double> = true;

template <typename Scalar>
struct RevoluteStep {
  void (*forward)(const DynamicsLinkOf<Scalar>&, DynamicsState<Scalar>&, const Scalar&, const Scalar&,
                  const Scalar&, Wrench<Scalar>&) = nullptr;
  void (*backward)(const DynamicsLinkOf<Scalar>&, DynamicsState<Scalar>&, const DynamicsScratch<Scalar>&,
                   const Scalar&, const Scalar&, const Wrench<Scalar>&, const DynamicsRow<Scalar>&) = nullptr;
};

template <typename Scalar>
struct RevoluteSteps {
  RevoluteStep<Scalar> table[revolute_step + 1] = {};

  constexpr RevoluteSteps() {
    table[revolute_step] = {&revolute_forward<Turn::any, 7, Scalar>,
                            &revolute_backward<Turn::any, 7, true, Scalar>};
    if constexpr (has_quick_dynamics<Scalar>) {
      for_each_step([this]<Turn turn, unsigned offsets>(unsigned of) {
        table[dynamics_step(turn, of)] = {&revolute_forward<turn, offsets, Scalar>,
                                          &revolute_backward<turn, offsets, false, Scalar>};
      });
    } else {
      for (int k = 0; k < revolute_step; ++k) {
        table[k] = table[revolute_step];
      }
    }
  }
};

// Sines and cosines of all joint angles, before anything else: one is a long chain of operations, many beside
// each other fill the pipelines.
template <typename Scalar>
[[gnu::always_inline]] inline void joint_sines(const DynamicsPlanOf<Scalar>& plan, const Scalar* q,
                                               Scalar* cosines, Scalar* sines) {
  if constexpr (requires { too_far(*q); }) {
    // One question for all joints: asked of every angle, it would cost as much as a sine.
    auto far_out = too_far(Scalar(0.0));
    for (std::size_t j = 0; j < plan.joints; ++j) {
      if (plan.links[j].revolute) {
        sin_cos_near(q[j], sines[j], cosines[j]);
        far_out = far_out | too_far(q[j]);
      }
    }
    if (any(far_out)) [[unlikely]] {
      for (std::size_t j = 0; j < plan.joints; ++j) {
        sin_cos_far(q[j], sines[j], cosines[j]);
      }
    }
  } else {
    for (std::size_t j = 0; j < plan.joints; ++j) {
      if (plan.links[j].revolute) {
        sin_cos(q[j], sines[j], cosines[j]);
      }
    }
  }
}
template <>
[[gnu::always_inline]] inline void joint_sines(const DynamicsPlan& plan, const double* q, double* cosines,
                                               double* sines) {
  using Two = BasicPack<2>;
  for (std::size_t j = 0; j < plan.joints; j += 2) {
    const double pair[2] = {q[j], q[j + 1 < plan.joints ? j + 1 : j]};
    Two s;
    Two c;
    sin_cos(Two::load(pair), s, c);
    s.store(sines + j);
    c.store(cosines + j);
  }
}

template <typename Scalar>
[[gnu::always_inline]] inline DynamicsState<Scalar> nothing_behind() {
  const auto zero = Scalar(0.0);
  const Vec3<Scalar> none = {zero, zero, zero};
  return {
      {none, none, none}, {none, none, none}, {none, none}, {zero, zero, zero, zero, zero, zero, none, zero}};
}

// Towards the tips: the motion that link j begins with, where that is not the one before's.
template <typename Scalar>
void begin_branch(const DynamicsPlanOf<Scalar>& plan, const DynamicsScratch<Scalar>& scratch, int from,
                  DynamicsState<Scalar>& state) {
  if (from == on_base) {
    state = nothing_behind<Scalar>();
    state.motion.accel = constant<Scalar>(plan.base);
  } else {
    state.motion = scratch.forks[from].motion;
    state.U = scratch.forks[from].U;
  }
}

// Towards the base, once all that hangs on the next link in the order of the tree has been carried to the one
// that carries it: that is added up there, and the link before begins with nothing. Columns of M that belong
// to other branches are zeros on the way.
//
// columns: of the table that there are
template <typename Scalar>
void end_branch(const DynamicsScratch<Scalar>& scratch, int from, std::size_t columns,
                DynamicsState<Scalar>& state) {
  const auto zero = Scalar(0.0);
  if (from != on_base) {
    DynamicsFork<Scalar>& fork = scratch.forks[from];
    fork.bias = fork.bias + state.bias;
    add(fork.composite, state.composite);
  }
  for (std::size_t component = 0; component < 6; ++component) {
    Scalar* const w = scratch.wrenches + component * scratch.stride;
    for (std::size_t k = 0; k < columns; ++k) {
      if (from != on_base) {
        Scalar& sum =
            scratch.fork_wrenches[(static_cast<std::size_t>(from) * 6 + component) * scratch.stride + k];
        sum = sum + w[k];
      }
      w[k] = zero;
    }
  }
  state = nothing_behind<Scalar>();
}

// The rest of what hangs on a link, added to the state that has come to it.
template <typename Scalar>
void join_branches(const DynamicsScratch<Scalar>& scratch, int fork, std::size_t columns,
                   DynamicsState<Scalar>& state) {
  state.bias = state.bias + scratch.forks[fork].bias;
  add(state.composite, scratch.forks[fork].composite);
  for (std::size_t component = 0; component < 6; ++component) {
    Scalar* const w = scratch.wrenches + component * scratch.stride;
    const Scalar* const kept =
        scratch.fork_wrenches + (static_cast<std::size_t>(fork) * 6 + component) * scratch.stride;
    for (std::size_t k = 0; k < columns; ++k) {
      w[k] = w[k] + kept[k];
    }
  }
}

template <typename Scalar>
void clear_forks(const DynamicsPlanOf<Scalar>& plan, const DynamicsScratch<Scalar>& scratch) {
  const DynamicsState<Scalar> none = nothing_behind<Scalar>();
  for (std::size_t f = 0; f < plan.forks; ++f) {
    scratch.forks[f].bias = none.bias;
    scratch.forks[f].composite = none.composite;
    for (std::size_t k = 0; k < 6 * scratch.stride; ++k) {
      scratch.fork_wrenches[f * 6 * scratch.stride + k] = Scalar(0.0);
    }
  }
}

// M and N of one state.
//
// M: (joints × stride), N: (joints).
template <typename Scalar>
[[gnu::always_inline]] inline void mass_and_bias(const DynamicsPlanOf<Scalar>& plan, const Scalar* q,
                                                 const Scalar* qd, const DynamicsScratch<Scalar>& scratch,
                                                 Scalar* M, Scalar* N) {
  static constexpr RevoluteSteps<Scalar> steps;
  const std::size_t n = plan.joints;
  Scalar* const cosines = scratch.cosines;
  Scalar* const sines = scratch.sines;
  joint_sines(plan, q, cosines, sines);
  for (std::size_t j = 0; j < n; ++j) {
    const DynamicsLinkOf<Scalar>& link = plan.links[j];
    if (link.revolute) {
      const CosSin<Scalar> angle = with_theta(link, CosSin<Scalar>{cosines[j], sines[j]});
      cosines[j] = angle.c;
      sines[j] = angle.s;
    }
  }
  DynamicsState<Scalar> state;
  const auto keep = [&](const DynamicsLinkOf<Scalar>& link) {
    if (link.fork >= 0) [[unlikely]] {
      scratch.forks[link.fork].motion = state.motion;
      scratch.forks[link.fork].U = state.U;
    }
  };
  first_forward(plan, state, cosines[0], sines[0], qd[0], scratch.own[0]);
  keep(plan.links[0]);
  for (std::size_t j = 1; j < n; ++j) {
    const DynamicsLinkOf<Scalar>& link = plan.links[j];
    if (link.from != -1) [[unlikely]] {
      begin_branch(plan, scratch, link.from, state);
    }
    if (link.step == prismatic_step) {
      prismatic_forward(link, state, q[j], qd[j], scratch.own[j]);
    } else {
      steps.table[link.step].forward(link, state, cosines[j], sines[j], qd[j], scratch.own[j]);
    }
    keep(link);
  }
  state = nothing_behind<Scalar>();
  if (plan.forks > 0) [[unlikely]] {
    clear_forks(plan, scratch);
  }
  const auto join = [&](std::size_t r) {
    const int fork = plan.links[n - 1 - r].fork;
    if (fork >= 0) [[unlikely]] {
      join_branches(scratch, fork, r, state);
    }
  };
  const auto row = [&](std::size_t r) {
    return DynamicsRow<Scalar>{r, plan.rotor + r * scratch.stride, M + r * scratch.stride, N + (n - 1 - r)};
  };
  for (std::size_t r = 0; r + 1 < n; ++r) {
    const std::size_t j = n - 1 - r;
    const DynamicsLinkOf<Scalar>& link = plan.links[j];
    join(r);
    if (link.step == prismatic_step) {
      prismatic_backward(link, state, scratch, q[j], scratch.own[j], row(r));
    } else {
      steps.table[link.step].backward(link, state, scratch, cosines[j], sines[j], scratch.own[j], row(r));
    }
    if (link.from != -1) [[unlikely]] {
      end_branch(scratch, link.from, r + 1, state);
    }
  }
  join(n - 1);
  const auto put_first = [&]<bool revolute>() {
    take<revolute>(plan.links[0], state.composite);
    put_row<revolute>(row(n - 1), scratch, state.bias + scratch.own[0],
                      own_column<revolute>(state.composite));
  };
  if (plan.links[0].revolute) {
    put_first.template operator()<true>();
  } else {
    put_first.template operator()<false>();
  }
}

// For one sample what BasicPack::Mask has for several.
[[gnu::always_inline]] inline bool all(bool condition) { return condition; }

// M = L D Lᵀ in the order of its storage, from the tip on: a pivot is the inertia that a joint feels while
// all joints behind it are free. L: rows like those of M. Returns whether all pivots are positive, and by
// more than rounding leaves of the entries of M that they began as.
template <std::size_t n, typename Scalar>
[[gnu::always_inline]] inline bool factor_small(std::size_t stride, const Scalar* M, Scalar* L,
                                                Scalar* inverse_D) {
  const auto rounding = Scalar(static_cast<double>(n) * rounding_unit<Scalar>);
  // In registers, once the loops are unrolled.
  Scalar A[n][n];
#pragma GCC unroll 8
  for (std::size_t i = 0; i < n; ++i) {
#pragma GCC unroll 8
    for (std::size_t k = 0; k <= i; ++k) {
      A[i][k] = M[i * stride + k];
    }
  }
  auto positive = Scalar(1.0) > Scalar(0.0);
#pragma GCC unroll 8
  for (std::size_t k = 0; k < n; ++k) {
    positive = positive & (A[k][k] > rounding * M[k * stride + k]) & (A[k][k] > Scalar(0.0));
    const Scalar inverse = Scalar(1.0) / A[k][k];
    inverse_D[k] = inverse;
#pragma GCC unroll 8
    for (std::size_t i = k + 1; i < n; ++i) {
      const Scalar l = A[i][k] * inverse;
      // The rows below i still hold of column k what it was before the division.
#pragma GCC unroll 8
      for (std::size_t m = i; m < n; ++m) {
        A[m][i] = A[m][i] - l * A[m][k];
      }
      L[i * stride + k] = l;
    }
  }
  return all(positive);
}

// Four columns at a time, then what they take off all others, in one sweep.
//
// columns: scratch of 4 × stride.
template <typename Scalar>
[[gnu::always_inline]] inline bool factor_any(std::size_t n, std::size_t stride, const Scalar* M, Scalar* L,
                                              Scalar* inverse_D, Scalar* columns) {
  using Columns = WrenchColumns<Scalar>;
  using Values = typename Columns::Values;
  constexpr std::size_t width = 4;  // columns at a time, as the scratch has room for
  const auto rounding = Scalar(static_cast<double>(n) * rounding_unit<Scalar>);
  auto positive = Scalar(1.0) > Scalar(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      L[i * stride + k] = M[i * stride + k];
    }
  }
  for (std::size_t first = 0; first < n; first += width) {
    const std::size_t end = first + width < n ? first + width : n;
    for (std::size_t k = first; k < end; ++k) {
      // Column k before its division: L(i, k) D(k).
      Scalar* const column = columns + (k - first) * stride;
      const Scalar pivot = L[k * stride + k];
      positive = positive & (pivot > rounding * M[k * stride + k]) & (pivot > Scalar(0.0));
      const Scalar inverse = Scalar(1.0) / pivot;
      inverse_D[k] = inverse;
      for (std::size_t i = k + 1; i < n; ++i) {
        Scalar* const row = L + i * stride;
        column[i] = row[k];
        const Scalar l = row[k] * inverse;
        row[k] = l;
        for (std::size_t m = k + 1; m < end && m <= i; ++m) {
          row[m] = row[m] - l * column[m];
        }
      }
    }
    for (std::size_t i = end; i < n; ++i) {
      Scalar* const row = L + i * stride;
      const Values l0(row[first]);
      const Values l1(row[first + 1]);
      const Values l2(row[first + 2]);
      const Values l3(row[first + 3]);
      for (std::size_t m = end; m <= i; m += Columns::lanes) {
        const Scalar* const a = columns + m;
        const Values less = (l0 * Columns::load(a) + l1 * Columns::load(a + stride)) +
                            (l2 * Columns::load(a + 2 * stride) + l3 * Columns::load(a + 3 * stride));
        Columns::store(Columns::load(row + m) - less, row + m);
      }
    }
  }
  return all(positive);
}

// Calls work<n>() for the numbers of joints that are worth a compiled case of their own; returns whether n is
// one.
template <typename Scalar, typename Work>
[[gnu::always_inline]] inline bool for_small(std::size_t n, const Work& work) {
  if constexpr (has_quick_dynamics<Scalar>) {
    const auto is = [&]<std::size_t size>() {
      if (n == size) {
        work.template operator()<size>();
      }
      return n == size;
    };
    return is.template operator()<2>() || is.template operator()<3>() || is.template operator()<4>() ||
           is.template operator()<5>() || is.template operator()<6>() || is.template operator()<7>();
  }
  return false;
}

template <typename Scalar>
[[gnu::always_inline]] inline bool factor(std::size_t n, std::size_t stride, const Scalar* M, Scalar* L,
                                          Scalar* inverse_D, Scalar* columns) {
  bool positive = false;
  if (for_small<Scalar>(
          n, [&]<std::size_t size>() { positive = factor_small<size>(stride, M, L, inverse_D); })) {
    return positive;
  }
  return factor_any(n, stride, M, L, inverse_D, columns);
}

// After factor() found one: the first row whose pivot is not positive in some lane.
template <typename Scalar>
std::size_t failed_row(std::size_t n, std::size_t stride, const Scalar* M, const Scalar* inverse_D) {
  const auto rounding = Scalar(static_cast<double>(n) * rounding_unit<Scalar>);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    if (!all((inverse_D[k] > Scalar(0.0)) & (Scalar(1.0) > rounding * M[k * stride + k] * inverse_D[k]))) {
      return k;
    }
  }
  return n - 1;
}

template <std::size_t n, typename Scalar>
[[gnu::always_inline]] inline void solve_small(std::size_t stride, const Scalar* L, const Scalar* inverse_D,
                                               Scalar* b) {
  Scalar x[n];
#pragma GCC unroll 8
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = b[n - 1 - i];
  }
#pragma GCC unroll 8
  for (std::size_t k = 0; k < n; ++k) {
#pragma GCC unroll 8
    for (std::size_t i = k + 1; i < n; ++i) {
      x[i] = x[i] - L[i * stride + k] * x[k];
    }
  }
#pragma GCC unroll 8
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = x[i] * inverse_D[i];
  }
#pragma GCC unroll 8
  for (std::size_t r = 0; r < n; ++r) {
    const std::size_t i = n - 1 - r;
#pragma GCC unroll 8
    for (std::size_t k = 0; k < i; ++k) {
      x[k] = x[k] - L[i * stride + k] * x[i];
    }
  }
#pragma GCC unroll 8
  for (std::size_t i = 0; i < n; ++i) {
    b[n - 1 - i] = x[i];
  }
}

// As soon as an entry is known it is taken off all others: these do not wait for each other, terms of one sum
// would.
template <typename Scalar>
[[gnu::always_inline]] inline void solve_any(std::size_t n, std::size_t stride, const Scalar* L,
                                             const Scalar* inverse_D, Scalar* b) {
  Scalar* const tip = b + (n - 1);
  const auto at = [&](std::size_t r) -> Scalar& { return *(tip - r); };
  // A copy stays in its register while other entries are written.
  for (std::size_t k = 0; k < n; ++k) {
    const Scalar x = at(k);  // NOLINT(performance-unnecessary-copy-initialization)
    for (std::size_t i = k + 1; i < n; ++i) {
      at(i) = at(i) - L[i * stride + k] * x;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    at(i) = at(i) * inverse_D[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    const Scalar x = at(i);  // NOLINT(performance-unnecessary-copy-initialization)
    for (std::size_t k = 0; k < i; ++k) {
      at(k) = at(k) - L[i * stride + k] * x;
    }
  }
}

// b ← M⁻¹ b, with b in the order of the joints.
template <typename Scalar>
[[gnu::always_inline]] inline void solve_factored(std::size_t n, std::size_t stride, const Scalar* L,
                                                  const Scalar* inverse_D, Scalar* b) {
  if (for_small<Scalar>(n, [&]<std::size_t size>() { solve_small<size>(stride, L, inverse_D, b); })) {
    return;
  }
  solve_any(n, stride, L, inverse_D, b);
}

}  // namespace rivid::detail
