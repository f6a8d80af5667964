// A controller that links rivid::runtime: result.json → torques and the state of a shift. Without an argument
// it says its name: the test looks at what it is linked to.
#include <cstdio>

#include "rivid/experiment/result_file.hpp"
#include "rivid/online.h"
#include "rivid/online/robot_state.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::puts("runtime_consumer");
    return 0;
  }
  using rivid::Vector;
  const rivid::DynamicModel model = rivid::read_identified_model(argv[1]);
  rivid::RobotState<double> state(rivid::read_online_model(argv[1]), model);
  rivid::InverseDynamics dynamics(model);
  char message[200];
  rivid_state* const c = rivid_state_new(argv[1], 1000.0, 0.0, nullptr, 1, 120.0, message, sizeof message);
  if (c == nullptr) {
    std::puts(message);
    return 1;
  }
  const Vector q = Vector::Constant(model.size(), 0.3);
  const Vector rest = Vector::Zero(model.size());
  Vector tau(model.size());
  dynamics.torque(q, rest, rest, tau);
  bool same = true;
  for (int k = 0; k < 1000; ++k) {
    const double t = 1e-3 * k;
    state.update(t, q, tau);
    same = same && rivid_state_update(c, t, q.data(), tau.data(), nullptr) == (state.contact() ? 1 : 0);
  }
  rivid_payload_numbers payload;
  rivid_state_payload(c, &payload);
  same = same && payload.mass == state.payload().mass;
  rivid_state_delete(c);
  const Vector found = state.feedforward(q, rest, rest);
  std::printf("%s, %.3f\n", same ? "C and C++ agree" : "C differs", (found - tau).cwiseAbs().maxCoeff());
  return 0;
}
