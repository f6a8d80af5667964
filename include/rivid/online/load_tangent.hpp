#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "rivid/model/kinds.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_stream.hpp"

namespace rivid::detail {

// Rows of joints whose friction follows their load, τ = u + Fl s |u| + … with u = (M q̈ + N)_j, made linear at the model's parameters
// and a body on the last link, by the formula of LoadColumns:
//
//   (1 + Fl₀ g s) u + s |u₀| Fl = y + Fl₀ g s u₀,   g = u₀ / √(u₀² + w²),   w the deviation of the joint's residual.
//
// While u has the sign of u₀ this leaves (Fl − Fl₀) (|u| − |u₀|) s.
template <typename Scalar>
class LoadTangent {
 public:
  using Row = typename RowStream<Scalar>::Row;

  // columns     of the rows …
  // parameters  … and what they are; the model's base parameters come first
  LoadTangent(const OnlineModel& model, const RegressorColumns& columns,
              std::span<const StandardParameter> parameters)
      : joints_(columns.joints()), known_(parameters.size(), Scalar(0)) {
    for (Index i = 0; i < model.base.size(); ++i) {
      known_[static_cast<std::size_t>(i)] = static_cast<Scalar>(model.chi[i]);
    }
    point_ = known_;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      JointLoad& joint = joints_[j];
      const std::vector<Index>& own = columns.of_joint(j);
      joint.count = own.size();
      for (std::size_t c = 0; c < own.size(); ++c) {
        const auto at = static_cast<std::size_t>(own[c]);
        const ParameterKind kind = parameters[at].kind;
        if (about(kind).basis == Basis::load) {
          joint.column = c;
          joint.follows = true;
          joint.slope = known_[at];
          joint.width = static_cast<Scalar>(model.sigma_rho[static_cast<Index>(j)]);
        } else if (!is_friction(kind)) {
          joint.rigid.push_back({c, at});
        }
      }
      scratch_.resize(std::max(scratch_.size(), own.size()));
    }
  }

  // A body on the last link that the model does not have.
  //
  // body    XX … M
  // places  columns of these
  template <typename Body, typename Places>
  void set_body(const Body& body, const Places& places) noexcept {
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto at = static_cast<std::size_t>(places[k]);
      point_[at] = known_[at] + body[static_cast<Index>(k)];
    }
  }

  // The row as it is, or one of the tangent, which stays until the next one.
  [[nodiscard]] Row operator()(const Row& row) noexcept {
    const JointLoad& joint = joints_[row.joint];
    if (!joint.follows) {
      return row;
    }
    using std::abs;
    using std::sqrt;
    std::copy_n(row.values, joint.count, scratch_.begin());
    Scalar load(0);
    for (const Rigid& rigid : joint.rigid) {
      load = load + row.values[rigid.column] * point_[rigid.parameter];
    }
    const Scalar sign = row.values[joint.column];
    const Scalar size = sqrt(Scalar(load * load + joint.width * joint.width));
    const Scalar slope = joint.slope * sign * load / size;
    scratch_[joint.column] = sign * abs(load);
    for (const Rigid& rigid : joint.rigid) {
      scratch_[rigid.column] = row.values[rigid.column] * (Scalar(1) + slope);
    }
    return {row.joint, scratch_.data(), row.y + slope * load, row.direction};
  }

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    auto& [joints, known, point, scratch] = *this;
    visit_parts(visit, point);
  }

 private:
  struct Rigid {
    std::size_t column;     // in the joint's rows
    std::size_t parameter;  // whose it is
  };
  struct JointLoad {
    bool follows = false;
    std::size_t count = 0;   // of columns of its rows
    std::size_t column = 0;  // that of Fl
    Scalar slope = Scalar(0);
    Scalar width = Scalar(0);
    std::vector<Rigid> rigid;  // columns of M q̈ + N
  };

  std::vector<JointLoad> joints_;
  std::vector<Scalar> known_;  // parameters of the model, zero for a body's
  std::vector<Scalar> point_;  // … with the body
  std::vector<Scalar> scratch_;
};

}  // namespace rivid::detail
