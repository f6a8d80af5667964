#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/references.hpp"

namespace rivid {

/// The controller of an experiment, [control]: its law, and how it is sampled. A simulation runs it, and the auxiliary
/// loop of the instrumental variables (3.4 of [RIV]) is made of it.
struct ControlLoop {
  /// Positions that design inertias (38) are the maximum over.
  enum class InertiaOver {
    reference,  ///< those of the reference motion, which is what the loop meets
    all         ///< all within the limits
  };

  Control control;
  Sampling sampling;
  InertiaOver design_inertia = InertiaOver::reference;
  /// Whether law and gains are a guess, by a bandwidth, rather than those known of the actual controller.
  bool assumed = false;
  Vector omega_n;  ///< natural frequencies that the law is given by, (n); empty: it is given by gains [rad/s]

  /// Design inertias J (38) that the gains of `control` are matched to, (n) [kg·m² | kg].
  ///
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError, NumericsError  as design_inertia()
  [[nodiscard]] Vector inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q_r) const;
};

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

/// Log files of one experiment and what is done to each on the way in.
struct LogSource {
  /// A torque known as a table over a joint's position, taken off the measured one.
  struct Subtraction {
    Index joint = 0;  ///< counted from 0
    std::filesystem::path table;
    std::vector<std::string> columns;  ///< position and torque; empty: the file has just these two
    Outside outside = Outside::refuse;
  };
  /// A file of its own for the reference motion.
  struct Reference {
    std::filesystem::path file;
    LogOptions columns;
    double delay = 0.0;  ///< of the log behind the reference [s]
    Outside outside = Outside::refuse;
  };

  /// Which side of the gears angles and torques of the files are told on; see joint_side().
  enum class Side { joint, motor };

  std::vector<std::filesystem::path> files;
  LogOptions columns;
  Side side = Side::joint;
  Irregular irregular = Irregular::refuse;
  ResampleOptions resample;
  double torque_lag = 0.0;  ///< see shift_torque() [samples]
  std::vector<Subtraction> subtract;
  std::optional<Reference> reference;
};

/// What an experiment file is read for, which tells the sections that it must have.
enum class Use {
  identification,  ///< [robot], [log], [signal]
  simulation       ///< [robot], [control], [reference], [simulation]
};

/// What an experiment file says. docs/experiment.md lists its keys. Sections that are not there leave their members empty.
struct Experiment {
  std::filesystem::path file;
  std::filesystem::path robot_file;  ///< URDF or modified Denavit-Hartenberg table
  Robot robot;
  LogSource log;
  /// [signal] and [method]. Control and sampling of IDIM-IV are those of [control], which identify_logs() puts in; threads
  /// are no key of the file, since no result depends on them.
  Estimation estimation;
  Iv iv;                 ///< what [method] says of IDIM-IV, whatever method it names; see take_method()
  LogSource validation;  ///< files may be empty
  std::optional<ControlLoop> control;
  std::optional<ReferenceSource> reference;
  std::optional<SimulationPlan> simulation;

  /// Takes another method than the file names: "ols", "wls" or "iv".
  ///
  /// @throws InputError  where there is none of that name
  void take_method(std::string_view name);

  /// All files that a use of the experiment reads, itself first.
  [[nodiscard]] std::vector<std::filesystem::path> inputs(Use use = Use::identification) const;
};

/// Reads an experiment file and the robot that it names; logs and parameter files are not opened, coefficients of a
/// Fourier series are. Relative paths in it are relative to the file. All sections are checked, whatever the use.
///
/// @throws InputError  "file:line:column: …" for TOML that can not be parsed, for keys that nobody knows (with the
///                     nearest one that is known), values of a wrong type or out of range, sections that the use needs
///                     and that are missing; and what the robot's reader refuses
[[nodiscard]] Experiment read_experiment(const std::filesystem::path& path, Use use = Use::identification);

/// The logs of a source, on uniform clocks, adjusted as the source says. A file with long gaps becomes several logs.
///
/// @param robot  that the logs belong to; their columns must fit it
/// @throws InputError  for what the readers refuse
[[nodiscard]] std::vector<Log> read_logs(const LogSource& source, const Robot& robot,
                                         const Progress& progress = {});

/// Identification from given logs by the method of the experiment.
///
/// @throws InputError  where logs or options can not be used
Identification identify_logs(const Experiment& experiment, std::span<const Log> logs,
                             const Progress& progress = {});

/// Identification and validation as the experiment file asks for.
///
/// @throws InputError  where logs or options can not be used
Identification run(const Experiment& experiment, const Progress& progress = {});

/// Measured and predicted torques of the logs of an experiment, which are read again: those of the identification, then
/// those of the validation.
///
/// @param result  of run() on the same experiment
/// @throws InputError  where run() throws it
[[nodiscard]] std::vector<Prediction> predictions(const Experiment& experiment, const Identification& result);

/// What run_simulation() will do: all files that it reads are read and checked, gains and design inertias are found, and
/// nothing is simulated.
///
/// @throws InputError  as run_simulation() does
[[nodiscard]] SimulationOutlook outlook(const Experiment& experiment);

/// The simulation that the experiment file asks for, and its log. Outcomes that end it early are in the result, with the
/// log up to there.
///
/// @throws InputError  where a file or an option can not be used
SimulationRecord run_simulation(const Experiment& experiment, const Progress& progress = {});

}  // namespace rivid
