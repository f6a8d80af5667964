#pragma once

#include <cstddef>
#include <tuple>
#include <vector>

#include "rivid/model/parameters.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

namespace rivid::detail {

// The generalised momentum p = M(q) q̇ of a robot and what drives it beside torques,
//
//   ṗ = τ − friction + τ_ext + ∂T/∂q − g(q),   T = ½ q̇ᵀ M q̇,
//
// where ∂T/∂q = Cᵀ(q, q̇) q̇. A turn about joint j by δ changes the twists of all links behind it by V × s δ,
// so ∂T/∂q_j is the momentum of these links on V × s: one sweep from base to tip and one back give
// everything, without M or C.
template <typename Scalar>
class Momentum {
 public:
  // Momentum of a link and all behind it, and the wrench that holds them against gravity.
  struct Load {
    Vec3<Scalar> linear, angular, f, n;

    friend Load operator+(const Load& a, const Load& b) {
      return {a.linear + b.linear, a.angular + b.angular, a.f + b.f, a.n + b.n};
    }
  };
  struct LinkState {
    Vec3<Scalar> omega, v;  // twist at the origin of the frame
    Vec3<Scalar> accel;     // of free fall, reversed
    Load own;
  };

  /// @throws InputError  the model's complaint(); where the robot branches
  explicit Momentum(const ModelData& model) : frames(model), links(frames.size()), rotor_(model.rotor) {
    require_chain("Momentum", model.chain);
  }

  [[nodiscard]] Index size() const noexcept { return static_cast<Index>(links.size()); }

  // A body on the last link beside its own, XX … M in the last frame j.
  void set_payload(const Inertial& body) noexcept { payload_ = body; }

  [[nodiscard]] auto state() noexcept { return std::tie(payload_); }

  // p and ∂T/∂q − g, (n) each.
  void operator()(const Scalar* q, const Scalar* qd, Scalar* p, Scalar* rate) noexcept {
    sweep(q, qd);
    links.back().own = links.back().own + of_body(links.back(), payload_.data());
    const Vec3<Scalar> none = {Scalar(0), Scalar(0), Scalar(0)};
    Load load = {none, none, none, none};
    for (std::size_t j = links.size(); j-- > 0;) {
      load = share(j, links[j].own + load, p[j], rate[j]);
    }
    add_product(rotor_, qd, p);
  }

  // Frames, and what each link has for itself.
  void sweep(const Scalar* q, const Scalar* qd) noexcept {
    frames.set(q);
    const Vec3<Scalar> none = {Scalar(0), Scalar(0), Scalar(0)};
    for (std::size_t j = 0; j < links.size(); ++j) {
      LinkState& at = links[j];
      if (j == 0) {
        at = {none, none, frames.base_acceleration(0), {}};
      } else {
        const LinkState& before = links[j - 1];
        at.omega = frames.into(j, before.omega);
        at.v = frames.into(j, before.v + cross(before.omega, frames.origins[j]));
        at.accel = frames.into(j, before.accel);
      }
      Scalar& along = frames.link(j).revolute ? at.omega.z : at.v.z;
      along = along + qd[j];
      at.own = of_body(at, frames.link(j).inertial);
    }
  }

  // Of a body in the frame of a link; I  XX XY XZ YY YZ ZZ MX MY MZ M.
  template <typename Number>
  [[nodiscard]] static Load of_body(const LinkState& at, const Number* I) noexcept {
    const Vec3<Scalar> h = {Scalar(I[6]), Scalar(I[7]), Scalar(I[8])};
    const auto m = static_cast<Scalar>(I[9]);
    const Mat3<Scalar> tensor = {{Scalar(I[0]), Scalar(I[1]), Scalar(I[2])},
                                 {Scalar(I[1]), Scalar(I[3]), Scalar(I[4])},
                                 {Scalar(I[2]), Scalar(I[4]), Scalar(I[5])}};
    return {scaled(m, at.v) + cross(at.omega, h), tensor.times(at.omega) + cross(h, at.v),
            scaled(m, at.accel), cross(h, at.accel)};
  }

  // What joint j sees of the load on it, and the same load in the frame before.
  [[nodiscard]] Load share(std::size_t j, const Load& load, Scalar& p, Scalar& rate) const noexcept {
    const LinkState& at = links[j];
    const Vec3<Scalar> turned_omega = {at.omega.y, -at.omega.x, Scalar(0)};  // ω × z
    if (frames.link(j).revolute) {
      p = load.angular.z;
      rate = dot(load.angular, turned_omega) + (load.linear.x * at.v.y - load.linear.y * at.v.x) - load.n.z;
    } else {
      p = load.linear.z;
      rate = dot(load.linear, turned_omega) - load.f.z;
    }
    if (j == 0) {
      return load;
    }
    const Vec3<Scalar> linear = frames.out_of(j, load.linear);
    const Vec3<Scalar> f = frames.out_of(j, load.f);
    return {linear, frames.out_of(j, load.angular) + cross(frames.origins[j], linear), f,
            frames.out_of(j, load.n) + cross(frames.origins[j], f)};
  }

  JointFrames<Scalar> frames;
  std::vector<LinkState> links;

 private:
  Matrix rotor_;
  Inertial payload_ = Inertial::Zero();
};

// The torque that a gear passes on of what other friction leaves, where friction follows the load; v_s
// smooths its sign.
template <typename Scalar>
[[nodiscard]] Scalar passed_on(double load, const Scalar& v_s, const Scalar& torque, const Scalar& speed) {
  return load == 0.0 ? torque : DryFriction::carried(torque, Scalar(Scalar(load) * smooth_sign(speed, v_s)));
}

// What a first-order low-pass makes of r, whose input is the rate of a momentum less what is known to drive
// it.
template <typename Scalar>
[[nodiscard]] Scalar low_pass(const Scalar& r, const Scalar& keep, const Scalar& before, const Scalar& now,
                              const Scalar& driven, const Scalar& f_m) {
  return keep * r + (Scalar(1) - keep) * ((now - before) * f_m - driven);
}

}  // namespace rivid::detail
