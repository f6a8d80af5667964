#pragma once

#include <string>
#include <string_view>

#include "rivid/identify/loop_factors.hpp"

// Requests for loops and their factors as bytes, for the way between machines. Every number comes back bit for bit.
namespace rivid {

[[nodiscard]] std::string encoded(const LoopRequest& request);

/// What encoded() wrote.
///
/// @param source  a name for messages
/// @throws InputError  where the content is none of that: another kind of content, another version, truncated, damaged
[[nodiscard]] LoopRequest decoded_loop_request(std::string_view content, std::string_view source);

/// Laid out as encoded(const FactorsFile&), with `rivid-LQ` before a request and `rivid-LL` before factors: these of all rows joint by
/// joint, of [W Y] where W took columns of V, then block by block.
[[nodiscard]] std::string encoded(const LoopFactors& factors);

/// @copydoc decoded_loop_request
[[nodiscard]] LoopFactors decoded_loop_factors(std::string_view content, std::string_view source);

}  // namespace rivid
