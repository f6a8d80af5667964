#pragma once

#include <ostream>

#include "rivid/identify/identification.hpp"

namespace rivid {

/// Prints a result for people: verdict, parameters with their statistics and regrouping, fit joint by joint,
/// validation, the physically consistent parameters and their price. UTF-8, at most some 110 columns wide.
std::ostream& operator<<(std::ostream& out, const Identification& result);

}  // namespace rivid
