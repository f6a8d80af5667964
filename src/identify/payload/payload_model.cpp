#include "identify/payload/payload_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "dense.hpp"
#include "gram.hpp"
#include "rivid/model/kinds.hpp"

namespace rivid::detail {

namespace {

constexpr int most_iterations = 60;  // a choice that ends what does not settle
// Step of an unknown in its deviations for independent errors that ends the iteration.
constexpr double settled_step = 1e-3;
// Eigenvalues of the scaled information that count as zero, relative to the largest.
constexpr double singular = 1e-11;
// Errors of a joint's torques are at least this part of them: no weight is infinite.
constexpr double least_error = 1e-7;
// A known mass and a known gain without a deviation, relative.
constexpr double exact_mass = 1e-5;
constexpr double exact_gain = 1e-5;
constexpr double most_leverage_of_row = 0.9;  // a choice: bounds the correction for leverage at ten times
// Part of an inverse gain that it moves by at most in a step.
constexpr double most_gain_step = 0.5;

double sign_of(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

// Ixx, Ixy, Ixz, Iyy, Iyz, Izz.
Eigen::Vector<double, 6> tensor(const Eigen::Matrix3d& I) {
  return {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)};
}

// With exact gains.
Matrix covariance_of(const IdentifiedArm& arm) {
  return arm.gain_covariance.size() == 0
             ? arm.C_chi
             : Matrix(arm.C_chi - arm.gain_slopes * arm.gain_covariance * arm.gain_slopes.transpose());
}

// Inverse; directions of next to no variance count as known well.
Matrix information_of(const Matrix& C) {
  // Least eigenvalue of the correlations, relative to the largest.
  constexpr double least = 1e-12;
  const Vector scale = C.diagonal().cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * C * scale.asDiagonal());
  const double floor = least * eigen.values[eigen.values.size() - 1];
  const Matrix inverse =
      eigen.vectors * eigen.values.cwiseMax(floor).cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace

ArmPrior::ArmPrior(const IdentifiedArm& arm, std::vector<Index> places, Index gains_at)
    : chi_(arm.chi),
      information_(information_of(covariance_of(arm))),
      slopes_(arm.gain_slopes),
      places_(std::move(places)),
      gains_at_(gains_at) {}

void ArmPrior::add_to(Known& known, const Vector& theta) const {
  Matrix J = Matrix::Zero(chi_.size(), theta.size());
  Vector rho = chi_ - theta(places_);
  for (Index i = 0; i < chi_.size(); ++i) {
    J(i, places_[static_cast<std::size_t>(i)]) = 1.0;
  }
  for (Index j = 0; gains_at_ >= 0 && j < slopes_.cols(); ++j) {
    const double r = theta[gains_at_ + j];
    J.col(gains_at_ + j) = slopes_.col(j) / (r * r);
    rho -= (1.0 - 1.0 / r) * slopes_.col(j);
  }
  const Matrix JtC = J.transpose() * information_;
  known.A += JtC * J;
  known.a += JtC * rho;
}

Matrix gain_information(const Vector& sigma) {
  const bool exact = sigma.size() == 0 || (sigma.array() <= 0.0).all();
  return exact ? Matrix()
               : Matrix(sigma
                            .unaryExpr([](double x) {
                              const double least = std::max(x, exact_gain);
                              return std::isfinite(x) ? 1.0 / (least * least) : 0.0;
                            })
                            .asDiagonal());
}

Matrix gain_information_of(const Matrix& C) {
  if (C.size() == 0 || C.isZero(0.0)) {
    return {};
  }
  return inverse(C + exact_gain * exact_gain * Matrix::Identity(C.rows(), C.cols()));
}

PayloadFit::PayloadFit(const PayloadProblem& problem)
    : problem_(problem), logs_(problem.logs), b_(problem.columns.base.size()) {
  const Index n = problem.robot.size();
  Index size = b_;
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    payload_at_.push_back(size);
    size += inertial_count;
  }
  theta_ = Vector::Zero(size);
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    theta_[payload_at_[k] + inertial_count - 1] = problem.loads[k].mass.value_or(1.0);
  }
  place_load_friction();
  if (problem.gain_information.size() > 0) {
    gains_at_ = theta_.size();
    theta_.conservativeResize(gains_at_ + n);
    theta_.tail(n).setOnes();
  }
  place_arm();
  weights_ = Vector::Ones(n);
}

