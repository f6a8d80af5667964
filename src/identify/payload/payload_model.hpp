#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/infer/covariance.hpp"
#include "identify/rows/time_blocks.hpp"
#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::detail {

// What is known of unknowns θ beforehand, as normal equations: JᵀΩJ and JᵀΩρ of measurements of them.
struct Known {
  Matrix A;
  Vector a;
};

// An arm that was identified before, as a measurement of its parameters:
//
//   χ̂ = χ + Σ_j G_j (1 − 1/r_j) + e,   cov e = C,
//
// G_j the slopes of χ̂ with the gains: weighted least squares are linear in the torques, and those of joint j
// are 1/r_j times what it was estimated from.
class ArmPrior {
 public:
  // places    of each parameter of the arm among the unknowns
  // gains_at  where r begins; −1 where gains are exact
  ArmPrior(const IdentifiedArm& arm, std::vector<Index> places, Index gains_at);

  void add_to(Known& known, const Vector& theta) const;
  [[nodiscard]] Index size() const { return chi_.size(); }

 private:
  Vector chi_;
  Matrix information_;  // C⁻¹
  Matrix slopes_;       // G
  std::vector<Index> places_;
  Index gains_at_;
};

// Columns of the arm's base parameters, and of those standard parameters of a link that are none of
// them.
struct PayloadColumns : BodyColumns {
  PayloadColumns(const Robot& robot, int link) : PayloadColumns(base_parameters(robot), link) {}
  PayloadColumns(const BaseParameters& of_arm, int link) : BodyColumns(link, of_arm), base(of_arm) {}

  BaseParameters base;  // of the arm, friction by load aside
};

// The rows of one joint from one log.
struct PayloadRows {
  std::size_t joint = 0;
  std::vector<Index> columns;  // of PayloadColumns::all
  Matrix W;
  Vector y;
  std::vector<Index> samples;
};

// The rows of one log.
struct PayloadLog {
  static constexpr Index no_load = -1;  // mark: an arm without payload

  Index load = no_load;  // which of the payloads it has
  double f_m = 0.0;
  Index samples = 0;
  Index stride = 1;
  std::vector<PayloadRows> joints;
};

// All rows of a log, which are held: a payload is identified from minutes.
//
// robot  without friction by load
[[nodiscard]] PayloadLog payload_rows(const Robot& robot, const PayloadColumns& columns, const Log& log,
                                      const SignalOptions& signal, Index load, ThreadTeam& team);

// The rows of logs without and with payloads. Where the signal leaves them open they are chosen by the noise
// of those without, if there are any, else of the first with one; `estimation` has them then.
[[nodiscard]] std::vector<PayloadLog> stacked_rows(const Robot& robot, const PayloadColumns& columns,
                                                   std::span<const Log> without,
                                                   std::span<const LoadedLogs> with, Estimation& estimation);

// Radius of gyration of a usual payload [m]: that of a cube of 24 cm. Its square is taken to be known as well
// as it is large, so that 17 cm are two deviations off.
inline constexpr double usual_gyration = 0.1;

// Rows, and what is known beside them.
struct PayloadProblem {
  struct Load {
    bool usual = true;           // its inertia is about that of a usual body, see usual_gyration
    std::optional<double> mass;  // where it is known, with its deviation
    double mass_sigma = 0.0;
  };

  Robot robot;  // without friction by load
  PayloadColumns columns;
  CovarianceOptions covariance;
  bool load_friction = false;
  std::vector<PayloadLog> logs = {};
  std::vector<Load> loads = {};
  Vector gain_sigma = {};              // (n), what is known of each gain
  Matrix gain_information = {};        // (n × n), of log r; empty: gains are exact
  const IdentifiedArm* arm = nullptr;  // that stands for logs without payload
};

// What relative deviations of the gains say of log r; infinite ones say nothing. Empty where all are exact.
[[nodiscard]] Matrix gain_information(const Vector& sigma);
// The same of a relative covariance.
[[nodiscard]] Matrix gain_information_of(const Matrix& C);

// The unknowns θ = [χ, π_1 … π_K, Fl, r] of arm, payloads, friction by load and relative inverse gains, and
// the fit of them.
class PayloadFit {
 public:
  explicit PayloadFit(const PayloadProblem& problem);

  // Gauss-Newton with the weights of the joints in turn. Returns whether it settled.
  bool solve();

  // Covariance of θ from the residuals, with what is known of gains, masses and arm beforehand.
  [[nodiscard]] Uncertainty uncertainty() const;

