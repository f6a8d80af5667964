#include "rivid/report/online.hpp"

#include <array>

#include "csv_columns.hpp"
#include "report/documents.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

void detail::require_fitting(std::string_view who, const OnlineReplay& replay) {
  const Index records = replay.t.size();
  const Index n = std::ssize(replay.joints);
  const auto require = [&](const char* name, const auto& x, Index columns) {
    if (x.rows() != records || x.cols() != columns) {
      throw InputError(std::string(who) + ": " + name + " of the replay is " + std::to_string(x.rows()) +
                       " × " + std::to_string(x.cols()) + ", must be " + std::to_string(records) + " × " +
                       std::to_string(columns));
    }
  };
  require("payload", replay.payload, 6);
  require("suspicion", replay.suspicion, 1);
  require("torque_error", replay.torque_error, n);
  require("external", replay.external, n);
}

std::string to_csv(const OnlineReplay& replay) {
  detail::require_fitting("to_csv", replay);
  constexpr std::array names = {"mass", "mass_half_width", "com_x", "com_y", "com_z", "com_half_width"};
  const auto in_short = [](double value) { return number(value, 7); };
  detail::CsvColumns out(replay.t.size());
  out.add("t", replay.t.data(), [](double t) { return number(t, 9); });
  for (std::size_t c = 0; c < names.size(); ++c) {
    out.add(names[c], replay.payload.col(static_cast<Index>(c)).data(), in_short);
  }
  out.add("suspicion", replay.suspicion.data(), in_short);
  out.add_each("friction_error", replay.torque_error, in_short);
  out.add_each("external", replay.external, in_short);
  return out.text();
}

}  // namespace rivid
