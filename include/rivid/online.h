/* The estimators of rivid/online as C functions, for controllers that are not in C++. Link rivid::runtime, an
 * archive that needs nothing else, or rivid.
 *
 * Units are SI on the joint side. Functions that are called each tick neither allocate nor lock; an object
 * belongs to one thread at a time. Handles and pointers must not be NULL, but where that is said and for
 * delete, and arrays have one entry a joint: neither is checked. */
#ifndef RIVID_ONLINE_H
#define RIVID_ONLINE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rivid_payload rivid_payload;
typedef struct rivid_contact rivid_contact;
typedef struct rivid_state rivid_state;

/* Numbers for set_target_payload() and setLoad(), in the flange frame. */
typedef struct rivid_payload_numbers {
  double mass;       /* [kg] */
  double mass_sigma; /* standard deviation [kg] */
  double com[3];     /* centre of mass [m] */
  double com_sigma[3];
  double inertia[6]; /* Ixx Iyy Izz Ixy Ixz Iyz about it [kg m^2]; zero where the motion does not show it */
  int held;          /* whether there is a payload */
  int body;          /* whether the inertia is told */
  int good;          /* whether mass and centre of mass are good enough to send */
} rivid_payload_numbers;

/* A PayloadEstimator of a result.json.
 *
 * f_m         ticks a second [Hz]
 * gain_sigma  relative standard deviation of the drive gains
 * flange      origin x, y, z [m] and roll, pitch, yaw [rad] of the flange in the frame of the last link;
 *             NULL: that frame
 * message     what is wrong, where NULL is returned; it may be NULL */
rivid_payload* rivid_payload_new(const char* result_json, double f_m, double gain_sigma,
                                 const double flange[6], char* message, size_t message_size);
void rivid_payload_delete(rivid_payload* payload);
int rivid_payload_joints(const rivid_payload* payload);
/* A tick: positions and torques of the joints. Returns 1 where a change of the payload was found, else 0. */
int rivid_payload_update(rivid_payload* payload, const double* q, const double* tau);
/* The last change: 1 for a pick-up, -1 for a release, 0 while that is not clear or there was none. */
int rivid_payload_change(const rivid_payload* payload);
/* Instead of an update, while something touches the robot. */
void rivid_payload_pause(rivid_payload* payload);
void rivid_payload_read(const rivid_payload* payload, rivid_payload_numbers* numbers);

/* A ContactObserver of a result.json: bandwidth in rad/s, false alarms of all joints an hour. Where NULL is
 * returned, message says why. */
rivid_contact* rivid_contact_new(const char* result_json, double f_m, double bandwidth,
                                 double alarms_per_hour, char* message, size_t message_size);
void rivid_contact_delete(rivid_contact* contact);
int rivid_contact_joints(const rivid_contact* contact);
/* A tick: positions, velocities, and torques from the last tick to this one. learn: nothing touches the
 * robot, thresholds follow. Returns the link that is touched, counted from 1, or 0. */
int rivid_contact_update(rivid_contact* contact, const double* q, const double* qd, const double* tau,
                         int learn);
/* Whether a joint, counted from 1, has learned its threshold; 0: whether all have. A joint sees no contact
 * before. */
int rivid_contact_learned(const rivid_contact* contact, int joint);
/* External torques, and these over their thresholds; either may be NULL. */
void rivid_contact_read(const rivid_contact* contact, double* torque, double* relative);

/* What was wrong with a tick: how many before it were lost, and whether it follows a gap, has no number, is
 * the one before once more, comes at no tick's time, or comes behind a glitch. */
typedef struct rivid_tick {
  long lost;
  int gap, not_finite, repeated, late, glitch;
} rivid_tick;

/* A RobotState of a result.json: payload, friction and contacts together. learn: seconds at the begin in
 * which nothing may touch the robot; torque_held: whether a torque acts until the next tick, as a command
 * does. The others as above. */
rivid_state* rivid_state_new(const char* result_json, double f_m, double gain_sigma, const double flange[6],
                             int torque_held, double learn, char* message, size_t message_size);
void rivid_state_delete(rivid_state* state);
int rivid_state_joints(const rivid_state* state);
/* A tick, measured at t [s]. Returns RIVID_CONTACT, RIVID_COLLISION and RIVID_PAYLOAD_CHANGED, or 0; tick may
 * be NULL. */
#define RIVID_CONTACT 1
#define RIVID_COLLISION 2
#define RIVID_PAYLOAD_CHANGED 4
int rivid_state_update(rivid_state* state, double t, const double* q, const double* tau, rivid_tick* tick);
void rivid_state_payload(const rivid_state* state, rivid_payload_numbers* numbers);
/* The link that is touched, counted from 1, or 0. */
int rivid_state_link(const rivid_state* state);
/* What the controller knows: the payload has changed; it is this point in the flange frame, with deviations
 * (returns 0 where a number can not be used); the gripper has opened, or closed. */
void rivid_state_payload_changed(rivid_state* state);
int rivid_state_payload_known(rivid_state* state, double mass, const double com[3], double mass_sigma,
                              double com_sigma);
void rivid_state_gripper(rivid_state* state, int open);
/* Torques for a motion of the reference, once a tick. */
void rivid_state_feedforward(rivid_state* state, const double* q, const double* qd, const double* qdd,
                             double* tau);
/* What was learned, as bytes; both return 0 where these do not fit. */
size_t rivid_state_size(const rivid_state* state);
int rivid_state_save(const rivid_state* state, void* bytes, size_t size);
int rivid_state_restore(rivid_state* state, const void* bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
