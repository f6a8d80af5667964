#pragma once

#include <string>
#include <string_view>

#include "rivid/identify/covariance.hpp"
#include "rivid/identify/diagnostics.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/robust.hpp"

namespace rivid::detail {

// Numbers and findings as tables and reports tell them.

// A fraction in per cent; "-" where it is not finite.
[[nodiscard]] std::string percent(double fraction);
// A value with as many decimals as its deviation asks for; "-" where it is not finite.
[[nodiscard]] std::string with_decimals_of(double value, double sigma);

// What keeps a result from being identified; nothing where it is.
[[nodiscard]] std::string_view why_not(Status status);
// Where standard deviations come from.
[[nodiscard]] std::string in_words(const CovarianceReport& covariance);
[[nodiscard]] std::string in_words(const HausmanTest& hausman);
[[nodiscard]] std::string in_words(const TorqueLag& lag);
[[nodiscard]] std::string in_words(const RobustReport& robust);

}  // namespace rivid::detail
