#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "rivid/error.hpp"

namespace rivid::detail {

// throws InputError where there is a fault, in the name of the function `who` that was given it
inline void accept(std::string_view who, const std::optional<std::string>& fault) {
  if (fault) {
    throw InputError(std::string(who) + ": " + *fault);
  }
}

}  // namespace rivid::detail
