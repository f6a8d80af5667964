#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <string_view>

#include "rivid/finding.hpp"

namespace rivid::detail {

namespace codes_of_findings {

using enum Severity;

// The table behind diagnostic_codes().
inline constexpr std::array codes = {
    DiagnosticCode{"robot_doubt", note, "The robot description has something doubtful.",
                   "A link without inertial, a physically inconsistent inertia, or joints without limits.",
                   "Correct the file where a-priori values matter (physically consistent parameters); the "
                   "estimate uses geometry alone."},
    DiagnosticCode{"base_doubt", warning, "The number of base parameters is not clear.",
                   "A column of the regressor is almost dependent on others: axes that are nearly, but not "
                   "exactly, parallel or perpendicular.",
                   "Round the angles and lengths of the geometry to what they are meant to be."},
    DiagnosticCode{"log_note", note, "The reader noticed or changed something in a log.",
                   "The text says what.", "Nothing, if it is what you expect."},
    DiagnosticCode{"stated_rate", warning, "The time stamps contradict the stated sampling rate.",
                   "[log] rate_hz is that of another log, or the stamps are in another unit.",
                   "Correct [log] rate_hz, or leave it out where the time stamps are right."},
    DiagnosticCode{
        "at_rest", error, "No joint moves in any log.",
        "Every position stays within its noise: wrong file, wrong columns, or a robot that was not started.",
        "Check [log] files and position."},
    DiagnosticCode{"joint_still", error, "A joint moves in no log.",
                   "Its position stays within its noise; its own inertia and friction are not identifiable.",
                   "Record a motion of that joint as well, or fix the joint in the URDF."},
    DiagnosticCode{"standstill", note, "A joint stands still for a large part of a log.",
                   "Dry friction at rest is indeterminate, so these samples carry no information.",
                   "Cut them off with [signal] window; rows = \"exact\" leaves them out."},
    DiagnosticCode{"position_unit", error, "Positions seem to be in another unit.",
                   "They leave the limits of the joint or turn too often, as degrees read as radians or "
                   "millimetres as metres do, or the reverse.",
                   "State the unit in [log] units: position = \"deg\" or \"mm\"."},
    DiagnosticCode{"position_scale", error, "The position of a joint has another scale.",
                   "A factor on its position, velocity and acceleration explains the torques better: a gear "
                   "ratio or encoder "
                   "resolution that is wrong, turns of a motor.",
                   "Give its column in [log] position the scale that the text names."},
    DiagnosticCode{"small_motion", warning, "No joint turns by more than a small angle.",
                   "The motion is tiny, or positions in radians are read as degrees.",
                   "Check the unit in [log] units: position."},
    DiagnosticCode{"position_limits", warning, "Positions leave the limits of the joint.",
                   "An offset of the zero, another robot, or columns in another order.",
                   "Check offsets, signs and order of [log] position against the URDF."},
    DiagnosticCode{"velocity_limit", warning, "A joint moves much faster than the URDF allows.",
                   "The sampling rate is wrong, or positions are in another unit.",
                   "Check [log] rate_hz, the unit of time and that of the positions."},
    DiagnosticCode{
        "velocity_mismatch", warning, "Recorded velocities are not the derivatives of the positions.",
        "Another unit, sign or order of the columns of one of the two.",
        "Compare [log] velocity and position column by column. The identification uses positions alone."},
    DiagnosticCode{
        "time_scale", error, "The sampling rate of the log is wrong.",
        "Recorded velocities, or inertia against gravity of the a-priori model, differ by the same factor "
        "for all joints, or no arm has such dynamics: a wrong rate_hz, or time stamps in another unit.",
        "Correct [log] rate_hz or the unit of time."},
    DiagnosticCode{"late_stamps", warning, "Samples were stamped when they arrived.",
                   "Some time stamps are late and none is early, while all others keep a clock: the samples "
                   "were taken in time.",
                   "irregular = \"ignore\" and rate_hz in [log], as the text says."},
    DiagnosticCode{"register_wraps", error, "A register has gone over its end.",
                   "A column jumps by 65536 of its steps: a counter of 16 bits, or a signed number that was "
                   "read as unsigned.",
                   "Take 65536 steps off behind each jump, or read the register as signed."},
    DiagnosticCode{"clock_jitter", warning, "The samples were not taken at the logged instants.",
                   "Position errors are correlated with the velocities of several joints: missing or rounded "
                   "time stamps, or lost samples.",
                   "Log the instants of the controller and name them in [log] time; avoid lost samples."},
    DiagnosticCode{"duplicate_column", error, "Two joints have the same column.",
                   "All their samples are equal.", "Name one column for each joint in [log]."},
    DiagnosticCode{"duplicate_log", warning, "Two logs hold the same data.",
                   "All their positions are equal. In the fit they count twice, which makes the standard "
                   "deviations too small.",
                   "Leave one of them out."},
    DiagnosticCode{"validation_log_used", warning, "A validation log is also a log of the fit.",
                   "All their positions are equal; its error validates nothing.",
                   "Validate on a log of another motion."},
    DiagnosticCode{"dead_torque", warning, "A torque does not change.",
                   "Its column is constant: a signal that was not connected, or the wrong column. Rows of "
                   "other joints tell what they can of that joint; it has none.",
                   "Check [log] torque or control."},
    DiagnosticCode{"torque_saturated", warning, "A torque stays at its extreme value.",
                   "A limit of drive, sensor or data type cut it off. The model does not hold there.",
                   "Move more gently, or leave these samples out with [signal] window."},
    DiagnosticCode{
        "torque_unit", error, "Torques have the wrong size.",
        "They exceed the limits of the URDF, or differ by a decimal factor from what the a-priori masses, or "
        "any arm of this length, need: N·mm for N·m, per cent, or a missing drive gain or gear ratio.",
        "State the unit in [log] units, or drive_gain and gear_ratio in [robot]."},
    DiagnosticCode{"encoder", note, "Resolution and noise of the encoders.",
                   "Smallest step between samples, and the noise estimated from fourth differences.",
                   "Nothing; compare with the data sheet."},
    DiagnosticCode{
        "cutoff_low", error, "The cut-off frequency removes part of the motion.",
        "What the filter removes from a position is a large part of its motion, and far above its noise.",
        "Raise [signal] cutoff_hz to ten times the highest frequency of the motion."},
    DiagnosticCode{"cutoff_lowish", warning, "The cut-off frequency removes a small part of the motion.",
                   "What the filter removes from a position is far above its noise.",
                   "Raise [signal] cutoff_hz to ten times the highest frequency of the motion."},
    DiagnosticCode{"cutoff_high", warning, "Accelerations are mostly noise.",
                   "The encoder noise, differentiated twice, exceeds the accelerations of the motion.",
                   "Lower [signal] cutoff_hz, decimate, or use method \"iv\"."},
    DiagnosticCode{"cutoff_high_iv", note, "Accelerations are mostly noise, which does not bias IDIM-IV.",
                   "The encoder noise, differentiated twice, exceeds the accelerations of the motion.",
                   "Nothing; a lower [signal] cutoff_hz gives the iteration a better start."},
    DiagnosticCode{"reference_mismatch", error, "The motion does not follow the reference.",
                   "They match at no delay: the reference of another log, or columns in another order.",
                   "Check [log] reference or reference_file."},
    DiagnosticCode{"reference_unlike", warning,
                   "The reference is not that of the motion, or in another unit.",
                   "Columns of another log or joint, or degrees. The method does not use it.",
                   "Correct [log] reference before a method that follows it: IDIM-IV, DIDIM."},
    DiagnosticCode{"reference_unit", error, "The reference has another scale than the motion.",
                   "Same shape, but another size or sign: another unit.",
                   "State the unit in [log] units: reference or position."},
    DiagnosticCode{"reference_leads", warning, "The motion comes before its reference.",
                   "The best delay is negative for all joints: two clocks, or a log that was cut elsewhere.",
                   "Set delay of [log.reference_file], or cut both alike."},
    DiagnosticCode{"reference_delay", note, "Delay of the motion behind its reference.",
                   "Where their cross-correlation is largest.", "Nothing, if it is that of your controller."},
    DiagnosticCode{"torque_delay", error, "Torques and positions are not simultaneous.",
                   "The torques fit the motion much better when they are shifted in time.",
                   "Change [log] torque_lag by the samples that the text gives."},
    DiagnosticCode{"small_torque_delay", note, "Torques and positions have a small time offset.",
                   "The torques fit the motion better when they are shifted in time, but well without it.",
                   "Nothing, or change [log] torque_lag by the samples that the text gives."},
    DiagnosticCode{"noise_bias", warning, "Position noise biases parameters.",
                   "Least squares takes differentiated position noise for motion. The bias is computed from "
                   "the noise of the log.",
                   "Widen the window of the rows ([signal] decimation), or give controller and reference and "
                   "use method \"iv\". Where decimation is \"auto\" only a faster or larger motion helps."},
    DiagnosticCode{
        "window_shift", warning, "Parameters depend on the spacing of the rows.",
        "Rows at half or double the spacing that was chosen move a parameter by more than 3 σ, what "
        "noise does taken off: an error of the model or weak excitation. Intervals are wider by it.",
        "Look at the friction laws and the other findings; record a more exciting motion."},
    DiagnosticCode{"torque_lag", warning, "Torques have a small time offset from the motion.",
                   "The residual is correlated with the rate of the torques, enough to move a parameter out "
                   "of its interval: a torque that acts until the next sample, a filter in its measurement, "
                   "different clocks; unmodelled friction or elasticity can look alike.",
                   "Set [signal] torque_held or [log] torque_lag as the text says, and check residual and "
                   "validation error."},
    DiagnosticCode{
        "torque_sign", error, "A torque has the wrong sign.",
        "With the other sign inertia and friction are positive and the torques of all joints agree.",
        "Set sign = -1 for that column in [log] torque or control, or make drive_gain negative."},
    DiagnosticCode{
        "position_sign", error, "A position has the wrong sign.",
        "With the other sign inertia and friction are positive and the torques of all joints agree.",
        "Set sign = -1 for that column in [log] position, or correct the axis in the URDF."},
    DiagnosticCode{"torque_order", error, "Torques of two joints are exchanged.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of [log] torque or control."},
    DiagnosticCode{"position_order", error, "Positions of two joints are exchanged.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of [log] position."},
    DiagnosticCode{"joint_order", error, "Two joints are exchanged, positions and torques alike.",
                   "Exchanged back, the torques of all joints agree with one set of parameters.",
                   "Correct the order of the columns in [log]: base to tip."},
    DiagnosticCode{"gravity_direction", error, "Gravity points elsewhere.",
                   "With gravity along another axis of the base the torques of all joints agree: a robot on "
                   "a wall or ceiling, or a sign.",
                   "Correct [robot] gravity: the acceleration of free fall in the base frame."},
    DiagnosticCode{"torque_without_gravity", error, "The torques are without gravity.",
                   "Without gravity the model leaves less of them, in each half of the logs too: the driver "
                   "takes the weight off, as some drivers of Universal Robots and tau_J_d of Franka do.",
                   "torque_without = \"gravity\" in [log], or log the whole torque."},
    DiagnosticCode{"torque_gain", error,
                   "The torque of a joint has another scale than those of the other joints.",
                   "A score test: the rows of the other joints agree with this one after a change of its "
                   "gain. A wrong drive gain, gear ratio or torque constant.",
                   "Correct drive_gain in [robot], or the scale of its column in [log], as the text says."},
    DiagnosticCode{"target_gains", note, "The log says which drive gains its controller uses.",
                   "Target currents and target torques of the controller's own model, whose ratio, friction "
                   "aside, is the "
                   "drive gain.",
                   "Nothing where [robot] has them; else take them over."},
    DiagnosticCode{
        "drive_gain_differs", warning, "A drive gain is not that of the robot's controller.",
        "Target current over target torque in the log gives another one, by more than 5 % and one and a half "
        "times the half-width of its 95 % interval: a gain of another source or another arm.",
        "Take the gain of the text, or measure it: [method] gains = \"estimate\" with a known payload. "
        "Masses "
        "and friction scale with it."},
    DiagnosticCode{"zero_offset", error, "The zero of a joint is not where the URDF has it.",
                   "A score test: an offset of its position explains much of the residual, also on blocks of "
                   "time left out.",
                   "Give its column in [log] position the offset of the text, or calibrate the joint."},
    DiagnosticCode{"gravity_tilt", error, "The base is tilted against gravity.",
                   "A score test: gravity turned a little explains much of the residual, also on blocks of "
                   "time left out.",
                   "Set [robot] gravity as the text says, or level the base."},
    DiagnosticCode{"clock_rate", error, "The sampling rate of the log is slightly wrong.",
                   "A score test: velocities and accelerations at another rate agree better with gravity and "
                   "with each other.",
                   "Correct [log] rate_hz or the time stamps as the text says."},
    DiagnosticCode{
        "joint_origin", error, "The frame of a joint is not where the URDF has it.",
        "A score test: a joint that is displaced or turned explains much of the residual, also on blocks of "
        "time left out.",
        "Compare <origin> of that joint in the URDF with the arm, or with the maker's calibration."},
    DiagnosticCode{
        "load_changed", error, "The load of the last link changes within the logs.",
        "A score test: other parameters of the last link from some instant on, or in each tenth of the time, "
        "explain much of the residual.",
        "Identify each load from a log of its own, or a part of one: [signal] window, rivid payload --loaded "
        "FILE@FROM:TO."},
    DiagnosticCode{"uneven_residual", warning, "The model fails in a part of the time.",
                   "A twentieth of the time leaves five times what the middle one does, and 3 % of the "
                   "joint's torque: a contact, a push, a stop, a position that slipped, a load.",
                   "Look at the residuals there; leave that time out: [signal] window."},
    DiagnosticCode{"model_mismatch", warning, "Robot or log differ from the experiment file.",
                   "A score test is significant in the direction that the text names, and moves a parameter "
                   "out of its interval: a small fault of that kind, or a similar one.",
                   "Check what the text names; compare with another log."},
    DiagnosticCode{"logs_differ", error, "Two logs are of different arms or tools.",
                   "Bodies of its own explain a large part of what one set of parameters leaves of a log, on "
                   "blocks of time that took no part, beside friction of its own.",
                   "Identify each arm, and each tool, from logs of its own."},
    DiagnosticCode{
        "load_friction", warning, "Friction of a joint grows with its load.",
        "A score test: |torque of the load| times the direction of motion explains a part of the residual "
        "that the "
        "friction law leaves.",
        "Set friction = \"load\" for that joint, or \"auto\" in [robot]: [robot.joints.NAME] friction = "
        "\"load\"; else the inertial parameters may be off by what the "
        "text tells."},
    DiagnosticCode{"stribeck_friction", warning, "Friction of a joint at low speed exceeds its law.",
                   "A score test: a term that falls with speed explains a part of the residual.",
                   "Set friction = \"root\" for that joint, or \"auto\" in [robot]; or leave slow rows out "
                   "with [signal] velocity_threshold."},
    DiagnosticCode{
        "direction_friction", warning, "Friction of a joint differs between its directions.",
        "A score test: another viscous or dry friction for forward motion explains a part of the residual.",
        "Set friction = \"asymmetric\" in [robot]."},
    DiagnosticCode{
        "joint_elasticity", warning, "A joint looks elastic.",
        "A score test: a link that yields in proportion to its load explains a part of the residual.",
        "Move more slowly, or measure at the link."},
    DiagnosticCode{"joint_spring", warning, "A spring or a counterbalance seems to pull a joint.",
                   "A score test: a torque in proportion to its position explains a part of the residual.",
                   "Take its torque off by a table in [log] subtract."},
    DiagnosticCode{"joint_coupling", warning, "A motor seems to turn two joints.",
                   "A score test: accelerations and velocities of the other joint explain a part of the "
                   "residual of each.",
                   "Add a [[robot.coupling]] of these joints."},
    DiagnosticCode{"friction_drives", warning, "An identified friction coefficient is negative.",
                   "It is negative by more than three standard deviations: wrong sign or scale of a torque, "
                   "slow motion, or friction that the law does not have.",
                   "Look at the other findings; record faster motion in both directions."},
    DiagnosticCode{"negative_rotor", warning, "An identified rotor inertia is negative.",
                   "It is below zero by more than three standard deviations: a joint torque sensor behind "
                   "the gear, or late torques.",
                   "Set rotor_inertia = false for that joint where torques are measured at the joint."},
    DiagnosticCode{"not_physical", error, "A parameter or the mass matrix has a value that no robot has.",
                   "A mass, an inertia about an axis, a rotor inertia or a friction coefficient is negative "
                   "by more than "
                   "three standard deviations, or the mass matrix is not positive definite, and more of the "
                   "torques depends on that than the model leaves unexplained: the reference logged as "
                   "position, rows in reverse order, a wrong sign or scale.",
                   "Check columns, signs, units and the order of the rows in [log]."},
    DiagnosticCode{"few_rows", error, "There are hardly more rows than parameters.",
                   "A short log, a narrow [signal] window, or a large decimation: the residual of so few "
                   "rows says nothing about the errors.",
                   "Record a longer motion, or lower [signal] decimation."},
    DiagnosticCode{"poor_fit", error, "The model does not explain the torques.",
                   "It leaves 30 % of a joint's torque, of a log of the fit or of the validation (10 % where "
                   "that torque is "
                   "clipped), or errs by more than all torques together: a scale, columns of another log, "
                   "sums of joints, wrong "
                   "geometry, or too short a motion. Joints with less than a hundredth of the largest torque "
                   "do not count.",
                   "Plot torques beside the motion; run rivid check; record a longer motion."},
    DiagnosticCode{
        "payload_misfit", error, "Logs with a payload do not fit the arm without it.",
        "Arm and payload leave more than twice what an identification from these logs alone "
        "leaves of a joint's torque, or more than 30 % of it: another scale, sign or clock than in "
        "the logs without payload, a load elsewhere than on the last link, a friction that has "
        "changed.",
        "Record both kinds of logs alike, one after the other; compare their columns and units. "
        "Where friction grows with the load: --load-friction."},
    DiagnosticCode{"negative_mass", error, "The mass of a payload is negative.",
                   "It is negative by more than four standard deviations: logs with and without payload are "
                   "exchanged, or differ in a sign or scale.",
                   "Check which logs have the payload, and the signs and units of their columns."},
    DiagnosticCode{
        "validation_worse", warning, "The validation error is much larger than the error of the fit.",
        "The residual of a joint is more than twice that of the fit, or, of up to 1 % of its torque, "
        "ten times: another load, another temperature, or a motion that the fit did not contain.",
        "Compare the two logs; identify from both."},
    DiagnosticCode{
        "prediction_fails", error, "The model does not predict the torques of other motion.",
        "Of a joint of a validation log it leaves more than 1 % of the torque, and ten times what it "
        "leaves of the fit, more than all, or three times what residual and intervals forecast; or these "
        "forecast more than all torques for random motion within the range of the logs: a motion that "
        "shows what the fit did not, another load, another temperature, an error of the model.",
        "Identify from both logs, or record a more exciting motion; validate on a third one."},
    DiagnosticCode{"unexplained_torque", warning, "No parameters explain the torque of a joint.",
                   "The model leaves most of it: columns of another log, wrong geometry, a missing coupling, "
                   "or a delay that changes.",
                   "Plot that torque beside the motion; see [[robot.coupling]]."},
    DiagnosticCode{"rows_unusable", error, "The signal chain leaves no usable rows.",
                   "Trimming, window, velocity thresholds or standstill leave nothing.",
                   "Change [signal], or record more motion."},
    DiagnosticCode{"not_excited", error, "Some parameters are not identifiable from these data.",
                   "Their columns of the observation matrix are zero, or combinations of the others.",
                   "Record the motion that the text names, or leave these parameters out of the model."},
    DiagnosticCode{"hardly_excited", note, "Some parameters are hardly identifiable from these data.",
                   "A parameter as large as any of its kind would not be noticed.",
                   "Record the motion that the text names where these parameters matter."},
    DiagnosticCode{"not_tested", note, "Something could not be tested, and may be wrong.",
                   "A joint moves for too short a time to distinguish a fault from its own parameters: no "
                   "finding about it says that it is right.",
                   "Record a longer motion of that joint, at varying speed and in both directions."},
    DiagnosticCode{"weak_parameters", note, "Some parameters will have wide confidence intervals.",
                   "A quick weighted fit forecasts intervals that include zero, or standard deviations above "
                   "30 % of the value. Often these parameters are just small.",
                   "Where they matter, record the motion that the advice of the result names."},
    DiagnosticCode{"forecast", note, "What an identification from these data will look like.",
                   "From a quick weighted fit.", "Nothing."},
    DiagnosticCode{"weak_excitation", warning,
                   "Warning of a result: the motion hardly distinguishes some parameters.",
                   "The observation matrix with columns of unit length has a condition number above 100, and "
                   "most of the variance of the named parameters comes from its weak directions.",
                   "Record a more exciting motion, add logs, or use the physically consistent parameters."},
    DiagnosticCode{
        "twins_differ", warning, "The data do not agree that two joints are twins.",
        "A Wald test on the estimate without ties: p < 0.001 over the number of twins. The result has "
        "the ties.",
        "Take same_as out, or check mirror and gear_ratio of both joints."},
    DiagnosticCode{"physical_unsettled", warning,
                   "Warning of a result: the physically consistent parameters may not be the nearest ones.",
                   "The solver stopped before it reached its tolerance. They are consistent all the same.",
                   "Check the robot description and raise the weight in [method.physical]; from C++, raise "
                   "Physical::max_steps."},
    DiagnosticCode{
        "prefilter_shift", warning,
        "Warning of a result: the prefilter moves parameters by more than their intervals.",
        "Whitening amplifies frequencies at which the model is wrong: flexibility, other friction, delays.",
        "Prefer the estimate without prefilter, which the result has as well."},
    DiagnosticCode{"loop_mismatch", warning,
                   "Warning of a result: the assumed controller does not explain the log.",
                   "The control law misses the recorded control signal, or the simulated motion the measured "
                   "one: other gains, another law, a delay. The instruments become weaker, but not wrong.",
                   "Correct [control]; look at the strength of the instruments."},
    DiagnosticCode{
        "loop_bandwidth", warning,
        "Warning of a result: the bandwidth of the assumed controller may be far from the actual one.",
        "The torques fit the simulated motion much worse than the measured one.",
        "Raise or lower omega_n in [control] until the two errors are alike."},
    DiagnosticCode{
        "outliers_decide", warning,
        "Warning of a result: robust weights move parameters by more than their intervals.",
        "Rows of little weight are outliers, or what the model misses.",
        "Look at these rows before you trust either estimate; friction at low speed is a frequent cause."},
    DiagnosticCode{"many_outliers", warning,
                   "Warning of a result: too many rows of a joint have little weight in a robust estimate.",
                   "The model misses something there, or a decimation spreads each outlier over many rows.",
                   "Plot that torque beside the prediction; decimate less, or correct the model."},
    DiagnosticCode{
        "driving_friction", warning, "A friction coefficient of a joint is negative.",
        "The data hardly determine it, or the friction law does not fit. Simulation and URDF can not take "
        "it: it counts as zero.",
        "Use the physically consistent parameters, another friction law, or more excitation of that joint."},
    DiagnosticCode{
        "no_body", error, "The inertia of a link would be physically inconsistent.",
        "Its mass is not positive, or its principal moments of inertia violate the triangle inequality.",
        "Write the physically consistent parameters; --force writes the link nevertheless."},
    DiagnosticCode{"format_has_no_place", warning,
                   "The format of an exported model, or the program that reads it, does not have some of "
                   "what was identified.",
                   "URDF and SDF have neither rotor inertias nor friction offsets, and URDF has no gravity; "
                   "Drake has no dry friction; "
                   "pinocchio.rnea() has no friction.",
                   "Take another format, use the functions of the Python module that is written beside the "
                   "model, or read "
                   "result.json."},
    DiagnosticCode{"not_drawn", warning, "Samples of a result do not vary in some parameters.",
                   "The logs leave these parameters undetermined, so that their deviation is infinite.",
                   "Record a motion that excites them, or set their ranges by hand where you train."},
    DiagnosticCode{"meshes_elsewhere", warning,
                   "An exported model names mesh files that are not where it says.",
                   "The URDF names them relative to its own folder, and the model is written to another one.",
                   "Write the model to the folder of the URDF, with --output."},
    DiagnosticCode{"lumped_links_scaled", warning,
                   "Links that are fixed to a moving one were made lighter in the URDF.",
                   "The identified sum is less than their masses in the URDF.",
                   "Correct the masses of these links in the URDF, and write it again."},
    DiagnosticCode{"reference_limits", warning, "The reference of a simulation leaves the limits of a joint.",
                   "A position beyond the limits of the URDF.", "Correct [reference], or the limits."},
    DiagnosticCode{"added_control_unrecorded", warning, "The simulated log does not hold the whole torque.",
                   "added_control is added to the recorded control signal.",
                   "Add \"torque\" to record in [simulation]."},
    DiagnosticCode{"limit_assumed", note, "A joint limit is missing; a usual one is used.",
                   "The robot description has no position limits for a revolute joint.",
                   "Give lower and upper in [excitation.limits]."},
    DiagnosticCode{"limit_doubt", warning, "The limits of the robot look like placeholders.",
                   "All joints have the same limit.", "Give the actual limits in [excitation.limits]."},
    DiagnosticCode{"no_torque_model", warning, "A designed motion does not respect torque limits.",
                   "The robot description has no masses, so torques can not be predicted.",
                   "Give the inertials, or accelerations in [excitation.limits] that the drives can do."},
    DiagnosticCode{"body_assumed", warning, "Links without a shape are kept clear of obstacles by a guess.",
                   "The robot description has no <collision> for them.",
                   "Give them <collision>, or capsules and radius in [excitation.space]."},
    DiagnosticCode{"mesh_missing", warning, "The shape of a link is not there.",
                   "Its mesh is neither beside the URDF nor in a folder above.",
                   "Put the package of the robot beside its URDF."},
    DiagnosticCode{
        "rehearsal_failed", error, "A rehearsed motion gives no result.",
        "The simulated robot did not carry it through or is a fifth of the range off it, or its log is "
        "not identified.",
        "Do what the text says before the robot moves."},
    DiagnosticCode{"rehearsal_tracking", warning, "A simulated robot does not follow its motion.",
                   "The loop is too soft for it, or the drives are too weak.",
                   "Correct [control], or design a slower motion: smaller shares in [excitation.limits]."},
    DiagnosticCode{"rehearsal_wrong", error, "An estimate from a rehearsed log is wrong.",
                   "The hidden parameter is more than five standard deviations away, and no other finding "
                   "need say why.",
                   "Correct what else is found; record finer positions, or design a larger motion."},
    DiagnosticCode{"rehearsal_precision", error, "A rehearsed log determines less than was forecast.",
                   "Noise or resolution of the positions, or a motion that is not followed.",
                   "Record finer positions, or design a larger motion."},
    DiagnosticCode{"rehearsal_prior", warning, "A rehearsed robot is unlike its description.",
                   "A first moment is farther away than the spread of the a-priori values explains: a body "
                   "hangs there that the description lacks, or its tip is elsewhere.",
                   "Put tool and gripper into the URDF, and design the motion anew."},
    DiagnosticCode{"clearance_left_out", note, "Two links are not kept apart.",
                   "They are nearer than the clearance in every random pose: short links, or thick capsules.",
                   "Give capsules in [excitation.space] where that pair matters."},
    DiagnosticCode{
        "clearance_fixed", note, "The first link stands nearer to an obstacle than the clearance.",
        "No joint changes that distance: the base is there.",
        "Nothing, if the robot stands there; else correct [excitation.space] or the link's capsule."},
    DiagnosticCode{
        "polishing_lost", warning, "A designed motion determines less than the search promised.",
        "The best search leaves its limits between its instants, and little of it could be mended.",
        "Try another seed, more starts, or more samples in [excitation]."},
    DiagnosticCode{"noise_assumed", note, "Forecast standard deviations rest on an assumed noise.",
                   "No torque noise is given, so 1 % of the torque limits is used.",
                   "Give noise in [excitation]: sigma_rho of an earlier identification."},
    DiagnosticCode{"doubtful", error,
                   "Status of a result: there is an estimate, and reasons not to trust it.",
                   "Findings of severity error about robot, log or model, which the reasons name.",
                   "Correct what the reasons name and identify again. URDF and C header are written with "
                   "--force alone."},
    DiagnosticCode{
        "rank_deficient", error, "Status of a result: data or instruments do not determine all parameters.",
        "The observation matrix is rank deficient; the reasons name the parameters.",
        "Record the motion that the parameters' advice names, or leave these parameters out of the model."},
    DiagnosticCode{"not_converged", error, "Status of a result: the iteration reached its limit.",
                   "The parameters still move by more than their tolerance.",
                   "Raise max_iterations in [method], start from least squares, or correct [control]."},
    DiagnosticCode{"cycling", error, "Status of a result: IDIM-IV cycles among a few estimates.",
                   "The simulated loop changes its pattern of stick and slip from one iterate to the next.",
                   "Filter, leave slow rows out with velocity_threshold, or correct [control]."},
    DiagnosticCode{"weak_instruments", error,
                   "Status of a result: the instruments of some parameters are weak.",
                   "The first-stage F statistic of a parameter is below 10: its standard deviation is large, "
                   "and the estimate may be biased.",
                   "Use the actual gains, a wider bandwidth or larger moves."},
    DiagnosticCode{"not_simulable", error, "Status of a result: no closed loop could be simulated.",
                   "Neither an iterate nor a physically consistent one near it gave a bounded loop: wrong "
                   "signs, units or gains.",
                   "Run rivid check, then check [control]."},
    DiagnosticCode{"gave_up", error, "Status of a result: a budget of steps or seconds was used up first.",
                   "The simulated loop is stiff or oscillates: wrong gains or units, or long logs.",
                   "Check [control], or raise max_seconds or max_steps: simulation = { max_seconds = 3600 } "
                   "in [method]."},
};

}  // namespace codes_of_findings

using codes_of_findings::codes;

// The code of a finding. One that is written down and that the table does not hold does not compile.
// A choice between two of one length is no literal: std::string_view(leads ? "reference_leads" : …).
class FindingCode {
 public:
  template <std::size_t size>
  consteval FindingCode(const char (&code)[size]) : code_(code) {  // NOLINT(google-explicit-constructor)
    if (std::ranges::find(codes, code_, &DiagnosticCode::code) == codes.end()) {
      throw "codes, above, does not hold this one";
    }
  }
  // One that was chosen or read when the program ran.
  template <std::convertible_to<std::string_view> Text>
  FindingCode(const Text& code) : code_(code) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] constexpr std::string_view text() const { return code_; }

 private:
  std::string_view code_;
};

}  // namespace rivid::detail
