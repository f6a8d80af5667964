#include "excite/design_parts.hpp"
#include "rivid/error.hpp"

// In place of mma.cpp where rivid is built without NLopt.
namespace rivid::detail {

MmaResult minimised(const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& /*f*/, Vector /*z*/,
                    const MmaOptions& /*options*/) {
  throw InputError(
      "design: this rivid was built without NLopt, which designing a motion needs; install libnlopt-dev "
      "and build with -DRIVID_NLOPT=ON");
}

}  // namespace rivid::detail