void PayloadFit::place_load_friction() {
  const std::vector<StandardParameter> all = problem_.columns.all.columns();
  for (const StandardParameter& p : all) {
    rigid_.push_back(is_friction(p.kind) ? 0 : 1);
  }
  Index size = theta_.size();
  for (int j = 0; j < static_cast<int>(problem_.robot.size()); ++j) {
    const auto sign = std::ranges::find_if(
        all, [&](const StandardParameter& p) { return p.joint == j && p.kind == ParameterKind::Fc; });
    const bool follows = problem_.load_friction && sign != all.end();
    load_at_.push_back(follows ? size++ : -1);
    sign_at_.push_back(follows ? sign - all.begin() : -1);
  }
  theta_.conservativeResizeLike(Vector::Zero(size));
}

void PayloadFit::place_arm() {
  if (problem_.arm == nullptr) {
    return;
  }
  const BaseParameters& base = problem_.columns.base;
  std::vector<Index> places;
  for (const BaseParameter& p : base_parameters(problem_.arm->robot).parameters) {
    if (about(p.leading.kind).basis == Basis::load) {
      places.push_back(load_at_[static_cast<std::size_t>(p.leading.joint)]);
    } else {
      const auto at = std::ranges::find_if(base.parameters, [&](const BaseParameter& own) {
        return own.leading.kind == p.leading.kind && own.leading.joint == p.leading.joint;
      });
      places.push_back(at - base.parameters.begin());
    }
  }
  // What is linear begins where the arm is.
  theta_(places) = problem_.arm->chi;
  arm_.emplace(*problem_.arm, std::move(places), gains_at_);
}

Vector PayloadFit::load_friction() const {
  Vector out = Vector::Zero(weights_.size());
  for (Index j = 0; j < out.size(); ++j) {
    const Index at = load_at_[static_cast<std::size_t>(j)];
    out[j] = at >= 0 ? theta_[at] : 0.0;
  }
  return out;
}

// The inertia about the centre of mass, J − (hᵀh 1 − h hᵀ) / m, is measured as m k² 1 with the usual radius
// of gyration k, with a deviation of m k² on the diagonal and half of that beside it.
void PayloadFit::add_usual_body(std::size_t k, Known& to) const {
  constexpr double least_mass = 0.05;  // [kg], of which it is a body where there may be none
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const auto pi = theta_.segment<inertial_count>(payload_at_[k]);
  const Eigen::Vector3d h = pi.segment<3>(6);
  // What is negative is a body that was taken off.
  const double m =
      std::copysign(std::max(std::abs(pi[inertial_count - 1]), least_mass), pi[inertial_count - 1]);
  const double square = usual_gyration * usual_gyration;
  const Eigen::Vector<double, 6> steiner = tensor(h.squaredNorm() * one - h * h.transpose()) / m;
  Matrix J = Matrix::Identity(6, inertial_count);
  for (Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d e = one.col(i);
    J.col(6 + i) = -tensor(2.0 * h[i] * one - e * h.transpose() - h * e.transpose()) / m;
  }
  J.col(inertial_count - 1) = steiner / m - square * tensor(one);
  const Vector rho = m * square * tensor(one) - (pi.head<6>() - steiner);
  const Vector sigma = 0.5 * m * square * (tensor(one).array() + 1.0);
  const Matrix weighted = sigma.cwiseAbs2().cwiseInverse().asDiagonal() * J;
  to.A.block<inertial_count, inertial_count>(payload_at_[k], payload_at_[k]) += weighted.transpose() * J;
  to.a.segment<inertial_count>(payload_at_[k]) += weighted.transpose() * rho;
}

