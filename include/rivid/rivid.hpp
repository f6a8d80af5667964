#pragma once

/// The public face of rivid: everything that a program needs to go from a robot and a log to its parameters.
///
///   const rivid::Robot robot = rivid::read_urdf("scara.urdf");
///   const rivid::Log log = rivid::read_csv("scara_s2.csv");
///   std::cout << rivid::identify(robot, log, {.signal = {.cutoff_hz = 20.0, .decimation = {20}}});
///
/// rivid/model/kdl.hpp is not included here: who starts from a KDL::Chain includes it and links KDL.

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/data/log.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/covariance.hpp"
#include "rivid/identify/essential.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/physical.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/output.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/report/payload.hpp"
#include "rivid/report/text.hpp"
#include "rivid/report/ticks.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/simulate/stick_slip.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/solve/instrumental.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"
