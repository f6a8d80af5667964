#include "report/words.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// A value shows as many decimals as its deviation has four significant digits; more would be noise.
int decimals_for(double sigma) {
  constexpr int significant = 4;
  constexpr int most = 9;
  return std::clamp(significant - 1 - static_cast<int>(std::floor(std::log10(sigma))), 0, most);
}

}  // namespace

std::string percent(double fraction) {
  constexpr int decimals = 3;
  return std::isfinite(fraction) ? fixed(100.0 * fraction, decimals) + " %" : "-";
}

std::string with_decimals_of(double value, double sigma) {
  if (!std::isfinite(value)) {
    return "-";
  }
  const bool plain = std::isfinite(sigma) && sigma > 1e-6 && std::abs(value) < 1e9;
  return plain ? fixed(value, decimals_for(sigma)) : number(value, 6);
}

std::string_view why_not(Status status) {
  switch (status) {
    case Status::identified:
      return "";
    case Status::rank_deficient:
      return "the data do not determine all parameters";
    case Status::not_converged:
      return "the iteration did not settle";
    case Status::cycling:
      return "the iteration goes round among a few estimates";
    case Status::weak_instruments:
      return "the simulated motion says too little about some parameters";
    case Status::not_simulable:
      break;
  }
  return "no closed loop could be simulated with the estimate";
}

std::string in_words(const CovarianceReport& covariance) {
  if (covariance.kind == CovarianceKind::hac) {
    return "from the residuals, correlated over " + number(covariance.lag, 3) + " s (Newey-West)";
  }
  std::string out = "as if residuals were independent (classical)";
  if (covariance.decimation_factor != 1.0) {
    out += ", divided by " + number(covariance.decimation_factor, 3) + " to undo the decimation";
  }
  return out;
}

// p tells whether a difference is seen at all, the shift whether it matters.
std::string in_words(const HausmanTest& hausman) {
  constexpr double significant = 0.05;
  constexpr double small_shift = 1.0;
  const std::string figures = " (Durbin-Wu-Hausman: p = " + number(hausman.test.p, 2) + ", largest shift " +
                              number(hausman.largest_shift, 2) + " sigma, of " + hausman.parameter + ")";
  if (!(hausman.test.p < significant)) {
    return "Least squares on these rows gives the same" + figures;
  }
  return (hausman.largest_shift < small_shift
              ? "Least squares on these rows differs, by less than the error bars"
              : "Least squares on these rows is biased: instruments were needed") +
         figures;
}

std::string in_words(const TorqueLag& lag) {
  return "Torques lag the motion by " + fixed(lag.samples, 2) + " ± " + fixed(lag.sigma, 2) +
         " samples, which moves " + lag.parameter + " by " + number(lag.largest_shift, 2) + " sigma";
}

std::string in_words(const RobustReport& robust) {
  std::string out = robust.options.kind == RobustKind::huber ? "Huber's loss" : "Bisquare loss";
  out += ", tuning " + number(robust.options.loss().tuning, 4) + ", in " + counted(robust.rounds, "round") +
         "; against the estimate without it ";
  return robust.parameter.empty()
             ? out + "nothing moves"
             : out + robust.parameter + " moves the most, by " + number(robust.largest_shift, 2) + " sigma";
}

}  // namespace rivid::detail