PayloadFit::Columns PayloadFit::columns_of(const PayloadLog& log, const PayloadRows& rows) const {
  const auto own = static_cast<Index>(rows.columns.size());
  Columns out{Vector::Zero(own), Matrix::Zero(rows.W.rows(), inertial_count), -1};
  const bool loaded = log.load != PayloadLog::no_load;
  const auto which = static_cast<std::size_t>(std::max<Index>(log.load, 0));
  const Inertial load =
      loaded ? Inertial(theta_.segment<inertial_count>(payload_at_[which])) : Inertial::Zero();
  for (Index c = 0; c < own; ++c) {
    const Index at = rows.columns[static_cast<std::size_t>(c)];
    out.value[c] = at < b_ ? theta_[at] : 0.0;
    out.sign = at == sign_at_[rows.joint] ? c : out.sign;
    for (std::size_t k = 0; loaded && k < inertial_count; ++k) {
      if (problem_.columns.body[k] == at) {
        out.value[c] += load[static_cast<Index>(k)];
        out.of_body.col(static_cast<Index>(k)) = rows.W.col(c);
      }
    }
  }
  return out;
}

// y = r (rigid + Fl sign(q̇) |rigid| + rest), where the rest is what load friction does not follow.
PayloadFit::Tangent PayloadFit::tangent(const PayloadLog& log, const PayloadRows& rows) const {
  const Index count = rows.W.rows();
  const auto own = static_cast<Index>(rows.columns.size());
  const Columns columns = columns_of(log, rows);
  const auto is_rigid = [&](Index at) { return rigid_[static_cast<std::size_t>(at)] != 0; };
  Vector rigid = Vector::Zero(count);
  Vector torque = Vector::Zero(count);
  for (Index c = 0; c < own; ++c) {
    const Index at = rows.columns[static_cast<std::size_t>(c)];
    (is_rigid(at) ? rigid : torque) += columns.value[c] * rows.W.col(c);
  }
  torque += rigid;
  Tangent out{Matrix::Zero(count, theta_.size()), rows.y};
  Vector factor = Vector::Ones(count);  // ∂torque/∂rigid
  const Index Fl_at = load_at_[rows.joint];
  if (Fl_at >= 0 && columns.sign >= 0) {
    const Vector sign = rows.W.col(columns.sign);
    out.J.col(Fl_at) = sign.cwiseProduct(rigid.cwiseAbs());
    torque += theta_[Fl_at] * out.J.col(Fl_at);
    factor += theta_[Fl_at] * sign.cwiseProduct(rigid.unaryExpr(&sign_of));
  }
  for (Index c = 0; c < own; ++c) {
    const Index at = rows.columns[static_cast<std::size_t>(c)];
    if (at < b_) {
      out.J.col(at) = is_rigid(at) ? Vector(rows.W.col(c).cwiseProduct(factor)) : Vector(rows.W.col(c));
    }
  }
  if (log.load != PayloadLog::no_load) {
    const auto which = static_cast<std::size_t>(log.load);
    out.J.middleCols(payload_at_[which], inertial_count) = factor.asDiagonal() * columns.of_body;
  }
  if (gains_at_ >= 0) {
    const Index at = gains_at_ + static_cast<Index>(rows.joint);
    out.J *= theta_[at];
    out.J.col(at) = torque;
    torque *= theta_[at];
  }
  out.rho -= torque;
  return out;
}

Known PayloadFit::known() const {
  const Index p = theta_.size();
  Known out{Matrix::Zero(p, p), Vector::Zero(p)};
  if (gains_at_ >= 0) {
    // Of log r: no gain runs away where the rows hardly tell it from the parameters of its joint alone.
    const auto r = theta_.tail(weights_.size());
    const Matrix pull = r.cwiseInverse().asDiagonal() * problem_.gain_information;
    out.A.bottomRightCorner(r.size(), r.size()) = pull * r.cwiseInverse().asDiagonal();
    out.a.tail(r.size()) = -(pull * r.array().log().matrix());
  }
  for (std::size_t k = 0; k < problem_.loads.size(); ++k) {
    const PayloadProblem::Load& load = problem_.loads[k];
    if (load.mass) {
      const double sigma = std::max(load.mass_sigma, exact_mass * *load.mass);
      const Index at = payload_at_[k] + inertial_count - 1;
      out.A(at, at) += 1.0 / (sigma * sigma);
      out.a[at] += (*load.mass - theta_[at]) / (sigma * sigma);
    }
    if (load.usual) {
      add_usual_body(k, out);
    }
  }
  if (arm_) {
    arm_->add_to(out, theta_);
  }
  return out;
}

