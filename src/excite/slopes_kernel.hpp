#pragma once

#include "instruction_sets.hpp"
#include "rivid/regressor/kernel.hpp"
#include "rivid/simulate/dynamics_kernel.hpp"

// Derivatives of sums of a regressor's entries by reverse differentiation of its recursion: what a sum
// changes by is carried from the tip to the base, so that the derivatives by all positions, velocities and
// accelerations cost a few times the entries. Compiled once an instruction set; see
// rivid/regressor/kernel.hpp for what that forbids.
namespace rivid::detail {

// Where the derivatives go: a column a joint.
struct SlopeTarget {
  double* q;
  double* qd;
  double* qdd;
  std::ptrdiff_t stride;
};

// What is differentiated at each of some samples: Σ G W over the entries of the links, and the rows' products
// with values of the parameters.
struct SlopesTask {
  RegressorPlan plan;
  RegressorInput<double> input;
  const double* const* G;        // the column that each entry is multiplied with, in the order of fill_rows()
  SlopeTarget of_sum;            // is set
  const double* chi;             // 10 values a link, as its entries stand; null: no torques
  const SlopeTarget* of_torque;  // (n), are set
};

// What the backward pass reads of a link.
template <typename Scalar>
struct PassedLink {
  FrameMotion<Scalar> motion;
  Mat3<Scalar> U;
  CosSin<Scalar> angle;
  Scalar q, qd;
};

// Derivatives of a sum by the motion of a frame.
template <typename Scalar>
struct MotionSlope {
  Vec3<Scalar> omega, omega_dot, accel;
};

// Coefficients of the ten entries of a link in a row: the body whose wrench the row would see.
template <typename Scalar>
struct Coefficients {
  Scalar xx, xy, xz, yy, yz, zz;
  Vec3<Scalar> moment;
  Scalar mass;

