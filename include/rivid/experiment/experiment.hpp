#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/friction_choice.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/references.hpp"

namespace rivid {

/// The controller of an experiment, [control]: its law, and how it is sampled. A simulation runs it, and the
/// auxiliary loop of the instrumental variables (3.4 of [RIV]) is made of it.
struct ControlLoop {
  /// Positions that design inertias (38) are the maximum over.
  enum class InertiaOver {
    reference,  ///< those of the reference motion, which is what the loop meets
    all         ///< all within the limits
  };

  Control control;
  Sampling sampling;
  std::map<std::string, double> gain_sigma;  ///< of gains that are estimated, see Iv
  double delay_sigma = 0.0;                  ///< [periods]
  InertiaOver design_inertia = InertiaOver::reference;
  /// Whether law and gains are a guess, by a bandwidth, rather than those known of the actual controller.
  bool assumed = false;
  Vector omega_n;  ///< natural frequencies that the law is given by, (n); empty: it is given by gains [rad/s]

  template <typename C = ControlLoop>
  static constexpr auto fields() {
    return std::tuple(
        Field{"design_inertia", &C::design_inertia,
              "design inertias (38): the largest M_jj over the positions of the `\"reference\"`, or over "
              "`\"all\"` positions within the limits"},
        Field{"assumed", &C::assumed, "law and gains are a guess, which the summary says"},
        Field{"gain_sigma",
              &C::gain_sigma,
              "relative standard deviation of gains that [output error](control.md#unknown-gains-and-delay) "
              "estimates: `{ K_p = 0.1 }`",
              {.otherwise = "known", .unit = "1", .range = gain_sigma_range}},
        Field{"delay_sigma",
              &C::delay_sigma,
              "standard deviation of a `delay` that it estimates",
              {.otherwise = "known", .unit = "periods", .range = Range::from(0.0, 1e6)}});
  }

  /// Design inertias J (38) that the gains of `control` are matched to, (n) [kg·m² | kg].
  ///
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError, NumericsError  as design_inertia()
  [[nodiscard]] Vector inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q_r) const;
};

template <>
inline constexpr std::array names_of<ControlLoop::InertiaOver> =
    std::to_array<std::string_view>({"reference", "all"});

/// Reference columns of a file.
struct LoggedMotion {
  enum class Interpolation {
    spline,  ///< LoggedReference
    linear   ///< LinearReference
  };

  LogOptions columns;
  Interpolation interpolation = Interpolation::spline;

  static constexpr std::string_view word = "logged";  ///< that files name it by
  template <typename L = LoggedMotion>
  static constexpr auto fields() {
    return std::tuple(
        Field{"file",
              Key<std::filesystem::path>(),
              "file with the reference columns",
              {.otherwise = "the first of `[log]`"}},
        Field{
            "position",
            [](const L& l) { return l.columns.reference; },
            "its columns, as in [`[log]`](experiment.md#columns-and-units); with `file`, like the next three",
            {.otherwise = "`qref1`, …", .unit = "rad, m"}},
        Field{"time",
              [](const L& l) { return l.columns.time; },
              "time stamps",
              {.otherwise = "`t`, else `time`", .unit = "s"}},
        Field{"rate_hz",
              [](const L& l) { return l.columns.rate_hz; },
              "rate of its rows",
              {.otherwise = "from the stamps", .unit = "Hz", .range = rate_range}},
        Field{"units", Key<UnitNames>(), "of `position` and `time`", {.otherwise = "all SI"}},
        Field{"interpolation", &L::interpolation,
              "`\"spline\"`: cubic, twice continuously differentiable; `\"linear\"`: joined by lines"});
  }
};
template <>
inline constexpr std::array names_of<LoggedMotion::Interpolation> =
    std::to_array<std::string_view>({"spline", "linear"});

/// The motion that a simulated robot is asked for, [reference].
struct ReferenceSource {
  std::variant<LoggedMotion, FourierSeries, PointToPoint> motion;
  /// File with the reference (columns or Fourier coefficients). Empty where the experiment file defines the
  /// motion itself; a logged one without it is that of the first log.
  std::filesystem::path file;
};

/// What is simulated, [simulation].
struct SimulationPlan {
  /// Control signals added behind the controller, one row a control period.
  struct AddedControl {
    std::filesystem::path file;
    std::vector<Column> columns;

