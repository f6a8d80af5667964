#pragma once

#include <string>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// A designed motion as JSON, the content of plan.json; docs/excite.md describes its members.
[[nodiscard]] std::string to_json(const ExcitationPlan& plan, const Excitation& excitation,
                                  const Provenance& provenance);
/// The same of a forecast alone.
[[nodiscard]] std::string to_json(const ExcitationPlan& plan, const Forecast& forecast,
                                  const Provenance& provenance);

/// For people: what each parameter will be known to, and how much of each limit is used.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string summary(const Excitation& excitation, std::size_t screen = 0);
[[nodiscard]] std::string summary(const Forecast& forecast, std::size_t screen = 0);

/// A designed motion as one HTML page, the content of report.html: forecast standard deviations and why some
/// are large, the margins to each limit, the motion over time and in space with its obstacles, and the
/// information by joint. It holds all that it needs and loads nothing.
[[nodiscard]] std::string html_report(const ExcitationPlan& plan, const Excitation& excitation,
                                      const Provenance& provenance);
/// The same of a forecast alone.
///
/// @param motion  that was forecast, (n_m × n)
[[nodiscard]] std::string html_report(const ExcitationPlan& plan, const Motion& motion,
                                      const Forecast& forecast, const Provenance& provenance);

/// A motion as text, one row a sample: t, q1 …, qd1 …, qdd1 … and, where torques are predicted, tau1 …, in SI
/// units. read_csv() reads it as a log.
[[nodiscard]] std::string motion_csv(const Excitation& excitation);

}  // namespace rivid
