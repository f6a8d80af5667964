#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "odd/random.hpp"

namespace rivid::odd {

/// What one experiment is made of, beside what is random in its arm. Zero means "none" throughout.
struct Recipe {
  enum class Motion {
    fourier,
    moves,
    one_by_one,
    raster  ///< the first joint to and fro, the others a step at each end
  };
  /// Deviations of what the user believes from what is.
  enum class Belief {
    right,
    torque_sign,    ///< of one joint
    swapped,        ///< positions or torques of two joints
    deg_rad,        ///< positions in degrees
    mNm,            ///< torque of one joint
    gain,           ///< torque of one joint times gain_factor
    shifted_joint,  ///< origin of one joint
    turned_joint,   ///< orientation of one joint
    tilted,         ///< the base, by tilt
    on_a_wall,      ///< gravity along another axis of the base
    zero_offset,    ///< of the positions of one joint
    gain_and_zero,  ///< of two joints
    coupled         ///< two joints are turned by motors that the user takes for theirs
  };
  /// Masses and inertias in the user's URDF.
  enum class Bodies {
    right,
    off,    ///< by factors
    alike,  ///< one kilogram each
    none
  };

  // Robot
  int joints = 3;
  bool gantry = false;  ///< whether the first joints are prismatic, at right angles
  bool rotors = true;
  double friction = 1.0;  ///< factor of the dry friction
  // Motion
  Motion motion = Motion::fourier;
  double amplitude = 1.0;  ///< [rad]; a quarter of it in metres for prismatic joints
  double pace = 1.0;       ///< of the time axis
  double dwell = 0.3;      ///< of moves: time at rest over time in motion
  bool one_still = false;  ///< whether one joint stands still
  double duration = 10.0;  ///< of one log [s]
  // Controller
  bool continuous = false;
  bool integral = false;
  double omega_n = 20.0;            ///< [rad/s]
  int delay = 0;                    ///< periods between reading and torque
  double saturation = 0.0;          ///< limit of the torque over the largest one that the motion needs
  double disturbance = 0.0;         ///< torque that nobody records, over the rms torque
  double disturbance_memory = 0.0;  ///< its AR(1) coefficient from sample to sample
  // Sensors
  double rate_hz = 500.0;       ///< of the log
  int control_every = 1;        ///< control periods a sample of the log
  double quantum = 1e-5;        ///< of the encoders [rad]
  double noise = 0.0;           ///< of the encoders, standard deviation [rad]
  double torque_noise = 0.005;  ///< over the rms torque
  double torque_quantum = 0.0;  ///< over the largest torque
  bool has_reference = true;
  // What no model has
  double stribeck = 0.0;       ///< over the dry friction
  double asymmetry = 0.0;      ///< difference of friction between directions, over its mean
  double load_friction = 0.0;  ///< N·m of friction for one N·m
  double Fl = 0.0;             ///< the same, of the torque that the gear hands on
  double Fr = 0.0;             ///< friction with the root of the speed, over the dry friction
  double drift = 0.0;          ///< share of friction lost in the log
  double elastic_hz = 0.0;     ///< frequency of the joints with their motors held
  double ripple = 0.0;         ///< over the rms torque
  double payload = 0.0;        ///< over the mass of the last three links
  bool put_down = false;       ///< whether the payload is let go again
  double backlash = 0.0;       ///< of elastic joints, between motor and link [rad]
  double spring =
      0.0;  ///< torque of a spring at the second joint, over the rms torque, one radian from its rest
  bool other_arm = false;  ///< whether one of the logs is of another arm
  // Faults of the log
  bool held_known = true;     ///< whether the user says torque_held where torques are
  int misaligned = 0;         ///< samples that torques are late
  double jitter = 0.0;        ///< deviation of the sampling instants, in periods
  double dropped = 0.0;       ///< share of the samples that were lost
  bool stamped = true;        ///< whether the stamps tell of jitter and drops
  double clock = 1.0;         ///< factor of the stamps
  double bursts = 0.0;        ///< share of the samples whose stamps are late, as those of a full buffer are
  double gain_drift = 0.0;    ///< change of the torque sensors' gain over the log
  double eccentricity = 0.0;  ///< of the encoders: amplitude of an error once a turn [rad]
  bool at_links =
      false;  ///< whether the log has the links' positions, which elastic joints turn away from the motors'
  double torque_filter_hz = 0.0;
  double position_filter_hz = 0.0;
  double spikes = 0.0;  ///< share of torques that are outliers
  // Errors of the user
  Bodies bodies = Bodies::right;
  Belief belief = Belief::right;
  double gain_factor = 1.0;
  double coupling = 0.0;  ///< turns of one joint for one of the other's motor
  double shift = 0.0;     ///< of an origin [m]
  double turn = 0.0;      ///< of a joint, of the base, or of a zero [rad]
};

/// One kind of experiment.
struct Kind {
  std::string_view name;
  std::string_view group;
  void (*change)(Random&, Recipe&);  ///< of a good experiment
  /// Whether the friction has no true parameters, so that inertial ones alone are judged.
  bool inertial_only = false;
};

/// A way to move, in place of the one that is drawn.
struct Way {
  std::string_view name;
  void (*change)(Random&, Recipe&);
};
[[nodiscard]] std::span<const Way> ways();

/// All kinds, group by group.
[[nodiscard]] std::span<const Kind> kinds();

/// A good experiment, changed by a kind, and by a way where there is one.
///
/// @param sound  what the kind draws is drawn, and left
[[nodiscard]] Recipe drawn_recipe(const Kind& kind, const Way* way, Random& random, bool sound = false);

}  // namespace rivid::odd
