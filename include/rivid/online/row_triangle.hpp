#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/online/information_triangle.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_stream.hpp"
#include "rivid/online/saved_state.hpp"

namespace rivid::detail {

// Rows of joints whose friction follows their load, τ = u + Fl s |u| + … with u = (M q̈ + N)_j, made linear
// at the model's parameters and a body on the last link, by the formula of LoadColumns:
//
//   (1 + Fl₀ g s) u + s |u₀| Fl = y + Fl₀ g s u₀,   g = u₀ / √(u₀² + w²),
//
// with w the deviation of the joint's residual.
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
    return {row.joint, scratch_.data(), row.y + slope * load, row.direction, row.speed};
  }

  [[nodiscard]] auto state() noexcept { return std::tie(point_); }

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

// The rows of a control loop on their way into the triangle of an estimate, and the time that goes by
// meanwhile: what the estimators have in common. `report` is what they do with the Outcome of a row.
template <typename Scalar>
class RowTriangle {
 public:
  using Stream = RowStream<Scalar>;
  using Triangle = InformationTriangle<Scalar>;
  using Values = typename Stream::Values;

  // columns     of the rows: the model's base parameters, and more behind them
  // unknowns    of the triangle
  // forgetting  time constant of the information [s]
  // others      rows that come in each stride beside those of the joints
  // beside      columns beside y
  RowTriangle(const OnlineModel& model, std::span<const StandardParameter> columns,
              const RowStreamOptions& options, Index unknowns, double forgetting, Index others = 0,
              Index beside = 0)
      : stream_(model.robot, columns, options),
        load_(model, stream_.columns(), columns),
        triangle_(unknowns, 2 * model.robot.size() + others, beside),
        seconds_(static_cast<double>(stream_.stride()) / options.f_m),
        keep_(std::exp(-0.5 * seconds_ / forgetting)),
        operations_((model.robot.size() + others) * triangle_.cost_of_row() / stream_.stride() + unknowns) {}

  [[nodiscard]] const Stream& stream() const noexcept { return stream_; }
  [[nodiscard]] Triangle& triangle() noexcept { return triangle_; }
  [[nodiscard]] const Triangle& triangle() const noexcept { return triangle_; }
  // Time of a stride [s], and what is left of R after it.
  [[nodiscard]] double seconds() const noexcept { return seconds_; }
  [[nodiscard]] double keep() const noexcept { return keep_; }
  // Factor of n rows of what is known beforehand, one of which comes back in each stride, so that they fade
  // as little as they are repeated.
  [[nodiscard]] double repeated(Index n) const noexcept {
    return std::sqrt(static_cast<double>(n) * (1.0 - keep_ * keep_));
  }

  // A body on the last link that the model does not have, whose load friction feels: XX … M, and the columns
  // of these.
  template <typename Body, typename Places>
  void set_body(const Body& body, const Places& places) noexcept {
    load_.set_body(body, places);
  }

  // A tick: add(Row) for each row that it finishes, step() once a stride while any joint moves, then as much
  // work on the rows that wait as each tick has. (Joints finish their rows at ticks of their own.)
  template <typename Add, typename Step, typename Report>
  void tick(const Values& q, const Values& tau, const Add& add, const Step& step,
            const Report& report) noexcept {
    if (stream_.update(q, tau)) {
      stream_.for_each_row([&](const typename Stream::Row& row) { add(load_(row)); });
      if (until_step_ == 0) {
        until_step_ = stream_.stride();
        step();
      }
    }
    until_step_ = std::max<Index>(until_step_ - 1, 0);
    static_cast<void>(triangle_.work(operations_, report));
  }

  // add(Row) for the rows of a rest, once it has lasted.
  template <typename Add>
  void rest(const Add& add) noexcept {
    stream_.for_each_rest_row([&](const typename Stream::Row& row) { add(load_(row)); });
  }

  // Room for a row, full of zeros, at once: rows that wait are taken first where there is none.
  template <typename Report>
  [[nodiscard]] Scalar* room(const Report& report) noexcept {
    while (triangle_.full()) {
      static_cast<void>(triangle_.work(triangle_.cost_of_row(), report));
    }
    return triangle_.room();
  }

  // Windows begin anew.
  void reset_stream() noexcept { stream_.reset(); }

  [[nodiscard]] auto state() noexcept { return std::tie(stream_, load_, triangle_, until_step_); }

 private:
  Stream stream_;
  LoadTangent<Scalar> load_;
  Triangle triangle_;
  double seconds_;
  double keep_;
  Index operations_;  // of each tick
  Index until_step_ = 0;
};