    template <typename A = AddedControl>
    static constexpr auto fields() {
      constexpr std::string_view named = "must name file and columns";
      return std::tuple(Field{"file",
                              &A::file,
                              "one row a control period, or a sample where the law is continuous",
                              {.required = named}},
                        Field{"columns",
                              &A::columns,
                              "as in [`[log]`](experiment.md#columns-and-units)",
                              {.required = named}});
    }
  };
  /// Series that the log may hold beside time and positions.
  enum class Recorded { torque, control, reference, reference_velocity };
  /// Those that it holds.
  struct Columns {
    bool torque = false;
    bool control = true;
    bool reference = true;
    bool reference_velocity = false;

    template <typename R = Columns>
    static constexpr auto fields() {
      return std::tuple(Field{"record", [](const R& c) { return c.recorded(); },
                              "columns beside `t` and `q`: `\"torque\"` (tau), `\"control\"` (v), "
                              "`\"reference\"` (qref), `\"reference_velocity\"` (qdref)"});
    }
    [[nodiscard]] std::vector<Recorded> recorded() const;
  };

  std::filesystem::path parameters;  ///< see read_parameters(); empty: the a-priori values of the robot
  double duration = 0.0;             ///< 0: that of the reference [s]
  /// `samples`, `sampling`, `added_control` and `noise` are set by run_simulation(); values here are ignored.
  SimulationOptions options;
  NoiseOptions noise;
  std::optional<AddedControl> added_control;
  Columns columns;

  template <typename S = SimulationPlan>
  static constexpr auto fields() {
    return std::tuple(
        Field{"parameters", shown_key<std::filesystem::path>([](const S& s) {
                return s.parameters.empty() ? "a_priori" : s.parameters.string();
              }),
              "the `\"a_priori\"` values of URDF and `[robot.joints]`, or a [parameter "
              "file](simulation.md#parameter-files)"},
        Field{"duration",
              &S::duration,
              "of the log",
              {.otherwise = "that of the reference", .unit = "s", .range = Range::above(0.0, 1e9)}},
        Field{"added_control",
              &S::added_control,
              "control signals added behind the controller and its saturation, see below",
              {.otherwise = "none"}},
        embedded(&S::options), embedded(&S::noise), embedded(&S::columns));
  }
};
template <>
inline constexpr std::array names_of<SimulationPlan::Recorded> =
    std::to_array<std::string_view>({"torque", "control", "reference", "reference_velocity"});

/// Log files of one experiment and what is done to each on the way in.
struct LogSource {
  /// A torque known as a table over a joint's position, taken off the measured one.
  struct Subtraction {
    Index joint = 0;  ///< counted from 0
    std::filesystem::path table;
    std::vector<std::string> columns;  ///< position and torque; empty: the file has just these two
    Outside outside = Outside::refuse;

    template <typename S = Subtraction>
    static constexpr auto fields() {
      constexpr std::string_view named = "must name joint and table";
      return std::tuple(Field{"joint",
                              shown_key<std::string>([](const S& s) { return s.joint + 1; }),
                              "name of the joint",
                              {.required = named}},
                        Field{"table",
                              &S::table,
                              "text file with positions, which must increase, and torques, in SI units",
                              {.required = named}},
                        Field{"columns",
                              &S::columns,
                              "names of its columns of positions and torques",
                              {.otherwise = "the file's only two"}},
                        Field{"outside", &S::outside,
                              "for a position that the table does not cover: `\"refuse\"`, or `\"hold\"` the "
                              "value at its end"});
    }
  };
  /// A file of its own for the reference motion.
  struct Reference {
    std::filesystem::path file;
    LogOptions columns;
    double delay = 0.0;  ///< of the log behind the reference [s]
    Outside outside = Outside::refuse;

    template <typename R = Reference>
    static constexpr auto fields() {
      return std::tuple(
          Field{"file", &R::file, "file with the reference", {.required = "must name its file"}},
          Field{"position",
                [](const R& r) { return r.columns.reference; },
                "reference positions",
                {.otherwise = "those of `reference`", .unit = "rad, m"}},
          Field{"velocity",
                [](const R& r) { return r.columns.reference_velocity; },
                "reference velocities",
                {.otherwise = "those of `reference_velocity`", .unit = "rad/s, m/s"}},
          Field{"time",
                [](const R& r) { return r.columns.time; },
                "time stamps",
                {.otherwise = "`t`, else `time`", .unit = "s"}},
          Field{"rate_hz",
                [](const R& r) { return r.columns.rate_hz; },
                "rate of its rows",
                {.otherwise = "from the stamps", .unit = "Hz", .range = rate_range}},
          Field{"units", Key<UnitNames>(), "of `position`, `velocity` and `time`", {.otherwise = "all SI"}},
          Field{"delay",
                &R::delay,
                "delay of the log behind the reference",
                {.unit = "s", .range = Range::within(-1e9, 1e9)}},
          Field{"outside", &R::outside,
                "for samples that the file does not cover: `\"refuse\"`, or `\"hold\"`: the reference stands "
                "still"});
    }
  };

