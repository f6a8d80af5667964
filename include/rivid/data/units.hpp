#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rivid {

/// Factor from a unit to SI: x [unit] · unit_scale(unit) is x in rad, m, s, N·m, N, V, A, rad/s or m/s.
///
/// Known: 1; rad deg; m mm um; s ms us ns; Nm mNm kNm (also N·m); N kN; V mV; A mA; rad/s deg/s rpm; m/s
/// mm/s.
///
/// @throws InputError  for any other word, with the list
[[nodiscard]] double unit_scale(std::string_view unit);

/// What is wrong with the name of a unit, with the list; nothing where unit_scale() knows it.
[[nodiscard]] std::optional<std::string> unit_complaint(std::string_view unit);

}  // namespace rivid