  [[nodiscard, gnu::always_inline]] Vec3<Scalar> tensor_times(const Vec3<Scalar>& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

// The slope of v · (ω × (ω × p)) by ω.
template <typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> centripetal_slope(const Vec3<Scalar>& v, const Vec3<Scalar>& p,
                                                             const Vec3<Scalar>& omega) {
  const Scalar along = dot(v, p);
  return scaled(dot(omega, p), v) + scaled(dot(v, omega), p) - scaled(along + along, omega);
}

// Power of the wrench of `body` on a screw, by the motion of the body's frame.
template <typename Scalar>
[[gnu::always_inline]] inline void add_power_slope(const Coefficients<Scalar>& body, const Screw<Scalar>& s,
                                                   const FrameMotion<Scalar>& m, MotionSlope<Scalar>& to) {
  to.accel = to.accel + scaled(body.mass, s.v) + cross(s.w, body.moment);
  to.omega_dot = to.omega_dot + cross(body.moment, s.v) + body.tensor_times(s.w);
  to.omega = to.omega + centripetal_slope(s.v, body.moment, m.omega) +
             cross(body.tensor_times(m.omega), s.w) + body.tensor_times(cross(s.w, m.omega));
}

// The wrench itself: what the power changes by with the screw.
template <typename Scalar>
[[gnu::always_inline]] inline Screw<Scalar> wrench(const Coefficients<Scalar>& body,
                                                   const PassedLink<Scalar>& link) {
  const FrameMotion<Scalar>& m = link.motion;
  return {cross(body.moment, m.accel) + body.tensor_times(m.omega_dot) +
              cross(m.omega, body.tensor_times(m.omega)),
          scaled(body.mass, m.accel) + link.U.times(body.moment)};
}

// Those of the entries that are wanted, from the columns of G.
template <typename Scalar>
[[gnu::always_inline]] inline Coefficients<Scalar> coefficients_of(const LinkPlan& link,
                                                                   const double* const* G,
                                                                   std::ptrdiff_t row) {
  Scalar c[10];
  for (unsigned k = 0; k < 10; ++k) {
    c[k] =
        (link.mask >> k & 1U) != 0U ? Scalar(link.sign[k]) * Stored<Scalar>::load(*G++ + row) : Scalar(0.0);
  }
  return {c[0], c[1], c[2], c[3], c[4], c[5], {c[6], c[7], c[8]}, c[9]};
}

template <typename Scalar>
[[gnu::always_inline]] inline Coefficients<Scalar> coefficients_of(const LinkPlan& link, const double* chi) {
  Scalar c[10];
  for (unsigned k = 0; k < 10; ++k) {
    c[k] = Scalar(link.sign[k] * chi[k]);
  }
  return {c[0], c[1], c[2], c[3], c[4], c[5], {c[6], c[7], c[8]}, c[9]};
}

// Derivatives at one pack of samples.
template <typename Scalar>
class SlopesPass {
 public:
  using Memory = Stored<Scalar>;

  // Doubles that a pass writes its intermediate values to.
  static constexpr std::size_t scratch(std::size_t joints, std::size_t forks) {
    return (joints * (sizeof(PassedLink<Scalar>) + sizeof(Screw<Scalar>)) +
            joints * joints * sizeof(Screw<Scalar>) +
            forks * (sizeof(MotionSlope<Scalar>) + joints * sizeof(Screw<Scalar>))) /
           sizeof(double);
  }

  SlopesPass(const SlopesTask& task, double* scratch)
      : task_(task),
        n_(task.plan.joints),
        links_(reinterpret_cast<PassedLink<Scalar>*>(scratch)),
        wrenches_(reinterpret_cast<Screw<Scalar>*>(links_ + n_)),
        screws_(wrenches_ + n_),
        fork_slopes_(reinterpret_cast<MotionSlope<Scalar>*>(screws_ + n_ * n_)),
        fork_wrenches_(reinterpret_cast<Screw<Scalar>*>(fork_slopes_ + task.plan.forks)) {}

  static void fill(const SlopesTask& task, std::size_t packs, double* scratch) {
    SlopesPass pass(task, scratch);
    const bool far_angles = any_too_far<Scalar>(task.plan, task.input, packs);
    for (std::size_t k = 0; k < packs; ++k) {
      pass.row_ = static_cast<std::ptrdiff_t>(k) * Memory::lanes;
      pass.forward(far_angles);
      pass.slopes_of_sum();
      for (std::size_t i = 0; task.chi != nullptr && i < task.plan.joints; ++i) {
        pass.slopes_of_torque(i);
      }
    }
  }

 private:
  // Calls f<turn>() for the turn of a link.
  template <typename F>
  [[gnu::always_inline]] static void with_turn(const LinkPlan& link, const F& f) {
    switch (static_cast<Turn>(link.step / step_number(Turn::plus, 0, false, false))) {
      case Turn::none:
        return f.template operator()<Turn::none>();
      case Turn::plus:
        return f.template operator()<Turn::plus>();
      case Turn::minus:
        return f.template operator()<Turn::minus>();
      case Turn::about_x:
        return f.template operator()<Turn::about_x>();
      case Turn::any:
        return f.template operator()<Turn::any>();
    }
  }

  // Screw of a joint on the way to link j, of this depth, in frame j.
  [[gnu::always_inline]] Screw<Scalar>& screw(std::size_t depth, std::size_t j) {
    return screws_[j * n_ + depth];
  }
  [[nodiscard, gnu::always_inline]] std::size_t depth(std::size_t j) const {
    return static_cast<std::size_t>(task_.plan.links[j].depth);
  }

  [[gnu::always_inline]] static Screw<Scalar> own_screw(const LinkPlan& link) {
    const Vec3<Scalar> z = {Scalar(0.0), Scalar(0.0), Scalar(1.0)};
    const Vec3<Scalar> none = {Scalar(0.0), Scalar(0.0), Scalar(0.0)};
    return link.revolute ? Screw<Scalar>{z, none} : Screw<Scalar>{none, z};
  }

  void forward(bool far_angles) {
    for (std::size_t j = 0; j < n_; ++j) {
      const LinkPlan& link = task_.plan.links[j];
      PassedLink<Scalar>& to = links_[j];
      const auto column = static_cast<std::ptrdiff_t>(j);
      to.q = Memory::load(task_.input.q + column * task_.input.q_stride + row_);
      to.qd = Memory::load(task_.input.qd + column * task_.input.qd_stride + row_);
      to.angle = link.revolute ? joint_angle(link, to.q, far_angles)
                               : CosSin<Scalar>{Scalar(link.cos_theta), Scalar(link.sin_theta)};
    }
    for (std::size_t j = 0; j < n_; ++j) {
      with_turn(task_.plan.links[j], [&]<Turn turn>() { forward_link<turn>(j); });
    }
  }

  template <Turn turn>
  void forward_link(std::size_t j) {
    const LinkPlan& link = task_.plan.links[j];
    PassedLink<Scalar>& to = links_[j];
    const CosSin<Scalar> angle = to.angle;
    const Scalar zero(0.0);
    FrameMotion<Scalar> m = {
        {zero, zero, zero}, {zero, zero, zero}, rotated(constant<Scalar>(link.accel), angle.c, angle.s)};
    if (link.parent >= 0) {
      m = carried<turn, 7>(link, links_[link.parent].motion, links_[link.parent].U, angle);
    }
    const Scalar qdd =
        Memory::load(task_.input.qdd + static_cast<std::ptrdiff_t>(j) * task_.input.qdd_stride + row_);
    if (link.revolute) {
      spin(m, to.qd);
      m.omega_dot.z = m.omega_dot.z + qdd;
      to.U = acceleration_field(m);
    } else {
      to.U = acceleration_field(m);
      slide(m, to.U, to.q, to.qd);
      m.accel.z = m.accel.z + qdd;
    }
    to.motion = m;
    for (std::size_t i = 0; i < depth(j); ++i) {
      Screw<Scalar> s;
      if (i + 1 < depth(j)) {
        const Screw<Scalar>& before = screw(i, static_cast<std::size_t>(link.parent));
        s.w = turned<turn>(link.R, before.w);
        s.v = turned<turn>(link.R, shifted<7>(before.v, before.w, link.p));
      } else {
        s.w = constant<Scalar>(link.parent_w);
        s.v = constant<Scalar>(link.parent_v);
      }
      s = {rotated(s.w, angle.c, angle.s), rotated(s.v, angle.c, angle.s)};
      if (!link.revolute) {
        s.v.x = s.v.x + s.w.y * to.q;
        s.v.y = s.v.y - s.w.x * to.q;
      }
      screw(i, j) = s;
    }
  }

  // What the row of the joint of depth i on the way to link j contributes there, besides what links behind it
  // have.
  [[gnu::always_inline]] void add_row(std::size_t i, std::size_t j, const Coefficients<Scalar>& body,
                                      MotionSlope<Scalar>& slope) {
    if (i == depth(j)) {
      add_power_slope(body, own_screw(task_.plan.links[j]), links_[j].motion, slope);
      return;
    }
    add_power_slope(body, screw(i, j), links_[j].motion, slope);
    const Screw<Scalar> w = wrench(body, links_[j]);
    wrenches_[i] = {wrenches_[i].w + w.w, wrenches_[i].v + w.v};
  }

  void slopes_of_sum() {
    std::size_t entries = 0;
    for (std::size_t j = 0; j < n_; ++j) {
      entries += (depth(j) + 1) * static_cast<std::size_t>(__builtin_popcount(task_.plan.links[j].mask));
    }
    const double* const* G = task_.G + entries;
    backward(0, task_.of_sum, [&](std::size_t j, MotionSlope<Scalar>& slope) {
      const LinkPlan& link = task_.plan.links[j];
      const auto wanted = __builtin_popcount(link.mask);
      for (std::size_t i = depth(j) + 1; i-- > 0;) {
        G -= wanted;
        add_row(i, j, coefficients_of<Scalar>(link, G, row_), slope);
      }
    });
  }

  void slopes_of_torque(std::size_t i) {
    const auto end = static_cast<std::size_t>(task_.plan.links[i].end);
    backward(depth(i), task_.of_torque[i], [&](std::size_t j, MotionSlope<Scalar>& slope) {
      if (j >= i && j < end) {
        add_row(depth(i), j, coefficients_of<Scalar>(task_.plan.links[j], task_.chi + 10 * j), slope);
      }
    });
  }

  // From the tips to the base: `add_rows` adds what the rows contribute at each link; those of a depth below
  // `first` have none.
  template <typename AddRows>
  [[gnu::always_inline]] void backward(std::size_t first, const SlopeTarget& target,
                                       const AddRows& add_rows) {
    const Vec3<Scalar> none = {Scalar(0.0), Scalar(0.0), Scalar(0.0)};
    const MotionSlope<Scalar> no_slope = {none, none, none};
    const auto clear = [&](Screw<Scalar>* wrenches) {
      for (std::size_t i = first; i < n_; ++i) {
        wrenches[i] = {none, none};
      }
    };
    clear(wrenches_);
    for (std::size_t f = 0; f < task_.plan.forks; ++f) {
      fork_slopes_[f] = no_slope;
      clear(fork_wrenches_ + f * n_);
    }
    MotionSlope<Scalar> slope = no_slope;
    for (std::size_t j = n_; j-- > 0;) {
      const LinkPlan& link = task_.plan.links[j];
      if (link.fork >= 0) [[unlikely]] {
        join_branches(first, link.fork, slope);
      }
      add_rows(j, slope);
      with_turn(task_.plan.links[j], [&]<Turn turn>() {
        if (task_.plan.links[j].revolute) {
          through_joint<turn, true>(first, j, target, slope);
        } else {
          through_joint<turn, false>(first, j, target, slope);
        }
      });
      if (link.parent + 1 != static_cast<int>(j)) [[unlikely]] {
        if (link.parent >= 0) {
          keep_branch(first, task_.plan.links[link.parent].fork, slope);
        }
        slope = no_slope;
        clear(wrenches_);
      }
    }
  }

  // Adds what has come to a link on which several hang to what is kept of it, and back.
  void keep_branch(std::size_t first, int fork, const MotionSlope<Scalar>& slope) {
    add(slope, fork_slopes_[fork]);
    for (std::size_t i = first; i < n_; ++i) {
      add(wrenches_[i], wrench_of(fork, i));
    }
  }
  void join_branches(std::size_t first, int fork, MotionSlope<Scalar>& slope) {
    add(fork_slopes_[fork], slope);
    for (std::size_t i = first; i < n_; ++i) {
      add(wrench_of(fork, i), wrenches_[i]);
    }
  }
  [[nodiscard]] Screw<Scalar>& wrench_of(int fork, std::size_t depth) {
    return fork_wrenches_[static_cast<std::size_t>(fork) * n_ + depth];
  }
  static void add(const MotionSlope<Scalar>& x, MotionSlope<Scalar>& to) {
    to = {to.omega + x.omega, to.omega_dot + x.omega_dot, to.accel + x.accel};
  }
  static void add(const Screw<Scalar>& x, Screw<Scalar>& to) { to = {to.w + x.w, to.v + x.v}; }

  // Puts the derivatives by joint j, and carries what is left into the frame that carries it.
  template <Turn turn, bool revolute>
  void through_joint(std::size_t first, std::size_t j, const SlopeTarget& target,
                     MotionSlope<Scalar>& slope) {
    const LinkPlan& link = task_.plan.links[j];
    const PassedLink<Scalar>& at = links_[j];
    const Vec3<Scalar> a = slope.accel;
    const Vec3<Scalar> d = slope.omega_dot;
    const Vec3<Scalar> o = slope.omega;
    const Vec3<Scalar>& omega = at.motion.omega;
    Scalar by_q(0.0);
    Scalar by_qd(0.0);
    Scalar by_qdd(0.0);
    if constexpr (revolute) {
      by_qdd = d.z;
      by_qd = o.z + omega.y * d.x - omega.x * d.y;
      slope.omega = {o.x - at.qd * d.y, o.y + at.qd * d.x, o.z};
      // Without what the joint's own velocity adds.
      const Scalar x = at.motion.omega_dot.x - omega.y * at.qd;
      const Scalar y = at.motion.omega_dot.y + omega.x * at.qd;
      by_q = a.x * at.motion.accel.y - a.y * at.motion.accel.x + d.x * y - d.y * x + slope.omega.x * omega.y -
             slope.omega.y * omega.x;
    } else {
      const Scalar twice = at.qd + at.qd;
      by_qdd = a.z;
      const Scalar half = omega.y * a.x - omega.x * a.y;
      by_qd = half + half;
      by_q = a.x * at.U.r0.z + a.y * at.U.r1.z + a.z * at.U.r2.z;
      const Vec3<Scalar> z = {Scalar(0.0), Scalar(0.0), Scalar(1.0)};
      const Vec3<Scalar> field = centripetal_slope(a, z, omega);
      slope.omega = {o.x - twice * a.y + at.q * field.x, o.y + twice * a.x + at.q * field.y,
                     o.z + at.q * field.z};
      slope.omega_dot = {d.x - at.q * a.y, d.y + at.q * a.x, d.z};
    }
    const auto back = [&](const Vec3<Scalar>& v) {
      return turned_back<turn>(link.R, rotated_back(v, at.angle.c, at.angle.s));
    };
    const Vec3<Scalar> p = constant<Scalar>(link.p);
    for (std::size_t i = first; i < depth(j); ++i) {
      const Screw<Scalar>& s = screw(i, j);
      Vec3<Scalar> w = wrenches_[i].w;  // NOLINT(misc-const-correctness): prismatic joints change it
      const Vec3<Scalar> v = wrenches_[i].v;
      if constexpr (revolute) {
        by_q = by_q + w.x * s.w.y - w.y * s.w.x + v.x * s.v.y - v.y * s.v.x;
      } else {
        by_q = by_q + v.x * s.w.y - v.y * s.w.x;
        w = {w.x - at.q * v.y, w.y + at.q * v.x, w.z};
      }
      // The screw of the joint before is constant in its own frame.
      if (i + 1 < depth(j)) {
        const Vec3<Scalar> force = back(v);
        wrenches_[i] = {back(w) + cross(p, force), force};
      }
    }
    const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(j) * target.stride + row_;
    Memory::store(by_q, target.q + to);
    Memory::store(by_qd, target.qd + to);
    Memory::store(by_qdd, target.qdd + to);
    if (link.parent >= 0) {
      const Vec3<Scalar> force = back(a);
      slope = {back(slope.omega) + centripetal_slope(force, p, links_[link.parent].motion.omega),
               back(slope.omega_dot) + cross(p, force), force};
    }
  }

  const SlopesTask& task_;
  std::size_t n_;
  PassedLink<Scalar>* links_;
  Screw<Scalar>* wrenches_;  // by the depth of the row: on frame j, of link j and those behind it
  Screw<Scalar>* screws_;
  MotionSlope<Scalar>* fork_slopes_;
  Screw<Scalar>* fork_wrenches_;
  std::ptrdiff_t row_ = 0;
};

// What one file for an instruction set offers: slopes of `packs` times `lanes` consecutive samples.
struct SlopesKernel {
  int lanes;
  // scratch: that many doubles, aligned to 64 bytes.
  std::size_t (*scratch)(std::size_t joints, std::size_t forks);
  void (*fill)(const SlopesTask& task, std::size_t packs, double* scratch);
};

template <typename Scalar>
constexpr SlopesKernel slopes_kernel() {
  return {static_cast<int>(Stored<Scalar>::lanes), &SlopesPass<Scalar>::scratch, &SlopesPass<Scalar>::fill};
}

}  // namespace rivid::detail