  /// Where the floating base is in the world: the frame of its link, by its position or by an accelerometer
  /// on it, and its orientation.
  struct BasePose {
    std::vector<Column> position;      ///< x, y, z [m]
    std::vector<Column> acceleration;  ///< specific force, R^T (a − g), in the frame of the link [m/s²]
    std::vector<Column> orientation;   ///< quaternion w, x, y, z, or roll, pitch, yaw [rad]
    Eigen::Vector3d imu = Eigen::Vector3d::Zero();  ///< place of the accelerometer on the link [m]

    template <typename B = BasePose>
    static constexpr auto fields() {
      return std::tuple(
          Field{"position",
                [](const B& b) { return b.position; },
                "x, y, z of the root link in the world; either these or `acceleration`",
                {.otherwise = "–", .unit = "m"}},
          Field{"acceleration",
                [](const B& b) { return b.acceleration; },
                "three axes of an accelerometer along those of the root link, which shows +g upwards at rest",
                {.otherwise = "–", .unit = "m/s²"}},
          Field{"imu", &B::imu, "place of the accelerometer on the root link", {.unit = "m"}},
          Field{"orientation",
                [](const B& b) { return b.orientation; },
                "quaternion w, x, y, z, or roll, pitch, yaw: link to world",
                {.unit = "rad", .required = "must name the columns of orientation"}});
    }
  };
  /// A measured wrench of the environment on a link.
  struct Contact {
    enum class Frame { link, world };

    std::string link;
    std::vector<Column> wrench;                    ///< force, or force and moment about `at` [N, N·m]
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< where the force acts, in the frame of the link [m]
    Frame frame = Frame::link;                     ///< of the components

    template <typename C = Contact>
    static constexpr auto fields() {
      constexpr std::string_view named = "must name link and wrench";
      return std::tuple(Field{"link", &C::link, "moving link that is touched", {.required = named}},
                        Field{"wrench",
                              [](const C& c) { return c.wrench; },
                              "force on the link, or force and moment about `at`: 3 or 6 columns",
                              {.unit = "N, N·m", .required = named}},
                        Field{"at", &C::at, "where the force acts, in the frame of the link", {.unit = "m"}},
                        Field{"frame", &C::frame, "axes of the wrench: `\"link\"` or `\"world\"`"});
    }
  };

  /// Side of the gears that angles and torques of the files belong to; see joint_side().
  enum class Side { joint, motor };

  /// What the recorded torques do not hold.
  enum class Without {
    nothing,
    gravity  ///< some drivers take the weight off: the robot then has none
  };

  std::vector<std::filesystem::path> files;
  LogOptions columns;
  /// Law with known gains whose signals stand in for those of a log that has neither torques nor control
  /// signals; empty: such a log is refused.
  Control law = {};
  Sampling sampling = {};  ///< of that law
  Side side = Side::joint;
  Without torque_without = Without::nothing;
  Irregular irregular = Irregular::refuse;
  ResampleOptions resample;
  double torque_lag = 0.0;  ///< see shift_torque() [samples]
  std::vector<Subtraction> subtract;
  std::optional<Reference> reference;
  std::optional<BasePose> base;  ///< of a floating base
  std::vector<Contact> contact;

