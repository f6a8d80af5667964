#pragma once

/// The public face of rivid: everything that a program needs to go from a robot and a log to its parameters.
///
///   const rivid::Robot robot = rivid::read_urdf("scara.urdf");
///   const rivid::Log log = rivid::read_csv("scara_s2.csv");
///   std::cout << rivid::identify(robot, log, rivid::Ols{.signal = {.cutoff_hz = 20.0, .decimation = {20}}});
///
/// rivid/model/kdl.hpp is not included here: who starts from a KDL::Chain includes it and links KDL.

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/parameter_file.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/essential.hpp"
#include "rivid/identify/iv.hpp"
#include "rivid/identify/least_squares_fit.hpp"
#include "rivid/identify/physical.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/model/pseudo_inertia.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/regressor/observation.hpp"
#include "rivid/report/c_header.hpp"
#include "rivid/report/file.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/sidecar.hpp"
#include "rivid/report/simulation_json.hpp"
#include "rivid/report/table.hpp"
#include "rivid/report/text_diff.hpp"
#include "rivid/report/urdf_write.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/differentiate.hpp"
#include "rivid/signal/zero_phase.hpp"
#include "rivid/simulate/cascade_control.hpp"
#include "rivid/simulate/computed_torque.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "rivid/simulate/inertia.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "rivid/simulate/logged_reference.hpp"
#include "rivid/simulate/noise.hpp"
#include "rivid/simulate/pd_control.hpp"
#include "rivid/simulate/pid_control.hpp"
#include "rivid/simulate/point_to_point_reference.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"
