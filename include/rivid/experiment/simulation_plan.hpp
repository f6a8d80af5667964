#pragma once

#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include "rivid/data/csv.hpp"
#include "rivid/simulate/fourier_reference.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/point_to_point_reference.hpp"

namespace rivid {

/// Reference columns of a file.
struct LoggedMotion {
  enum class Interpolation {
    spline,  ///< LoggedReference
    linear   ///< LinearReference
  };

  LogOptions columns;
  Interpolation interpolation = Interpolation::spline;
};

/// The motion that a simulated robot is asked for, [reference].
struct ReferenceSource {
  std::variant<LoggedMotion, FourierSeries, PointToPoint> motion;
  /// That it is read from: columns, or the coefficients of the series. Empty where the experiment file tells the motion
  /// itself; a logged one without it is that of the first log.
  std::filesystem::path file;
};

/// What is simulated, [simulation].
struct SimulationPlan {
  /// Control signals added behind the controller, one row a control period.
  struct AddedControl {
    std::filesystem::path file;
    std::vector<Column> columns;
  };
  /// What the log holds beside time and positions.
  struct Columns {
    bool torque = false;
    bool control = false;
    bool reference = false;
    bool reference_velocity = false;
  };

  std::filesystem::path parameters;  ///< see read_parameters(); empty: the a-priori values of the robot
  double duration = 0.0;             ///< 0: that of the reference [s]
  /// Without what comes from elsewhere: samples, sampling, added control, noise.
  SimulationOptions options;
  NoiseOptions noise;
  std::optional<AddedControl> added_control;
  Columns columns = {.torque = false, .control = true, .reference = true, .reference_velocity = false};
};

}  // namespace rivid
