#pragma once

#include <span>
#include <vector>

#include "identify/infer/covariance.hpp"
#include "identify/payload/payload_rows.hpp"
#include "rivid/identify/payload.hpp"

namespace rivid::detail {

enum class PayloadShape {
  none,   // no log has a payload
  point,  // first moments and mass
  body    // ten parameters
};

// The unknowns θ = [χ, π, Fl, r] of arm, payload, friction by load and relative inverse gains, and the fit of them.
class PayloadFit {
 public:
  PayloadFit(const Robot& robot, const PayloadColumns& columns, std::span<const PayloadLog> logs,
             const PayloadOptions& options, PayloadShape shape);

  // Gauss-Newton with the weights of the joints in turn. Returns whether it settled.
  bool solve();

  // Covariance of θ from the residuals, with what is known of gains and mass beforehand.
  [[nodiscard]] Uncertainty uncertainty(const CovarianceOptions& options) const;

  [[nodiscard]] const Vector& theta() const { return theta_; }
  [[nodiscard]] Vector chi() const { return theta_.head(b_); }
  // Fl of each joint.
  [[nodiscard]] Vector load_friction() const;
  // XX … M of the payload in the last link's frame for some π.
  [[nodiscard]] Inertial body(const Eigen::Ref<const Vector>& pi) const;
  [[nodiscard]] Index payload_at() const { return b_; }
  [[nodiscard]] Index payload_size() const {
    return shape_ == PayloadShape::none ? 0 : shape_ == PayloadShape::point ? 4 : inertial_count;
  }
  // Where r begins; −1 where gains are exact.
  [[nodiscard]] Index gains_at() const { return gains_at_; }
  // Whether the data determine all unknowns.
  [[nodiscard]] bool full_rank() const { return rank_ == theta_.size(); }
  [[nodiscard]] double relative_error() const { return relative_error_; }
  [[nodiscard]] Index rows() const { return rows_; }
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  // Slopes of the rows and their residuals.
  struct Tangent {
    Matrix J;
    Vector rho;
  };
  // JᵀΩJ and JᵀΩρ with what is known beforehand, and sums over the rows of each joint.
  struct Normal {
    Matrix A;
    Vector a;
    Vector squares;  // of ρ
    Vector counts;
    Vector y_squares;
  };
  [[nodiscard]] Normal normal() const;
  // Moves all unknowns but the gains to where they are best with these.
  void follow_gains();
  [[nodiscard]] Tangent tangent(const PayloadLog& log, const PayloadRows& rows, const Vector& theta) const;
  // Adds what is known beforehand to JᵀΩJ and JᵀΩρ.
  void add_known(Matrix& A, Vector& a) const;
  [[nodiscard]] Matrix known() const;
  struct Inverse {
    Matrix matrix;  // zero along what A does not show
    Index rank = 0;
  };
  [[nodiscard]] static Inverse inverse_information(const Matrix& A);

  const PayloadColumns& columns_;
  std::span<const PayloadLog> logs_;
  const PayloadOptions& options_;
  PayloadShape shape_;
  Index b_;
  std::vector<Index> load_at_;       // of each joint, where Fl stands; −1: none
  std::vector<Index> sign_at_;       // of each joint, the column of Fc
  std::vector<std::uint8_t> rigid_;  // of PayloadColumns::all
  Index gains_at_ = -1;
  Vector theta_;
  Vector weights_;
  Matrix bread_;
  Index rank_ = 0;
  double relative_error_ = 0.0;
  Index rows_ = 0;
  int iterations_ = 0;
};

}  // namespace rivid::detail
