#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Which parameters of a payload are estimated.
enum class PayloadModel {
  automatic,  ///< ten, or four where the motion does not show the inertia
  point,      ///< four are reported: mass and centre of mass
  body        ///< ten, of whose inertia nothing is known beforehand
};

template <>
inline constexpr std::array names_of<PayloadModel> =
    std::to_array<std::string_view>({"automatic", "point", "body"});

/// Logs with one payload.
struct LoadedLogs {
  std::string name = "payload";
  std::span<const Log> logs;
  /// Its mass where it is known, to calibrate the drive gains with [kg]; its standard deviation.
  std::optional<double> mass = {};
  double mass_sigma = 0.0;

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// What is known beside the logs when payloads are identified.
struct PayloadOptions {
  PayloadModel model = PayloadModel::automatic;
  /// The moving link that the payload is on; empty: the last one of a chain.
  std::string link = {};
  /// Pose of the flange frame in the frame of that link, in which the result is given: orientation and
  /// origin [m].
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  /// Relative standard deviation of each joint's drive gain, (n): 0, it is exact; infinite, nothing is known
  /// of it and it is estimated. Empty: what IdentifiedArm::gain_covariance says; without it 1 % each.
  Vector gain_sigma = {};
  /// Whether dry friction grows with the load of the gear, (Fc + Fl |M q̈ + N|) sign q̇, where a joint has
  /// Fc.
  bool load_friction = false;

  /// `link` among those of the robot, counted from 0; nothing where it is none of them, or none is named and
  /// the robot branches.
  [[nodiscard]] std::optional<std::size_t> link_of(const Robot& robot) const;
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;
};

/// One number of a payload.
struct PayloadValue {
  std::string name;  ///< "mass", "com_x" … "com_z", "Ixx" … "Iyz"
  std::string unit;
  double value = 0.0;
  double sigma = 0.0;  ///< standard deviation
  std::array<double, 2> interval_95 = {0.0, 0.0};
};

/// A payload in the flange frame, with intervals that carry what is not known of the arm and of its gains.
struct Payload {
  std::string name;    ///< of the LoadedLogs; of a difference "b - a"
  std::string reason;  ///< why its inertia is not reported, or of a difference its centre of mass
  PayloadModel model = PayloadModel::body;            ///< that is reported: body or point
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< centre of mass [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, axes of the flange
                                                      ///< [kg·m²]; of a point a usual one
  std::vector<PayloadValue> values;  ///< mass, com_x, com_y, com_z, and of a body Ixx Iyy Izz Ixy Ixz Iyz
  /// What of its logs is not explained by arm and payload, by joint, (n) [N·m | N].
  Vector sigma_rho;
  /// Masses below it can not be told from none [kg]: four deviations, or what a tenth of that rest weighs on
  /// the last link.
  double least_mass = 0.0;
  /// Whether the logs show a load and not its mass, as those of a wrist alone do: only that is reported.
  bool unweighed = false;

  /// Whether there is none that the logs show: its mass is below `least_mass`, then only that is reported.
  [[nodiscard]] bool none() const;
};

/// Payloads from one fit, the answer of identify_payloads().
struct [[nodiscard]] PayloadReport {
  bool identified = false;  ///< whether the logs determine all of it, and examine() found nothing against it
  bool doubtful = false;    ///< whether examine() found reasons not to trust it
  std::string reason;       ///< why it is not identified
  std::vector<Finding> warnings;     ///< of examine(): what may make it wrong, the gravest first
  std::vector<Payload> payloads;     ///< one a LoadedLogs; empty where the fit did not settle
  std::vector<Payload> differences;  ///< of each payload from each before it: what was added to that one
  std::vector<GainEstimate> gains;   ///< where the gains are not exact
  Vector gain_sigma;                 ///< relative deviations of what was known of them, (n)
  Vector Fl;                         ///< friction by load of each joint, (n) [1]; zero where it has none
  Vector chi;                        ///< base parameters of the arm without friction by load, (b)
  double relative_error = 0.0;       ///< ‖Y − Ŷ‖ / ‖Y‖ over all rows
  Index rows = 0;
  int iterations = 0;
  CovarianceReport covariance;
  SignalOptions signal;  ///< that made the rows
};

/// Identifies payloads from logs of the arm without and with them: one fit of all rows, with common
/// parameters of the arm and ten columns of a body on the last link in the rows with a payload, weighted
/// joint by joint. But for PayloadModel::body its inertia about the centre of mass is known to be m (0.1 m)²,
/// as well as that is large, so that what the motion does not show of it is in all intervals. Gauss-Newton,
/// for unknown gains and friction that follows the load are not linear: with the relative inverse gain r_j of
/// each joint,
///
///   y_j = r_j (W_j χ + L_j λ),   K_j = nominal_j / r_j.
///
/// Noise is in the torques: currents as regressors would bias the gains. Without a known mass and without any
/// known gain only their ratios are identifiable; that is refused.
///
/// @param without  logs of the arm alone, at least one
/// @param with     logs with payloads, at least one of each
/// @param estimation  signal and covariance; the method is weighted least squares
/// @throws InputError  where robot, logs and options do not fit together
PayloadReport identify_payloads(const Robot& robot, std::span<const Log> without,
                                std::span<const LoadedLogs> with, const Estimation& estimation,
                                const PayloadOptions& options = {});

/// An arm as it was identified before, in place of logs without payload.
struct IdentifiedArm {
  Robot robot;             ///< with the drive gains that were used
  Vector chi;              ///< its base parameters, base_parameters(robot), (b)
  Matrix C_chi;            ///< their covariance, with what gain_covariance adds, (b × b)
  Matrix gain_slopes;      ///< Identification::gain_slopes, (b × n)
  Matrix gain_covariance;  ///< relative covariance of the gains, (n × n); empty: not known

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// The arm of a result. read_identified_arm() reads it from a result.json.
///
/// @param robot  whose drive gains are those that were used, see with_gains()
/// @throws InputError  where the result is not identified
[[nodiscard]] IdentifiedArm identified_arm(const Robot& robot, const Identification& result);

/// The same as above with what is known of the arm in place of logs: its parameters count as a measurement
/// with their covariance, and what gains that are not exact do to them is in the fit.
PayloadReport identify_payloads(const IdentifiedArm& arm, std::span<const LoadedLogs> with,
                                const Estimation& estimation, const PayloadOptions& options = {});

/// Judges payloads, as examine() judges a result: the logs without payload and those with each of them are
/// identified and examined by themselves, an arm with a payload being another arm; and what arm and payload
/// together leave of the torques of a joint is compared with what that leaves. A finding of severity error,
/// and a negative mass, make the report `doubtful`.
///
/// @param without     logs of the arm alone; none on an arm that was identified before
/// @param estimation  as identify_payloads() had it
/// @throws InputError  where logs can not be identified from
void examine(const Robot& robot, std::span<const Log> without, std::span<const LoadedLogs> with,
             const Estimation& estimation, PayloadReport& found);

/// Why no controller should be told a payload: the report is not identified, the mass is negative or none;
/// empty: it may be told.
[[nodiscard]] std::string untold_reason(const PayloadReport& found, const Payload& payload);

/// URScript: set_target_payload(m, [com], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]).
[[nodiscard]] std::string urscript_line(const Payload& payload);
/// libfranka: robot.setLoad(mass, {com}, {inertia, column by column}).
[[nodiscard]] std::string libfranka_line(const Payload& payload);

}  // namespace rivid