PayloadFit::Inverse PayloadFit::inverse_information(const Matrix& A) {
  const Vector scale = A.diagonal().unaryExpr([](double x) { return x > 0.0 ? 1.0 / std::sqrt(x) : 0.0; });
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * A * scale.asDiagonal());
  const double least = singular * eigen.values[eigen.values.size() - 1];
  const Vector inverse = eigen.values.unaryExpr([&](double x) { return x > least ? 1.0 / x : 0.0; });
  const Vector dark = (inverse.array() == 0.0).cast<double>();
  return {scale.asDiagonal() * (eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose()) *
              scale.asDiagonal(),
          eigen.vectors.cwiseAbs2() * dark};
}

PayloadFit::Normal PayloadFit::normal() const {
  const Index p = theta_.size();
  const Index n = weights_.size();
  Normal out{Matrix::Zero(p, p), Vector::Zero(p), Vector::Zero(n), Vector::Zero(n), Vector::Zero(n)};
  for (const PayloadLog& log : logs_) {
    for (const PayloadRows& rows : log.joints) {
      const Tangent t = tangent(log, rows);
      const auto j = static_cast<Index>(rows.joint);
      const double weight = weights_[j] * weights_[j];
      add_gram(out.A, t.J, weight);
      out.a += weight * (t.J.transpose() * t.rho);
      out.squares[j] += t.rho.squaredNorm();
      out.counts[j] += static_cast<double>(t.rho.size());
      out.y_squares[j] += rows.y.squaredNorm();
    }
  }
  out.A.triangularView<Eigen::StrictlyUpper>() = out.A.transpose();
  const Known beforehand = known();
  out.A += beforehand.A;
  out.a += beforehand.a;
  return out;
}

PayloadFit::Rest PayloadFit::rest_with(std::size_t k) const {
  Vector squares = Vector::Zero(weights_.size());
  Vector counts = squares;
  Vector of_mass = squares;     // squared torques of a kilogram
  Vector of_payload = squares;  // and of the payload
  for (const PayloadLog& log : logs_) {
    for (const PayloadRows& rows : log.joints) {
      if (log.load == static_cast<Index>(k)) {
        const auto j = static_cast<Index>(rows.joint);
        squares[j] += tangent(log, rows).rho.squaredNorm();
        counts[j] += static_cast<double>(rows.y.size());
        const double r = gains_at_ >= 0 ? theta_[gains_at_ + j] : 1.0;
        const Matrix of_body = columns_of(log, rows).of_body;
        of_mass[j] += r * r * of_body.col(inertial_count - 1).squaredNorm();
        of_payload[j] += r * r * (of_body * theta_.segment<inertial_count>(payload_at_[k])).squaredNorm();
      }
    }
  }
  const Vector by = weights_.cwiseAbs2();
  return {(squares.array() / counts.array()).sqrt(), std::sqrt(by.dot(squares) / by.dot(of_mass)),
          std::sqrt(by.dot(of_payload) / by.dot(squares))};
}

void PayloadFit::follow_gains() {
  const Normal others = normal();
  theta_.head(gains_at_) +=
      inverse_information(others.A.topLeftCorner(gains_at_, gains_at_)).matrix * others.a.head(gains_at_);
}

