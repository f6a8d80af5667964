#pragma once

#include <string>

#include "identify/payload/payload_model.hpp"

namespace rivid::detail {

// What a settled fit says of payload k, in the flange frame: of what it does not show only why.
[[nodiscard]] Payload payload_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                 const PayloadOptions& options);

// What payload k has that payload `from` had not, as a body of its own, in the flange frame.
[[nodiscard]] Payload difference_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                    std::size_t from, const PayloadOptions& options);

}  // namespace rivid::detail
