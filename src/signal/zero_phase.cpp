#include "forward_backward.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid {

Matrix zero_phase(const Eigen::Ref<const Matrix>& x, const Filter& filter, Convention convention) {
  return detail::forward_backward("zero_phase", x, filter, convention, 0, 1);
}

Matrix zero_phase(const Eigen::Ref<const Matrix>& x, double f_m, double cutoff_hz, int order,
                  Convention convention) {
  return zero_phase(x, butterworth(order, cutoff_hz, f_m), convention);
}

}  // namespace rivid