bool PayloadFit::solve() {
  const auto n = weights_.size();
  bool settled = false;
  for (iterations_ = 1; iterations_ <= most_iterations && !settled; ++iterations_) {
    const Normal at = normal();
    relative_error_ = at.y_squares.sum() > 0.0 ? std::sqrt(at.squares.sum() / at.y_squares.sum()) : 0.0;
    rows_ = static_cast<Index>(at.counts.sum());
    const Inverse inverse = inverse_information(at.A);
    bread_ = inverse.matrix;
    hidden_ = inverse.hidden;
    Vector step = bread_ * at.a;
    if (gains_at_ >= 0) {
      // What is linear follows the gains, whose steps are short: both at once would overshoot where the rows
      // say little of a gain.
      auto of_gains = step.tail(n);
      of_gains =
          of_gains.cwiseMax(-most_gain_step * theta_.tail(n)).cwiseMin(most_gain_step * theta_.tail(n));
      theta_.tail(n) += of_gains;
      follow_gains();
    } else {
      theta_ += step;
    }
    // The first step comes from nowhere: its residuals weigh nothing.
    const Vector before = weights_;
    if (iterations_ > 1) {
      for (Index j = 0; j < n; ++j) {
        const double least = least_error * least_error * at.y_squares[j];
        weights_[j] =
            at.y_squares[j] > 0.0 ? std::sqrt(at.counts[j] / std::max(at.squares[j], least)) : weights_[j];
      }
    }
    const Vector sigma = bread_.diagonal().cwiseSqrt();
    settled = iterations_ > 3 && (step.array().abs() <= settled_step * sigma.array()).all() &&
              ((weights_ - before).array().abs() <= settled_step * before.array()).all();
    if (!theta_.allFinite()) {
      return false;
    }
  }
  --iterations_;
  return settled;
}

void PayloadFit::add_scores(std::size_t log, const TimeIntervals& intervals, const TimeBlocks& time_blocks,
                            Matrix& series, std::vector<BlockSums>& blocks) const {
  for (const PayloadRows& rows : logs_[log].joints) {
    const double w = weights_[static_cast<Index>(rows.joint)];
    const Tangent t = tangent(logs_[log], rows);
    const Vector leverage = (w * w * (t.J * bread_).cwiseProduct(t.J).rowwise().sum());
    // A row draws the estimate towards itself.
    const Vector rho = t.rho.array() / (1.0 - leverage.array().min(most_leverage_of_row));
    for (Index k = 0; k < rho.size(); ++k) {
      series.row(intervals.of(log, rows.samples[static_cast<std::size_t>(k)])) += w * w * rho[k] * t.J.row(k);
    }
    time_blocks.divide(log, rows.samples, [&](Index at, Index first, Index count) {
      BlockSums& block = blocks[static_cast<std::size_t>(at)];
      const auto J = t.J.middleRows(first, count);
      block.Z_rho += w * w * (J.transpose() * rho.segment(first, count));
      add_gram(block.ZW, J, w * w);
    });
  }
}

Uncertainty PayloadFit::uncertainty() const {
  const CovarianceOptions& options = problem_.covariance;
  const Index p = theta_.size();
  std::vector<Duration> lasting;
  double stride = 0.0;
  for (const PayloadLog& log : logs_) {
    lasting.push_back({log.samples, log.f_m});
    stride = std::max(stride, static_cast<double>(log.stride) / log.f_m);
  }
  const TimeIntervals intervals(lasting, stride);
  const TimeBlocks time_blocks(lasting, blocks_of_time);
  std::vector<Matrix> series;
  std::vector<BlockSums> blocks(static_cast<std::size_t>(time_blocks.count()),
                                {Matrix::Zero(p, p), Vector::Zero(p)});
  for (std::size_t l = 0; l < logs_.size(); ++l) {
    series.emplace_back(Matrix::Zero(intervals.count(l), p));
    add_scores(l, intervals, time_blocks, series.back(), blocks);
  }
  for (BlockSums& block : blocks) {
    block.ZW.triangularView<Eigen::StrictlyUpper>() = block.ZW.transpose();
  }
  Uncertainty out =
      hac_covariance(series, intervals.seconds(), bread_, options, static_cast<double>(freedom()));
  if (resolved(options.kind, Convention::standard) == CovarianceKind::blocks) {
    scale_to_blocks(blocks, bread_, out);
  }
  out.C += bread_ * known().A * bread_;
  return out;
}

}  // namespace rivid::detail
