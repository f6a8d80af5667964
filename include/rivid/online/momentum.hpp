#pragma once

#include <cstddef>
#include <vector>

#include "rivid/model/parameters.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/simulate/dynamics.hpp"

namespace rivid::detail {

// The generalised momentum p = M(q) q̇ of a robot and what drives it beside torques,
//
//   ṗ = τ − friction + τ_ext + ∂T/∂q − g(q),   T = ½ q̇ᵀ M q̇,
//
// where ∂T/∂q = Cᵀ(q, q̇) q̇. A turn about joint j by δ changes the twists of all links behind it by V × s δ, so ∂T/∂q_j is the
// momentum of these links on V × s: one sweep from base to tip and one back give everything, without M or C.
template <typename Scalar>
class Momentum {
 public:
  explicit Momentum(const ModelData& model)
      : tables_(model), rotor_(model.rotor), turns_(tables_.links.size()), links_(tables_.links.size()) {}

  [[nodiscard]] Index size() const noexcept { return static_cast<Index>(links_.size()); }

  // A body on the last link beside its own, XX … M in the last frame j.
  void set_payload(const Inertial& body) noexcept { payload_ = body; }

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    auto& [tables, rotor, payload, turns, links] = *this;
    visit_parts(visit, payload);
  }

  // p and ∂T/∂q − g, (n) each.
  void operator()(const Scalar* q, const Scalar* qd, Scalar* p, Scalar* rate) noexcept {
    for (std::size_t j = 0; j < links_.size(); ++j) {
      forward(j, q[j], qd[j]);
    }
    for (std::size_t j = links_.size(); j-- > 0;) {
      const LinkState& at = links_[j];
      const Vec3<Scalar> turned_omega = {at.omega.y, -at.omega.x, Scalar(0)};  // ω × z
      if (tables_.links[j].revolute) {
        p[j] = at.angular.z;
        rate[j] = dot(at.angular, turned_omega) + (at.linear.x * at.v.y - at.linear.y * at.v.x) - at.n.z;
      } else {
        p[j] = at.linear.z;
        rate[j] = dot(at.linear, turned_omega) - at.f.z;
      }
      if (j > 0) {
        back(j, q[j]);
      }
    }
    for (Index i = 0; i < size(); ++i) {
      for (Index j = 0; j < size(); ++j) {
        p[i] = p[i] + static_cast<Scalar>(rotor_(i, j)) * qd[j];
      }
    }
  }

 private:
  struct LinkState {
    Vec3<Scalar> omega, v;         // twist at the origin of the frame
    Vec3<Scalar> accel;            // of free fall, reversed
    Vec3<Scalar> linear, angular;  // momentum of this link and all behind it
    Vec3<Scalar> f, n;             // wrench that holds them against gravity
  };

  [[nodiscard]] Vec3<Scalar> into(std::size_t j, const Vec3<Scalar>& v) const noexcept {
    return rotated(turned<Turn::any>(tables_.links[j].R, v), turns_[j].c, turns_[j].s);
  }
  [[nodiscard]] Vec3<Scalar> out_of(std::size_t j, const Vec3<Scalar>& v) const noexcept {
    return turned_back<Turn::any>(tables_.links[j].R, rotated_back(v, turns_[j].c, turns_[j].s));
  }
  [[nodiscard]] static Vec3<Scalar> origin(const DynamicsLink& link, const Scalar& q) noexcept {
    const auto p = constant<Scalar>(link.p);
    return link.revolute
               ? p
               : p + Vec3<Scalar>{Scalar(link.R[2]) * q, Scalar(link.R[5]) * q, Scalar(link.R[8]) * q};
  }
  [[nodiscard]] static Vec3<Scalar> times(const Scalar& factor, const Vec3<Scalar>& v) noexcept {
    return {factor * v.x, factor * v.y, factor * v.z};
  }

  void forward(std::size_t j, const Scalar& q, const Scalar& qd) noexcept {
    const DynamicsLink& link = tables_.links[j];
    CosSin<Scalar> angle = {Scalar(1), Scalar(0)};
    if (link.revolute) {
      sin_cos(q, angle.s, angle.c);
    }
    turns_[j] = {angle.c * Scalar(link.cos_theta) - angle.s * Scalar(link.sin_theta),
                 angle.s * Scalar(link.cos_theta) + angle.c * Scalar(link.sin_theta)};
    LinkState& at = links_[j];
    if (j == 0) {
      const Vec3<Scalar> none = {Scalar(0), Scalar(0), Scalar(0)};
      at.omega = none;
      at.v = none;
      at.accel = rotated(constant<Scalar>(tables_.accel.data()), turns_[0].c, turns_[0].s);
    } else {
      const LinkState& before = links_[j - 1];
      at.omega = into(j, before.omega);
      at.v = into(j, before.v + cross(before.omega, origin(link, q)));
      at.accel = into(j, before.accel);
    }
    (link.revolute ? at.omega.z : at.v.z) = (link.revolute ? at.omega.z : at.v.z) + qd;

    at.linear = at.angular = at.f = at.n = {Scalar(0), Scalar(0), Scalar(0)};
    add_body(at, link.inertial);
    if (j + 1 == links_.size()) {
      add_body(at, payload_.data());
    }
  }

  // I  XX XY XZ YY YZ ZZ MX MY MZ M
  static void add_body(LinkState& at, const double* I) noexcept {
    const auto h = constant<Scalar>(I + 6);
    const Scalar m = static_cast<Scalar>(I[9]);
    const Mat3<Scalar> tensor = {{Scalar(I[0]), Scalar(I[1]), Scalar(I[2])},
                                 {Scalar(I[1]), Scalar(I[3]), Scalar(I[4])},
                                 {Scalar(I[2]), Scalar(I[4]), Scalar(I[5])}};
    at.linear = at.linear + times(m, at.v) + cross(at.omega, h);
    at.angular = at.angular + tensor.times(at.omega) + cross(h, at.v);
    at.f = at.f + times(m, at.accel);
    at.n = at.n + cross(h, at.accel);
  }

  void back(std::size_t j, const Scalar& q) noexcept {
    const LinkState& at = links_[j];
    LinkState& before = links_[j - 1];
    const Vec3<Scalar> p = origin(tables_.links[j], q);
    const Vec3<Scalar> linear = out_of(j, at.linear);
    const Vec3<Scalar> f = out_of(j, at.f);
    before.linear = before.linear + linear;
    before.angular = before.angular + out_of(j, at.angular) + cross(p, linear);
    before.f = before.f + f;
    before.n = before.n + out_of(j, at.n) + cross(p, f);
  }

  DynamicsTables tables_;
  Matrix rotor_;
  Inertial payload_ = Inertial::Zero();
  std::vector<CosSin<Scalar>> turns_;
  std::vector<LinkState> links_;
};

}  // namespace rivid::detail