  [[nodiscard]] const Vector& theta() const { return theta_; }
  [[nodiscard]] Vector chi() const { return theta_.head(b_); }
  // Fl of each joint.
  [[nodiscard]] Vector load_friction() const;
  // Where π_k, XX … M of payload k in the last link's frame, stands.
  [[nodiscard]] Index payload_at(std::size_t k) const { return payload_at_[k]; }
  // Where r begins; −1 where gains are exact.
  [[nodiscard]] Index gains_at() const { return gains_at_; }
  // Whether the data determine all unknowns, and so many of them from one on.
  [[nodiscard]] bool full_rank() const { return determined(0, theta_.size()); }
  [[nodiscard]] bool determined(Index first, Index count) const {
    constexpr double rounding = 1e-8;  // part of an unknown in the null space; hidden ones are far above
    return hidden_.segment(first, count).maxCoeff() < rounding;
  }
  // Measurements beyond the unknowns, the arm's parameters among them where they are known.
  [[nodiscard]] Index freedom() const {
    return rows_ + (arm_ ? arm_->size() : 0) - static_cast<Index>(theta_.size());
  }
  [[nodiscard]] double relative_error() const { return relative_error_; }
  // What is left of the logs with a payload.
  struct Rest {
    Vector sigma_rho;  // of each joint, (n)
    double mass =
        0.0;  // that weighs as much at the origin of the last link, in the weights of the joints [kg]
    double payload = 0.0;  // its torques over what is left, in the same weights
  };
  [[nodiscard]] Rest rest_with(std::size_t k) const;
  [[nodiscard]] Index rows() const { return rows_; }
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  // Of the columns of a joint's rows.
  struct Columns {
    Vector value;    // their parameters, the payload's own on top of the arm's
    Matrix of_body;  // (rows × 10) those that the payload multiplies
    Index sign;      // the one of Fc; −1: none
  };
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
  void place_load_friction();
  void place_arm();
  [[nodiscard]] Normal normal() const;
  // Moves all unknowns but the gains to where they are best with these.
  void follow_gains();
  [[nodiscard]] Columns columns_of(const PayloadLog& log, const PayloadRows& rows) const;
  [[nodiscard]] Tangent tangent(const PayloadLog& log, const PayloadRows& rows) const;
  // Adds that payload k is a usual body.
  void add_usual_body(std::size_t k, Known& to) const;
  // Adds the scores of a log's rows to the sums over its intervals and over the blocks of all logs.
  void add_scores(std::size_t log, const TimeIntervals& intervals, const TimeBlocks& time_blocks,
                  Matrix& series, std::vector<BlockSums>& blocks) const;
  // What is known beforehand.
  [[nodiscard]] Known known() const;
  struct Inverse {
    Matrix matrix;  // zero along what A does not show
    Vector hidden;  // the part of each unknown's direction that A does not show, squared
  };
  [[nodiscard]] static Inverse inverse_information(const Matrix& A);

  const PayloadProblem& problem_;
  std::span<const PayloadLog> logs_;
  Index b_;
  std::vector<Index> payload_at_;
  std::vector<Index> load_at_;       // of each joint, where Fl stands; −1: none
  std::vector<Index> sign_at_;       // of each joint, the column of Fc
  std::vector<std::uint8_t> rigid_;  // of PayloadColumns::all
  Index gains_at_ = -1;
  std::optional<ArmPrior> arm_;
  Vector theta_;
  Vector weights_;
  Matrix bread_;
  Vector hidden_;
  double relative_error_ = 0.0;
  Index rows_ = 0;
  int iterations_ = 0;
};

// The gains of a fit that has them as unknowns; else none.
[[nodiscard]] std::vector<GainEstimate> gain_estimates(const Robot& robot, const PayloadFit& fit,
                                                       const Uncertainty& uncertainty);

// What a settled fit says of payload k, in the flange frame: of what it does not show only why.
[[nodiscard]] Payload payload_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                 const PayloadOptions& options);

// What payload k has that payload `from` had not, as a body of its own, in the flange frame.
[[nodiscard]] Payload difference_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                    std::size_t from, const PayloadOptions& options);

// What speaks against logs with a payload that a fit has in common with others: examined() by themselves,
// with the gains that were found, and by what that fit leaves of them.
//
// name       of the logs, before the subjects of findings
// sigma_rho  that the common fit leaves of each joint, at nominal gains, (n)
[[nodiscard]] std::vector<Finding> judged_load(const Robot& robot, const std::string& name,
                                               std::span<const Log> logs, const Estimation& estimation,
                                               const std::vector<GainEstimate>& gains,
                                               const Vector& sigma_rho);

// Findings with what they are about before their subjects.
[[nodiscard]] std::vector<Finding> about(const std::string& name, std::vector<Finding> findings);

}  // namespace rivid::detail
