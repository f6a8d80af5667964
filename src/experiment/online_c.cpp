#include <Eigen/Geometry>
#include <cstring>
#include <exception>
#include <string_view>

#include "rivid/experiment/result_file.hpp"
#include "rivid/online.h"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/robot_state.hpp"

// Names of C.
// NOLINTBEGIN(readability-identifier-naming)
struct rivid_payload {
  rivid::PayloadEstimator<double> estimator;
};
struct rivid_contact {
  rivid::ContactObserver<double> observer;
};
struct rivid_state {
  rivid::RobotState<double> state;
  rivid::Index changes = 0;  // that were told
};
// NOLINTEND(readability-identifier-naming)

namespace {

using rivid::Index;
using Map = Eigen::Map<const rivid::Vector>;

void put_message(std::string_view what, char* message, std::size_t size) {
  if (message != nullptr && size > 0) {
    const std::size_t count = std::min(what.size(), size - 1);
    std::memcpy(message, what.data(), count);
    message[count] = '\0';
  }
}

// What make() makes, or null and a message.
template <typename Make>
auto made_or_null(const Make& make, char* message, std::size_t size) -> decltype(make()) {
  try {
    return make();
  } catch (const std::exception& error) {
    put_message(error.what(), message, size);
    return nullptr;
  }
}

rivid::PayloadEstimatorOptions payload_options(double f_m, double gain_sigma, const double* flange) {
  rivid::PayloadEstimatorOptions out;
  out.rows.f_m = f_m;
  out.gain_sigma = gain_sigma;
  if (flange != nullptr) {
    using Axis = Eigen::Vector3d;
    out.p = {flange[0], flange[1], flange[2]};
    out.R = (Eigen::AngleAxisd(flange[5], Axis::UnitZ()) * Eigen::AngleAxisd(flange[4], Axis::UnitY()) *
             Eigen::AngleAxisd(flange[3], Axis::UnitX()))
                .toRotationMatrix();
  }
  return out;
}

rivid_payload_numbers numbers_of(const rivid::OnlinePayload<double>& found) {
  const auto& I = found.inertia;
  return {found.mass,
          found.mass_sigma,
          {found.com[0], found.com[1], found.com[2]},
          {found.com_sigma[0], found.com_sigma[1], found.com_sigma[2]},
          {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)},
          found.held ? 1 : 0,
          found.body ? 1 : 0,
          found.good ? 1 : 0};
}

}  // namespace

rivid_payload* rivid_payload_new(const char* result_json, double f_m, double gain_sigma,
                                 const double flange[6], char* message, size_t message_size) {
  return made_or_null(
      [&] {
        return new rivid_payload{rivid::PayloadEstimator<double>(rivid::read_online_model(result_json),
                                                                 payload_options(f_m, gain_sigma, flange))};
      },
      message, message_size);
}

void rivid_payload_delete(rivid_payload* payload) { delete payload; }

int rivid_payload_joints(const rivid_payload* payload) {
  return static_cast<int>(payload->estimator.joints());
}

int rivid_payload_update(rivid_payload* payload, const double* q, const double* tau) {
  const Index n = payload->estimator.joints();
  return payload->estimator.update(Map(q, n), Map(tau, n)) ? 1 : 0;
}

int rivid_payload_change(const rivid_payload* payload) {
  using enum rivid::PayloadEstimator<double>::Change::Kind;
  const auto kind = payload->estimator.change().kind;
  return kind == pick_up ? 1 : kind == release ? -1 : 0;
}

void rivid_payload_pause(rivid_payload* payload) { payload->estimator.pause(); }

void rivid_payload_read(const rivid_payload* payload, rivid_payload_numbers* numbers) {
  *numbers = numbers_of(payload->estimator.payload());
}

rivid_contact* rivid_contact_new(const char* result_json, double f_m, double bandwidth,
                                 double alarms_per_hour, char* message, size_t message_size) {
  return made_or_null(
      [&] {
        return new rivid_contact{rivid::ContactObserver<double>(
            rivid::read_identified_model(result_json),
            {.f_m = f_m, .bandwidth = bandwidth, .alarms_per_hour = alarms_per_hour})};
      },
      message, message_size);
}

void rivid_contact_delete(rivid_contact* contact) { delete contact; }

