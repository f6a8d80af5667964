#include "rivid/identify/identification.hpp"

namespace rivid {

std::string_view name(Status status) {
  return status == Status::identified ? "identified" : "rank_deficient";
}

}  // namespace rivid
