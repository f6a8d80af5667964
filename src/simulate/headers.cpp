// What the headers of rivid::headers define, in the archive of rivid::rivid.
#define RIVID_DEFINITIONS

#include "rivid/model/mdh.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

namespace rivid {

template class Dynamics<double>;
template class BasicInverseDynamics<double>;

}  // namespace rivid