int rivid_contact_joints(const rivid_contact* contact) { return static_cast<int>(contact->observer.size()); }

int rivid_contact_update(rivid_contact* contact, const double* q, const double* qd, const double* tau,
                         int learn) {
  using Mode = rivid::ContactObserver<double>::Mode;
  const Index n = contact->observer.size();
  contact->observer.update(Map(q, n), Map(qd, n), Map(tau, n), learn != 0 ? Mode::learn : Mode::observe);
  return static_cast<int>(contact->observer.link()) + 1;
}

int rivid_contact_learned(const rivid_contact* contact, int joint) {
  const auto& observer = contact->observer;
  const bool one = joint > 0 && joint <= observer.size();
  return (one ? observer.learned(joint - 1) : joint == 0 && observer.learned()) ? 1 : 0;
}

void rivid_contact_read(const rivid_contact* contact, double* torque, double* relative) {
  const Index n = contact->observer.size();
  if (torque != nullptr) {
    std::copy_n(contact->observer.residual().data(), n, torque);
  }
  if (relative != nullptr) {
    std::copy_n(contact->observer.relative().data(), n, relative);
  }
}

rivid_state* rivid_state_new(const char* result_json, double f_m, double gain_sigma, const double flange[6],
                             int torque_held, double learn, char* message, size_t message_size) {
  return made_or_null(
      [&] {
        rivid::RobotStateOptions options;
        const double change = options.payload.friction_change;
        options.payload = payload_options(f_m, gain_sigma, flange);
        options.payload.friction_change = change;
        options.payload.rows.torque_held = torque_held != 0;
        options.learn = learn;
        return new rivid_state{rivid::RobotState<double>(rivid::read_online_model(result_json),
                                                         rivid::read_identified_model(result_json), options)};
      },
      message, message_size);
}

void rivid_state_delete(rivid_state* state) { delete state; }

int rivid_state_joints(const rivid_state* state) { return static_cast<int>(state->state.size()); }

int rivid_state_update(rivid_state* state, double t, const double* q, const double* tau, rivid_tick* tick) {
  auto& of = state->state;
  const rivid::TickQuality found = of.update(t, Map(q, of.size()), Map(tau, of.size()));
  if (tick != nullptr) {
    *tick = {
        static_cast<long>(found.lost), found.gap, found.not_finite, found.repeated, found.late, found.glitch};
  }
  const bool changed = of.payload_changes() != state->changes;
  state->changes = of.payload_changes();
  return (of.contact() ? RIVID_CONTACT : 0) | (of.collision() ? RIVID_COLLISION : 0) |
         (changed ? RIVID_PAYLOAD_CHANGED : 0);
}

void rivid_state_payload(const rivid_state* state, rivid_payload_numbers* numbers) {
  *numbers = numbers_of(state->state.payload());
}

int rivid_state_link(const rivid_state* state) {
  return static_cast<int>(state->state.observer().link()) + 1;
}

void rivid_state_payload_changed(rivid_state* state) { state->state.payload_changed(); }

int rivid_state_payload_known(rivid_state* state, double mass, const double com[3], double mass_sigma,
                              double com_sigma) {
  return state->state.payload_known(mass, {com[0], com[1], com[2]}, mass_sigma, com_sigma) ? 1 : 0;
}

void rivid_state_gripper(rivid_state* state, int open) { state->state.gripper(open != 0); }

void rivid_state_feedforward(rivid_state* state, const double* q, const double* qd, const double* qdd,
                             double* tau) {
  const Index n = state->state.size();
  const auto& found = state->state.feedforward(Map(q, n), Map(qd, n), Map(qdd, n));
  std::copy_n(found.data(), n, tau);
}

size_t rivid_state_size(const rivid_state* state) { return rivid::state_size(state->state); }

int rivid_state_save(const rivid_state* state, void* bytes, size_t size) {
  return rivid::save_state(state->state, {static_cast<std::byte*>(bytes), size}) ? 1 : 0;
}

int rivid_state_restore(rivid_state* state, const void* bytes, size_t size) {
  const bool out = bool{rivid::restore_state(state->state, {static_cast<const std::byte*>(bytes), size})};
  state->changes = state->state.payload_changes();
  return out ? 1 : 0;
}
