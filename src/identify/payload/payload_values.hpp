#pragma once

#include <string>

#include "identify/payload/payload_model.hpp"

namespace rivid::detail {

// What a settled fit says of payload k, in the flange frame.
[[nodiscard]] Payload payload_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                 PayloadModel shape, const PayloadOptions& options);

// What payload k has that payload `from` had not, as a body of its own, in the flange frame.
[[nodiscard]] Payload difference_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                                    std::size_t from, PayloadModel shape, const PayloadOptions& options);

// Where there is none: there is no centre of mass then.
void tell_mass_alone(Payload& payload);

// Why a body is none, or its inertia is not identifiable; empty where it is reported.
[[nodiscard]] std::string hidden_inertia(const Payload& body);

}  // namespace rivid::detail
