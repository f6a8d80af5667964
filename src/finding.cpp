#include "rivid/finding.hpp"

#include <algorithm>
#include <array>

namespace rivid {

namespace {

using enum Severity;

constexpr std::array codes = {
    DiagnosticCode{
        "robot_doubt", note, "The robot's description has something doubtful.",
        "The reader of the URDF noticed it: a link without inertial, an inertia that no body has, joints "
        "without limits.",
        "Mend the file where a-priori values matter, as for physically consistent parameters; the estimate "
        "itself uses geometry alone."},
    DiagnosticCode{
        "base_doubt", warning, "It is not clear how many base parameters the robot has.",
        "A column of the regressor is neither clearly independent of the others nor clearly dependent: "
        "axes that are almost, but not quite, parallel or at right angles.",
        "Round the angles and lengths of the geometry to what they are meant to be."},
    DiagnosticCode{"log_note", note, "Something about a log is worth knowing.",
                   "The reader noticed it, or did it to the log.", "Nothing, if it is what you expect."},
    DiagnosticCode{"stated_rate", warning, "The time stamps contradict the stated sampling rate.",
                   "[log] rate_hz is that of another log, or the stamps are in another unit.",
                   "Correct [log] rate_hz, or leave it out where the time stamps are right."},
    DiagnosticCode{"at_rest", error, "No joint moves in any log.",
                   "Every position stays within its noise: the wrong file, the wrong columns, or a robot "
                   "that was not started.",
                   "Check [log] files and position."},
    DiagnosticCode{
        "joint_still", error, "A joint moves in no log.",
        "Its position stays within its noise. Its own inertia and friction, and much of what it carries, "
        "do not show.",
        "Record a motion of that joint as well, or fix the joint in the URDF."},
    DiagnosticCode{"standstill", note, "A joint stands still for a large part of a log.",
                   "Dry friction at rest is whatever it needs to be, so these samples carry no information.",
                   "Cut them off with [signal] window; rows = \"exact\" leaves them out."},
    DiagnosticCode{"position_unit", error, "Positions look as if they were in another unit.",
                   "They leave the limits of the joint, or turn too often, and degrees taken for radians, or "
                   "millimetres for metres, explain that; or the other way round.",
                   "State the unit in [log] units: position = \"deg\" or \"mm\"."},
    DiagnosticCode{"small_motion", warning, "No joint turns by more than a small angle.",
                   "Positions that are radians already, but are read as degrees, look like that.",
                   "Check the unit in [log] units: position."},
    DiagnosticCode{
        "position_limits", warning, "Positions leave the limits of the joint.",
        "The limits of the URDF do not hold for this log: an offset of the zero, another robot, columns in "
        "another order.",
        "Check offsets, signs and order of [log] position against the URDF."},
    DiagnosticCode{"velocity_limit", warning, "A joint moves much faster than the URDF allows.",
                   "The measuring rate is wrong, or positions are in another unit.",
                   "Check [log] rate_hz, the unit of time and that of the positions."},
    DiagnosticCode{
        "velocity_mismatch", warning, "Recorded velocities are not the derivatives of the positions.",
        "Another unit, another sign or another order of the columns of one of the two.",
        "Compare [log] velocity and position column by column. The identification uses positions alone."},
    DiagnosticCode{
        "time_scale", error, "The clock of the log runs too fast or too slow.",
        "Velocities that were recorded, or the inertia against the gravity of the a-priori model, differ "
        "from those of the log by the same factor for all joints, or the rate is one that no dynamics show "
        "at: a "
        "wrong rate_hz, or time stamps in another unit.",
        "Correct [log] rate_hz or the unit of time."},
    DiagnosticCode{"clock_jitter", warning, "The samples were not taken at the instants that the log says.",
                   "The errors of positions go along with the velocities of several joints at once: time "
                   "stamps that are missing, or "
                   "rounded, or samples that were lost.",
                   "Log the instants of the controller and name them in [log] time; a log without gaps is "
                   "better still."},
    DiagnosticCode{"duplicate_column", error, "Two joints have the same column.",
                   "All their samples are equal.", "Name one column for each joint in [log]."},
    DiagnosticCode{
        "duplicate_log", warning, "The same data stand in two logs.",
        "All their positions are equal. In the fit they count twice, which makes the deviations too small.",
        "Leave one of them out."},
    DiagnosticCode{"validation_log_used", note, "A log of the validation is one of the identification.",
                   "All their positions are equal. Its error is that of the fit and validates nothing.",
                   "Validate on a log of another motion."},
    DiagnosticCode{"dead_torque", error, "A torque does not change.",
                   "Its column is constant: a signal that was not connected, or the wrong column.",
                   "Check [log] torque or control."},
    DiagnosticCode{"torque_saturated", warning, "A torque stays at its extreme value.",
                   "It was cut off by a limit of the drive, of a sensor or of a data type. The model does "
                   "not hold there.",
                   "Move more gently, or leave these samples out with [signal] window."},
    DiagnosticCode{
        "torque_unit", error, "Torques have the wrong size.",
        "They exceed the limits of the URDF, or differ by a decimal factor from what the a-priori masses, "
        "or any arm of this length, would need: N·mm for N·m, per cent for N·m, a drive gain or a gear ratio "
        "that is missing.",
        "State the unit in [log] units, or drive_gain and gear_ratio in [robot]."},
    DiagnosticCode{"encoder", note, "Resolution and noise of the encoders.",
                   "Smallest step between samples, and the noise that fourth differences show.",
                   "Nothing; compare with the data sheet."},
    DiagnosticCode{
        "cutoff_low", error, "The cut-off frequency takes part of the motion away.",
        "What the filter removes from a position is a large part of its motion, and far above its noise.",
        "Raise [signal] cutoff_hz to ten times the highest frequency of the motion."},
    DiagnosticCode{
        "cutoff_lowish", warning, "The cut-off frequency takes a part of the motion away.",
        "What the filter removes from a position is far above its noise, but a small part of its motion.",
        "Raise [signal] cutoff_hz to ten times the highest frequency of the motion."},
    DiagnosticCode{"cutoff_high", warning, "Accelerations are mostly noise.",
                   "The noise of the encoder, differentiated twice, exceeds the accelerations of the motion.",
                   "Lower [signal] cutoff_hz, decimate, or use method \"iv\"."},
    DiagnosticCode{"cutoff_high_iv", note, "Accelerations are mostly noise, which does not bias IDIM-IV.",
                   "The noise of the encoder, differentiated twice, exceeds the accelerations of the motion.",
                   "Nothing; a lower [signal] cutoff_hz gives the iteration a better start."},
    DiagnosticCode{"reference_mismatch", error, "The motion does not follow the reference.",
                   "At no delay do the two resemble each other: the reference of another log, or columns in "
                   "another order.",
                   "Check [log] reference or reference_file."},
    DiagnosticCode{"reference_unit", error, "The reference has another scale than the motion.",
                   "They have the same shape, but not the same size or sign: another unit.",
                   "State the unit in [log] units: reference or position."},
    DiagnosticCode{"reference_leads", warning, "The motion comes before its reference.",
                   "The best delay is negative for all joints: two clocks, or a log that was cut elsewhere.",
                   "Set delay of [log.reference_file], or cut both alike."},
    DiagnosticCode{"reference_delay", note, "Delay of the motion behind its reference.",
                   "Where their cross-correlation is largest.", "Nothing, if it is that of your controller."},
    DiagnosticCode{"torque_delay", error, "Torques and positions are not simultaneous.",
                   "The torques fit the motion much better when they are shifted in time.",
                   "Change [log] torque_lag by the samples that the text gives."},
    DiagnosticCode{"small_torque_delay", note, "Torques and positions are a little apart in time.",
                   "The torques fit the motion better when they are shifted in time, but well without it.",
                   "Nothing, or change [log] torque_lag by the samples that the text gives."},
    DiagnosticCode{"noise_bias", warning, "Noise of the positions biases parameters.",
                   "Least squares takes the noise of positions that are differentiated twice for motion. "
                   "What it does to each "
                   "parameter is computed from the noise that the log shows.",
                   "Widen the window of the rows ([signal] decimation), or give controller and reference and "
                   "take method \"iv\". Where "
                   "decimation is \"auto\" no window helps: a faster or larger motion does."},
    DiagnosticCode{
        "torque_lag", warning, "Torques look a little early or late beside the motion.",
        "What the model leaves of the torques goes along with their rate, by more than chance, and by enough "
        "to take a parameter out of its interval: a torque that acts until the next sample, a filter in its "
        "measurement, stamps of different clocks. Friction or elasticity that the model lacks can look so "
        "too.",
        "Set [signal] torque_held or [log] torque_lag as the text says, and see whether the residual and the "
        "error on another log fall."},
    DiagnosticCode{
        "torque_sign", error, "A torque has the wrong sign.",
        "With the other sign inertia and friction are positive and the torques of all joints agree.",
        "Set sign = -1 for that column in [log] torque or control, or make drive_gain negative."},
    DiagnosticCode{
        "position_sign", error, "A position has the wrong sign.",
        "With the other sign inertia and friction are positive and the torques of all joints agree.",
        "Set sign = -1 for that column in [log] position, or mend the axis in the URDF."},
    DiagnosticCode{"torque_order", error, "Torques of two joints are exchanged.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of [log] torque or control."},
    DiagnosticCode{"position_order", error, "Positions of two joints are exchanged.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of [log] position."},
    DiagnosticCode{"joint_order", error, "Two joints are exchanged, positions and torques alike.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of the columns in [log]: base to tip."},
    DiagnosticCode{
        "gravity_direction", error, "Gravity points elsewhere.",
        "With gravity along another axis of the base the torques of all joints agree: a robot on a wall or "
        "ceiling, or a sign.",
        "Correct [robot] gravity: the acceleration of free fall in the frame of the base."},
    DiagnosticCode{"torque_gain", error,
                   "The torque of a joint has another scale than those of the other joints.",
                   "A score test: the rows of the other joints, which share parameters with this one, agree "
                   "with it after a "
                   "change of its gain alone. A drive gain, a gear ratio or a torque constant that is wrong.",
                   "Correct drive_gain in [robot], or the scale of its column in [log], as the text says."},
    DiagnosticCode{"zero_offset", error, "The zero of a joint is not where the URDF has it.",
                   "A score test: an offset of its position explains much of the residual, on blocks of time "
                   "left out as well.",
                   "Give its column in [log] position the offset of the text, or calibrate the joint."},
    DiagnosticCode{
        "gravity_tilt", error, "The base is tilted against gravity.",
        "A score test: gravity that is turned a little explains much of the residual, on blocks of time left "
        "out as well.",
        "Set [robot] gravity as the text says, or level the base."},
    DiagnosticCode{"clock_rate", error, "The clock of the log runs a little too fast or too slow.",
                   "A score test: velocities and accelerations by another clock agree better with gravity "
                   "and with each other.",
                   "Correct [log] rate_hz or the time stamps as the text says."},
    DiagnosticCode{
        "joint_origin", error, "The frame of a joint is not where the URDF has it.",
        "A score test: a joint that is displaced or turned explains much of the residual, on blocks of time "
        "left out as well.",
        "Compare <origin> of that joint in the URDF with the arm, or with the maker's calibration."},
    DiagnosticCode{
        "load_changed", error, "The load of the last link changes within the logs.",
        "A score test: other parameters of the last link from some instant on explain much of the residual.",
        "Identify each load from a log of its own."},
    DiagnosticCode{
        "model_mismatch", warning, "Something in robot or log is other than the experiment says.",
        "A score test finds more than chance, in the direction that the text names, and by enough to move a "
        "parameter out of its interval. It may be a small fault of that kind, or one that looks like it.",
        "Look at what the text names; compare with another log."},
    DiagnosticCode{
        "load_friction", warning, "Friction of a joint grows with its load.",
        "A score test: |torque of the load| times the direction of motion explains a part of the residual "
        "that the "
        "friction law leaves.",
        "Set friction = \"load\" for that joint, or \"auto\" in [robot]: [robot.joints.NAME] friction = "
        "\"load\"; else the inertial parameters may be off by what the "
        "text tells."},
    DiagnosticCode{"stribeck_friction", warning,
                   "Friction of a joint is larger at low speed than its law says.",
                   "A score test: a term that falls with speed explains a part of the residual.",
                   "Set friction = \"root\" for that joint, or \"auto\" in [robot]; or leave slow rows out "
                   "with [signal] "
                   "velocity_threshold."},
    DiagnosticCode{
        "direction_friction", warning, "Friction of a joint differs between its directions.",
        "A score test: another viscous or dry friction for forward motion explains a part of the residual.",
        "Set friction = \"asymmetric\" in [robot]."},
    DiagnosticCode{
        "joint_elasticity", warning, "A joint looks elastic.",
        "A score test: a link that gives way in proportion to its load explains a part of the residual.",
        "Move more slowly, or measure at the link."},
    DiagnosticCode{"joint_coupling", warning, "A motor looks to turn two joints.",
                   "A score test: accelerations and velocities of the other joint explain a part of the "
                   "residual of each.",
                   "Add a [[robot.coupling]] of these joints."},
    DiagnosticCode{"friction_drives", warning, "An identified friction drives and does not brake.",
                   "Its coefficient is negative by more than three deviations: a wrong sign or scale of a "
                   "torque, slow motion, or "
                   "friction that the law does not have.",
                   "Look for the other findings; record faster motion both ways."},
    DiagnosticCode{"negative_rotor", warning, "An identified rotor inertia is negative.",
                   "It is below zero by more than three deviations: a joint without geared rotor behind its "
                   "torque sensor, or "
                   "torques that are late.",
                   "Set rotor_inertia = false for that joint where torques are measured at the joint."},
    DiagnosticCode{"few_rows", error, "There are hardly more rows than parameters.",
                   "A short log, a narrow [signal] window, or a decimation that leaves little: residuals of "
                   "so few rows say nothing "
                   "of the errors.",
                   "Record a longer motion, or lower [signal] decimation."},
    DiagnosticCode{"poor_fit", error, "The model leaves most of the torques.",
                   "Whatever its parameters: columns of another log, a wrong geometry, a delay that changes.",
                   "Plot torques beside the motion; run rivid_identify check."},
    DiagnosticCode{"validation_worse", warning, "On another log the model is much worse than in the fit.",
                   "The residual of a joint there is more than twice that of the fit: another load, another "
                   "temperature, a motion "
                   "that the log of the fit did not show.",
                   "Compare the two logs; identify from both."},
    DiagnosticCode{
        "unexplained_torque", warning, "No parameters explain the torque of a joint.",
        "The model leaves most of the torque of that joint, whatever its parameters: columns of another "
        "log, a wrong geometry, a missing coupling, a delay that changes.",
        "Plot that torque beside the motion; see [[robot.coupling]]."},
    DiagnosticCode{"rows_unusable", error, "The signal chain leaves no rows that could be used.",
                   "Trimming, window, velocity thresholds or the rows of standstill leave nothing.",
                   "Change [signal], or record more motion."},
    DiagnosticCode{"not_excited", error, "These data do not show some parameters.",
                   "Their columns of the observation matrix are zero, or combinations of the others.",
                   "Record the motion that the text names, or leave these parameters out of the model."},
    DiagnosticCode{"hardly_excited", note, "These data hardly show some parameters.",
                   "A parameter as large as any of its kind would pass unnoticed.",
                   "Record the motion that the text names where these parameters matter."},
    DiagnosticCode{"weak_parameters", note, "Some parameters will have wide intervals.",
                   "A quick weighted fit forecasts intervals that hold zero or deviations above 30 % of the "
                   "value. Often these "
                   "parameters are just small.",
                   "Where they matter, record the motion that the result's advice names."},
    DiagnosticCode{"forecast", note, "What an identification from these data will look like.",
                   "From a quick weighted fit.", "Nothing."},
    DiagnosticCode{"weak_excitation", warning,
                   "Warning of a result: the motion hardly distinguishes some parameters.",
                   "The observation matrix with columns of unit length has a condition number above 100, and "
                   "most of the "
                   "variance of the named parameters comes from its weak directions.",
                   "Record a more exciting motion, add logs, or ask for the physically consistent parameters "
                   "near the robot "
                   "description."},
    DiagnosticCode{"physical_unsettled", warning,
                   "Warning of a result: the physically consistent parameters may not be the nearest ones.",
                   "The search for them ended before their cost was known to be the least one. They are "
                   "consistent all the "
                   "same.",
                   "Check the robot description and raise the weight in [method.physical]; from C++, raise "
                   "Physical::max_steps."},
    DiagnosticCode{"prefilter_shift", warning,
                   "Warning of a result: the prefilter moves parameters by more than their intervals.",
                   "Whitening amplifies frequencies at which the model of the robot is not right: "
                   "flexibility, friction that "
                   "is none of the laws, delays.",
                   "Prefer the estimate without prefilter, which the result holds as well."},
    DiagnosticCode{
        "loop_mismatch", warning, "Warning of a result: the assumed controller does not explain the log.",
        "The control law, fed with the measured motion, misses the recorded control signal, or the simulated "
        "motion misses the measured one: other gains, another law, a delay. The instruments become weaker, "
        "but "
        "not wrong.",
        "Come nearer to the actual controller in [control]; look at the strength of the instruments."},
    DiagnosticCode{
        "loop_bandwidth", warning,
        "Warning of a result: the bandwidth of the assumed controller may be far from the actual one.",
        "The torques fit the simulated motion much worse than the measured one.",
        "Raise or lower omega_n in [control] until the two errors are alike."},
    DiagnosticCode{
        "outliers_decide", warning,
        "Warning of a result: the weights of a robust estimate move parameters by more than their intervals.",
        "Rows of little weight pull the unweighted estimate elsewhere: they are outliers, or what the model "
        "misses.",
        "Look at these rows before either estimate is trusted; friction at low speed is the usual suspect."},
    DiagnosticCode{"many_outliers", warning,
                   "Warning of a result: too many rows of a joint have little weight in a robust estimate.",
                   "That many are more than outliers: the model misses something there, or a decimation "
                   "smears each outlier "
                   "over many rows.",
                   "Plot that torque beside the prediction; decimate less, or mend the model."},
    DiagnosticCode{
        "driving_friction", warning, "Friction of a joint would drive instead of brake.",
        "An estimate below zero, from data that hardly show the friction, or with a friction law that does "
        "not "
        "fit. Neither a simulation nor a URDF can take it: it counts as zero.",
        "Take the physically consistent parameters, or another friction law, or excite that joint more."},
    DiagnosticCode{
        "no_body", error, "No body has the inertia that a link would get.",
        "Its mass is not positive, or its principal moments of inertia violate the triangle inequality.",
        "Write the physically consistent parameters; --force writes the link nevertheless."},
    DiagnosticCode{
        "urdf_has_no_place", warning, "A URDF can not say some of what was identified.",
        "It knows neither rotor inertias nor friction offsets, asymmetric friction or coupled motors.",
        "Write them beside it with --sidecar, or read result.json."},
    DiagnosticCode{"lumped_links_scaled", warning,
                   "Links that are fixed to a moving one were made lighter in the URDF.",
                   "What was identified is their sum, which is less than what they weigh in the URDF.",
                   "Correct the masses of these links in the URDF, and write it again."},
    DiagnosticCode{"reference_limits", warning, "The reference of a simulation leaves the limits of a joint.",
                   "A position beyond the limits of the URDF.", "Correct [reference], or the limits."},
    DiagnosticCode{"added_control_unrecorded", warning,
                   "The log of a simulation does not hold the whole torque.",
                   "added_control comes after the controller's signal, which is all that is recorded.",
                   "Add \"torque\" to record in [simulation]."},
    DiagnosticCode{"limit_assumed", note, "A limit of a joint is missing, and a usual one is taken.",
                   "The robot's description has no position limits for a joint that turns.",
                   "Give lower and upper in [excitation.limits]."},
    DiagnosticCode{"limit_doubt", warning, "The limits of a robot look like placeholders.",
                   "All joints have the same number, which hardly any robot has.",
                   "Give the actual limits in [excitation.limits]."},
    DiagnosticCode{"no_torque_model", warning, "A designed motion does not keep to torque limits.",
                   "The robot's description has no masses, so torques can not be foretold.",
                   "Give the inertials, or accelerations in [excitation.limits] that the drives can do."},
    DiagnosticCode{"clearance_left_out", note, "A pair of bodies is not kept apart.",
                   "It is nearer than the clearance in most random poses: bodies that are always near, or "
                   "capsules that are too thick.",
                   "Give capsules in [excitation.space] where that pair matters."},
    DiagnosticCode{"noise_assumed", note, "Foretold standard deviations rest on an assumed noise.",
                   "Nothing is said of the torque errors, so 1 % of the torque limits is taken.",
                   "Give noise in [excitation]: the residual's deviation of an earlier identification."},
    DiagnosticCode{
        "doubtful", error, "Status of a result: there is an estimate, and reasons not to trust it.",
        "Findings of severity error about robot, log or model: another unit, sign, order, gain, zero or "
        "clock than the experiment "
        "says. The reasons name them.",
        "Mend what the reasons name and identify again. URDF and C header are written with --force alone."},
    DiagnosticCode{
        "rank_deficient", error,
        "Status of a result: the data, or the instruments, do not determine all parameters.",
        "The observation matrix has less than full rank; the reasons name the parameters.",
        "Record the motion that the parameters' advice names, or leave these parameters out of the model."},
    DiagnosticCode{"not_converged", error, "Status of a result: the iteration came to its limit.",
                   "The parameters still move by more than their tolerance.",
                   "Raise max_iterations in [method], start from least squares, or come nearer to the actual "
                   "controller."},
    DiagnosticCode{
        "cycling", error, "Status of a result: IDIM-IV goes round among a few estimates.",
        "The simulated loop changes its pattern of stick and slip from one iterate to the next.",
        "Filter, leave slow rows out with velocity_threshold, or come nearer to the actual controller."},
    DiagnosticCode{"weak_instruments", error,
                   "Status of a result: the simulated motion says too little about some parameters.",
                   "The first-stage F statistic of a parameter is below 10: its deviation is large, and the "
                   "estimate may be biased.",
                   "Use the actual gains, a wider bandwidth or larger moves."},
    DiagnosticCode{
        "not_simulable", error, "Status of a result: no closed loop could be simulated.",
        "Neither an iterate nor a robot near it gave a loop that stays bounded: wrong signs, units or gains.",
        "Run rivid_identify check, then check [control]."},
};

}  // namespace

std::string_view name(Severity severity) {
  constexpr std::array<std::string_view, 3> names = {"note", "warning", "error"};
  return names[static_cast<std::size_t>(severity)];
}

std::span<const DiagnosticCode> diagnostic_codes() { return codes; }

std::optional<DiagnosticCode> diagnostic_code(std::string_view code) {
  const auto* const at = std::ranges::find(codes, code, &DiagnosticCode::code);
  return at == codes.end() ? std::nullopt : std::optional<DiagnosticCode>(*at);
}

Severity severity(const Finding& finding) {
  const std::optional<DiagnosticCode> known = diagnostic_code(finding.code);
  return known ? known->severity : Severity::warning;
}

std::string_view cure(const Finding& finding) {
  const std::optional<DiagnosticCode> known = diagnostic_code(finding.code);
  return known ? known->cure : std::string_view();
}

std::string sentence(const Finding& finding) {
  return finding.subject.empty() ? finding.text : finding.subject + ": " + finding.text;
}

std::string in_words(const Finding& finding) {
  return std::string(name(severity(finding))) + " [" + finding.code + "] " + sentence(finding);
}

}  // namespace rivid