// Lower triangle L of A = L Lᵀ; throws where A is not positive definite. (Eigen's costs users of
// rivid::headers seconds.)
inline Matrix cholesky_of(const Matrix& A, const char* who) {
  const Index n = A.rows();
  Matrix L = Matrix::Zero(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      double sum = A(i, j);
      for (Index k = 0; k < j; ++k) {
        sum -= L(i, k) * L(j, k);
      }
      if (i == j) {
        if (!(sum > 0.0)) {
          throw InputError(std::string(who) + ": the covariance of the parameters is not positive definite");
        }
        L(j, j) = std::sqrt(sum);
      } else {
        L(i, j) = sum / L(j, j);
      }
    }
  }
  return L;
}

// L⁻¹ of a lower triangle: its rows are whitened rows of information, L⁻¹ χ = L⁻¹ χ̂ + e, for C = L Lᵀ.
inline Matrix inverse_of_lower(const Matrix& L) {
  const Index n = L.rows();
  Matrix out = Matrix::Zero(n, n);
  for (Index c = 0; c < n; ++c) {
    out(c, c) = 1.0 / L(c, c);
    for (Index i = c + 1; i < n; ++i) {
      double sum = 0.0;
      for (Index k = c; k < i; ++k) {
        sum += L(i, k) * out(k, c);
      }
      out(i, c) = -sum / L(i, i);
    }
  }
  return out;
}

// What is known of parameters beforehand as rows: factor (χ − χ̂) has unit variance.
inline Matrix whitening_of(const Matrix& C, const char* who) {
  // Scaled to deviations of one: entries of C may differ by many decades.
  const Vector scale = C.diagonal().cwiseSqrt().cwiseInverse();
  Matrix scaled(C.rows(), C.cols());
  for (Index i = 0; i < C.rows(); ++i) {
    for (Index j = 0; j < C.cols(); ++j) {
      scaled(i, j) = C(i, j) * scale[i] * scale[j];
    }
  }
  Matrix out = inverse_of_lower(cholesky_of(scaled, who));
  for (Index j = 0; j < C.cols(); ++j) {
    out.col(j) *= scale[j];
  }
  return out;
}

// The same, row by row into a triangle.
//
// place  unknown of the triangle that a parameter is
template <typename Scalar, typename Place>
void add_prior(InformationTriangle<Scalar>& to, const Matrix& C, const Vector& chi, const Place& place,
               const char* who) {
  const Matrix whitening = whitening_of(C, who);
  for (Index i = 0; i < chi.size(); ++i) {
    Scalar* const w = to.room();
    double y = 0.0;
    for (Index c = 0; c <= i; ++c) {
      w[place(c)] = static_cast<Scalar>(whitening(i, c));
      y += whitening(i, c) * chi[c];
    }
    w[to.size()] = static_cast<Scalar>(y);
    to.commit(-1);
    to.finish([](const auto& /*outcome*/) {});
  }
}

// The model, once it is known that an estimator can be made of it: before anything reads it.
template <typename Options>
[[nodiscard]] const OnlineModel& usable(const char* who, const OnlineModel& model, const Options& options) {
  if (const auto fault = model.complaint()) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  if (const auto fault = options.complaint(model.robot.size())) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  return model;
}

// Options of the rows, with the model's thresholds where they have none.
template <typename Options>
[[nodiscard]] RowStreamOptions row_options(const OnlineModel& model, const Options& options) {
  const RowStreamOptions& rows = options.rows;
  return {.f_m = rows.f_m,
          .stride = rows.stride,
          .torque_held = rows.torque_held,
          .velocity_threshold =
              rows.velocity_threshold.size() == 0 ? model.velocity_threshold : rows.velocity_threshold,
          .velocity_span = rows.velocity_span};
}

// Whose state an estimator has that is made of a model.
//
// others  options beside the rows' and the flange's
template <typename Scalar, typename... Others>
[[nodiscard]] StateOwner owner_of(const char* who, const OnlineModel& model, const RowStreamOptions& rows,
                                  const Others&... others) {
  const auto& [robot, base, chi, C_chi, sigma_rho, velocity_threshold] = model;
  std::uint64_t laws = 0;
  for (const Joint& joint : robot.joints) {
    laws = Fingerprint::of(laws, joint.sign_speed);
  }
  for (const BaseParameter& parameter : base.parameters) {
    laws = Fingerprint::of(laws, parameter.leading.kind, parameter.leading.joint);
  }
  for (const Coupling& coupling : robot.couplings) {
    laws = Fingerprint::of(laws, coupling.row(robot.size()), coupling.coulomb, coupling.terms);
  }
  const auto& [f_m, stride, torque_held, threshold, span] = rows;
  return {.kind = kind_of<Scalar>(who),
          .arm = Fingerprint::of(robot.chain, laws, chi, C_chi, sigma_rho, velocity_threshold),
          .rate = Fingerprint::of(f_m),
          .options = Fingerprint::of(stride, torque_held, threshold, span, others...)};
}

}  // namespace rivid::detail
