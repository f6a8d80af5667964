#include "identify/dissipative.hpp"

#include <algorithm>
#include <array>

namespace rivid::detail {

void make_dissipative(const BaseParameters& base, const Vector& mean_speed, const Vector& mean_square,
                      Vector& chi_st) {
  using enum ParameterKind;
  constexpr std::array<std::pair<ParameterKind, ParameterKind>, 3> pairs = {
      {{Fv, Fc}, {Fv_plus, Fc_plus}, {Fv_minus, Fc_minus}}};
  const auto find = [&](ParameterKind kind, int joint) {
    const auto at = std::ranges::find_if(
        base.standard, [&](const StandardParameter& p) { return p.kind == kind && p.joint == joint; });
    return at == base.standard.end() ? nullptr : &chi_st[at - base.standard.begin()];
  };
  for (int joint = 0; joint < static_cast<int>(mean_speed.size()); ++joint) {
    for (const auto& [viscous, coulomb] : pairs) {
      double* const v = find(viscous, joint);
      double* const c = find(coulomb, joint);
      if (v == nullptr || c == nullptr) {
        continue;
      }
      if (*v < 0.0) {
        *c += *v * mean_speed[joint];
        *v = 0.0;
      }
      // Asymmetric friction may be shifted by an offset: its mean tells whether it brakes.
      const double* const other = coulomb == Fc_plus    ? find(Fc_minus, joint)
                                  : coulomb == Fc_minus ? find(Fc_plus, joint)
                                                        : c;
      if (*c < 0.0 && (other == nullptr || *c + *other < 0.0)) {
        *v += mean_square[joint] > 0.0 ? *c * mean_speed[joint] / mean_square[joint] : 0.0;
        *c = 0.0;
      }
      *v = std::max(*v, 0.0);
    }
  }
}

}  // namespace rivid::detail
