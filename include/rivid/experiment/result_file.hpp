#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rivid/identify/comparison.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/online/model.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// Values for the parameters of a robot, by their names: all its base parameters ("ZZ1R", "Fv1", …) or all
/// its standard parameters ("XX1", …, "M1", "Fv1", …).
///
/// The ending of the file's name decides its format:
///   .json  result.json of rivid identify or simulation.json of rivid simulate: a list `parameters` of
///          objects with name and value; or an object, itself or its member `parameters`, from names to
///          values, each a number or an object with a value
///   .toml  names = values, in the table [parameters] or at the top
///   .csv   a header with the columns name and value; others are not looked at
///
/// @return  chi_st, (N_s), with the values asked for; base parameters stand in the places of the leading ones
/// @throws InputError  where the file can not be read; for a name that the robot does not have, with the
///                     nearest one that it has; a name twice; a value that is missing, null or not finite;
///                     names that are neither all base nor all standard parameters
[[nodiscard]] Vector read_parameters(const std::filesystem::path& path, const BaseParameters& base);

/// What result.json says of a robot, and of where its numbers come from.
struct IdentifiedRobot {
  Robot robot;    ///< geometry, gravity and friction laws of the result; without a-priori values
  Vector chi_st;  ///< values of robot.standard_parameters(), (N_s) [SI, joint side]
  /// Physical: chi_st are those of physically consistent bodies. Else base parameters stand in the places of
  /// the leading standard ones, which gives the same torques.
  ParameterSet parameters = ParameterSet::estimate;
  std::string method;  ///< "wls", …
  std::string status;  ///< "identified", …
  std::string run;     ///< run_id() of the result; empty where the file does not say
  /// A file that the result was made from, as it was named then.
  struct Source {
    std::filesystem::path path;
    std::string sha256;
  };
  std::vector<ParameterValue> estimates;  ///< base parameters as they were estimated, whichever set chi_st is
  SignalOptions signal;                   ///< that made its rows
  std::optional<Source> experiment;       ///< the experiment file
  std::optional<Source> urdf;             ///< the URDF, where the robot comes from one
};

/// The robot of a result.json; see read_identified_model() for which numbers are taken and what is refused.
///
/// @throws InputError  as read_identified_model()
[[nodiscard]] IdentifiedRobot read_identified_robot(const std::filesystem::path& path,
                                                    const IdentifiedModelOptions& options = {});

/// A result.json as its identification was, but for what only its logs show: predictions, weights of rows and
/// the steps of a method on its way are not read. The robot has no a-priori values.
///
/// @param text    content of the file
/// @param source  that messages name it by
/// @throws InputError  "file: member …" for a text that is none
[[nodiscard]] std::pair<Robot, Identification> result_of(std::string_view text, const std::string& source);

/// The identified robot of a result.json, all that a controller needs, in one call:
///
///   InverseDynamics dynamics(read_identified_model("my_robot_result/result.json"),
///                            {.smoothing_speed = Vector::Constant(6, 0.01)});
///
/// Geometry, gravity and friction laws are in the file beside the numbers, so that none of them can be
/// another's. Where the file has physically consistent parameters these are taken, see
/// IdentifiedModelOptions. The torques are those of the result to rounding, save friction that would drive,
/// see DynamicModel::clamped().
///
/// @param path  of a result.json that rivid identify or to_json() wrote
/// @throws InputError  "file: member …" for a file that can not be read or is none, for a result that is not
///                     identified (unless options.force), for parameters that are missing, not determined or
///                     not those of the robot, and for a set that is not there
[[nodiscard]] DynamicModel read_identified_model(const std::filesystem::path& path,
                                                 const IdentifiedModelOptions& options = {});

/// The same, for a controller that has read a description of its robot by itself: the result must be that
/// robot's. Joints are compared by name and type, frames and gravity to 1e-9 m, 1e-9 rad and 1e-9 m/s².
/// Friction laws, rotors and coupled motors are those of the file, whatever `robot` says.
///
/// @throws InputError  as above, and where the result is that of another robot, with the joint and both
///                     values
[[nodiscard]] DynamicModel read_identified_model(const std::filesystem::path& path, const Robot& robot,
                                                 const IdentifiedModelOptions& options = {});

/// The arm of a result.json, for payloads on top of it: the estimate, whatever else the file has, with the
/// friction laws and the drive gains that were used.
///
/// @param robot  as its experiment describes it: geometry must be that of the result
/// @throws InputError  as read_identified_model(); for a result without covariance or `gain_slopes`
[[nodiscard]] IdentifiedArm read_identified_arm(const std::filesystem::path& path, const Robot& robot);

/// What the estimators of a control loop take, of a result: base parameters as they were estimated with their
/// covariance, the deviation of each joint's residual and the speed below which it had no rows.
///
/// @throws InputError  where the result is not identified, or is that of another robot
[[nodiscard]] OnlineModel online_model(const Robot& robot, const Identification& result);

/// The same from a result.json, in one call:
///
///   const OnlineModel model = read_online_model("my_robot_result/result.json");
///   PayloadEstimator<double> payload(model, {.rows = {.f_m = 1000}});
///
/// @throws InputError  "file: member …" for a file that can not be read or is none, and for a result that is
///                     not identified, unless options.force; physically consistent parameters have no
///                     covariance, so that options.parameters is not looked at
[[nodiscard]] OnlineModel read_online_model(const std::filesystem::path& path,
                                            const IdentifiedModelOptions& options = {});

}  // namespace rivid