  template <typename L = LogSource>
  static constexpr auto fields() {
    return std::tuple(
        Field{"files",
              &L::files,
              "one log or several. Their rows are stacked: one fit for all.",
              {.required = "must name at least one file in files"}},
        Field{"side", &L::side,
              "`\"joint\"`, or `\"motor\"`: the files hold motor quantities, which `gear_matrix` or "
              "`gear_ratio` turn"},
        Field{"torque_without", &L::torque_without,
              "`\"gravity\"`: the torques are without gravity, and so is the model; "
              "`\"nothing\"`"},
        Field{"irregular", &L::irregular,
              "irregular time stamps: `\"refuse\"`, `\"resample\"`, `\"ignore\"`, see [below](#time-stamps)"},
        Field{"torque_lag",
              &L::torque_lag,
              "delay of the recorded torques, see [below](#torque_lag)",
              {.unit = "samples", .range = Range::within(-1e9, 1e9)}},
        Field{"subtract",
              [](const L& l) { return l.subtract; },
              "known torques to subtract, see [below](#subtract)",
              {.otherwise = "–"}},
        Field{"reference_file",
              [](const L& l) { return l.reference; },
              "the reference from a file of its own, see [below](#logreference_file)",
              {.otherwise = "–"}},
        Field{"base",
              [](const L& l) { return l.base; },
              "pose of a floating base, see [below](#logbase)",
              {.otherwise = "–"}},
        Field{"contact",
              [](const L& l) { return l.contact; },
              "measured wrenches on links, see [below](#logbase)",
              {.otherwise = "–"}},
        Field{"units",
              Key<UnitNames>(),
              "unit of each quantity, see [below](#columns-and-units)",
              {.otherwise = "all SI"}},
        embedded(&L::columns), embedded(&L::resample));
  }
};
template <>
inline constexpr std::array names_of<LogSource::Side> = std::to_array<std::string_view>({"joint", "motor"});
template <>
inline constexpr std::array names_of<LogSource::Contact::Frame> =
    std::to_array<std::string_view>({"link", "world"});
template <>
inline constexpr std::array names_of<LogSource::Without> =
    std::to_array<std::string_view>({"nothing", "gravity"});

/// What an experiment file is read for, which decides the sections that it must have.
enum class Use {
  identification,  ///< [robot], [log], [signal]
  simulation       ///< [robot], [control], [reference], [simulation]
};

/// What an experiment file says. docs/experiment.md lists its keys. Sections that are not there leave their
/// members empty.
struct Experiment {
  std::filesystem::path file;
  std::filesystem::path robot_file;                 ///< URDF or modified Denavit-Hartenberg table
  std::vector<std::filesystem::path> robot_tables;  ///< that joints of [[robot.dependent]] follow
  Robot robot;
  LogSource log;
  /// [signal] and [method]. Control and sampling of IDIM-IV are those of [control], which identify_logs()
  /// puts in; threads are no key of the file, since no result depends on them.
  Estimation estimation;
  Iv iv;                 ///< what [method] says of IDIM-IV, whatever method it names; see take_method()
  LogSource validation;  ///< files may be empty
  std::optional<ControlLoop> control;
  std::optional<ReferenceSource> reference;
  std::optional<SimulationPlan> simulation;
  std::optional<GainOptions> gains;            ///< [method] gains, where they are to be estimated
  LogSource loaded;                            ///< logs with the payload of these; files may be empty
  std::vector<FrictionChoice> friction;        ///< that take_friction() made
  std::optional<GainReport> gain_report;       ///< that take_gains() made
  std::map<std::string, std::string> origins;  ///< of the settings that are no defaults: "file", "--set"

  /// Takes another method than the file names, one of method_names.
  ///
  /// @throws InputError  where there is none of that name
  void take_method(std::string_view name);

  /// All files that a use of the experiment reads, itself first.
  [[nodiscard]] std::vector<std::filesystem::path> inputs(Use use = Use::identification) const;
};

/// Reads an experiment file and the robot that it names; logs and parameter files are not opened,
/// coefficients of a Fourier series are. Relative paths in it are relative to the file. All sections are
/// checked, whatever the use.
///
/// @param settings  laid over the file: "signal.decimation=5" is a key and a TOML value; a word needs no
///                  quotes. Messages name them in place of a line of the file.
/// @throws InputError  "file:line:column: …" for TOML that can not be parsed, for unknown keys (with the
///                     nearest one that is known), values of a wrong type or out of range, sections that the
///                     use needs and that are missing; and what the robot's reader refuses
[[nodiscard]] Experiment read_experiment(const std::filesystem::path& path, Use use = Use::identification,
                                         std::span<const std::string> settings = {});

/// A setting as it is used.
struct Setting {
  std::string key;     ///< as an experiment file names it: "signal.cutoff_hz"
  std::string value;   ///< as JSON
  std::string words;   ///< the same for people: "by a rule" where a default is found by one
  std::string unit;    ///< or empty
  std::string origin;  ///< "default", "file", "--set"; empty where there is no file
};

