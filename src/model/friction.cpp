#include "rivid/model/friction.hpp"

#include <array>

namespace rivid {

namespace {

using enum ParameterKind;
constexpr std::array viscous_parameters = {Fv};
constexpr std::array coulomb_parameters = {Fv, Fc};
constexpr std::array symmetric_parameters = {Fv, Fc, off};
constexpr std::array asymmetric_parameters = {Fv_plus, Fc_plus, Fv_minus, Fc_minus};
constexpr std::array<std::string_view, 5> names = {"none", "viscous", "coulomb", "symmetric", "asymmetric"};

}  // namespace

std::span<const ParameterKind> parameters(Friction law) {
  switch (law) {
    case Friction::viscous:
      return viscous_parameters;
    case Friction::coulomb:
      return coulomb_parameters;
    case Friction::symmetric:
      return symmetric_parameters;
    case Friction::asymmetric:
      return asymmetric_parameters;
    default:
      return {};
  }
}

std::string_view name(Friction law) { return names[static_cast<std::size_t>(law)]; }

}  // namespace rivid
