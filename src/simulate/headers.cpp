// What the headers of rivid::headers define, in the archive of rivid::rivid.
#define RIVID_DEFINITIONS

#include "rivid/model/mdh.hpp"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/robot_state.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

namespace rivid {

template class Dynamics<double>;
template class BasicInverseDynamics<double>;
template class ContactObserver<double>;
template class FrictionMonitor<double>;
template class PayloadEstimator<double>;
template class RecursiveIdentifier<double>;
template class RobotState<double>;

}  // namespace rivid