/// What identify() was asked for, [signal], [method] and [control]. Of a control law of one's own nothing is
/// known.
[[nodiscard]] std::vector<Setting> settings(const Estimation& estimation);

/// All settings that a use of an experiment comes down to, defaults included.
[[nodiscard]] std::vector<Setting> settings(const Experiment& experiment, Use use = Use::identification);

/// The logs of a source, on uniform clocks, adjusted as the source says. A file with long gaps becomes
/// several logs.
///
/// @param robot  that the logs belong to; their columns must fit it
/// @throws InputError  for what the readers refuse
[[nodiscard]] std::vector<Log> read_logs(const LogSource& source, const Robot& robot,
                                         const Progress& progress = {});

/// The logs of one run. Each source is read when it is first asked for, and lent to all that need it: choice
/// of friction laws and gains, fit, validation, predictions.
class Reading {
 public:
  /// @param progress  of the run
  explicit Reading(Progress progress = {}) : progress_(std::move(progress)) {}

  /// read_logs() of a source, which stay as long as the reading does.
  ///
  /// @throws InputError  as read_logs() does
  [[nodiscard]] const std::vector<Log>& logs(const LogSource& source, const Robot& robot);

  [[nodiscard]] const Progress& progress() const { return progress_; }
  /// Files that were parsed so far, each counted as often as it was.
  [[nodiscard]] std::size_t files() const { return files_; }

 private:
  Progress progress_;
  std::map<std::string, std::vector<Log>> logs_;  // by what says how they are read
  std::size_t files_ = 0;
};

/// Puts a friction law in the place of each joint's Friction::automatic, by cross-validation on the logs of
/// the experiment: choose_friction(). Without such a joint nothing is read. run() reports the choices in its
/// notes.
///
/// @throws InputError  where logs or options can not be used
void take_friction(Experiment& experiment, Reading& reading);

/// Estimates the drive gains where the experiment asks for it, from its logs and those with a payload:
/// identify_gains(). The robot gets them, and the estimation their covariance; run() reports them. A second
/// call does nothing.
///
/// @throws InputError  where logs or options can not be used
void take_gains(Experiment& experiment, Reading& reading);

/// Identification from given logs by the method of the experiment, validated on others: what run() does once
/// it has read them.
///
/// @throws InputError  where logs or options can not be used
Identification identify_logs(const Experiment& experiment, std::span<const Log> logs,
                             std::span<const Log> validation = {}, const Progress& progress = {});

/// Identification and validation as the experiment file asks for.
///
/// @throws InputError  where logs or options can not be used
Identification run(const Experiment& experiment, Reading& reading);
/// The same with a reading of its own.
Identification run(const Experiment& experiment, const Progress& progress = {});

/// Measured and predicted torques of the logs of an experiment: those of the identification, then those of
/// the validation.
struct ShownPredictions {
  std::vector<Prediction> predictions;
  std::vector<std::string> left_out;  ///< logs that are not among them
};

/// What a report shows of the logs within its memory: a sample of a joint takes up to 100 bytes, so that the
/// default is 5 GB.
///
/// @param result   of run() on the same experiment
/// @param reading  of that run, or a new one
/// @param most     samples, counted over joints and logs
/// @throws InputError  where run() throws it
[[nodiscard]] ShownPredictions shown_predictions(const Experiment& experiment, const Identification& result,
                                                 Reading& reading, Index most = 50'000'000);

/// What run_simulation() will do: all files that it reads are read and checked, gains and design inertias are
/// found, and nothing is simulated.
///
/// @throws InputError  as run_simulation() does
[[nodiscard]] SimulationOutlook outlook(const Experiment& experiment);

/// The simulation that the experiment file asks for, and its log. Outcomes that end it early are in the
/// result, with the log up to there.
///
/// @throws InputError  where a file or an option can not be used
SimulationRecord run_simulation(const Experiment& experiment, const Progress& progress = {});

/// check() of the logs of an experiment file, and of its drive gains: where logs have the target currents and
/// target torques of the robot's controller, those of its own model follow (`target_gains`), and a drive_gain
/// of the file that is another is named (`drive_gain_differs`).
///
/// @return            findings, the gravest first
/// @throws InputError  as read_logs() and check() of logs do
[[nodiscard]] std::vector<Finding> check(const Experiment& experiment, int threads = 1);

}  // namespace rivid
