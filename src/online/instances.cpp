// The estimators of rivid::headers for double, in the archives: who links one need not compile them.

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/robot_state.hpp"

namespace rivid {

template class ContactObserver<double>;
template class FrictionMonitor<double>;
template class PayloadEstimator<double>;
template class RecursiveIdentifier<double>;
template class RobotState<double>;

}  // namespace rivid
