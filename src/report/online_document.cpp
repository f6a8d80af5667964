#include <algorithm>
#include <array>
#include <cmath>

#include "csv_columns.hpp"
#include "report/document.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/report/online.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

using PayloadNow = OnlinePayload<double>;

// Refuses a replay whose series have other sizes than its instants and joints ask for.
void require_same_sizes(std::string_view who, const OnlineReplay& replay) {
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

std::string payload_words(const PayloadNow& p) {
  const bool known = std::isfinite(p.mass) && std::isfinite(p.mass_half_width());
  std::string out = !known   ? "mass not known"
                    : p.held ? "mass " + number(p.mass, 4) + " ± " + number(p.mass_half_width(), 2) + " kg"
                             : "no payload (less than " + number(p.mass + p.mass_half_width(), 2) + " kg)";
  if (p.held) {
    const Eigen::Vector3d mm = 1e3 * p.com;
    out += ", centre of mass [" + number(mm[0], 4) + ", " + number(mm[1], 4) + ", " + number(mm[2], 4) +
           "] ± " + number(1e3 * p.com_half_width(), 2) + " mm" + (p.body ? "" : ", inertia not seen");
  }
  return out + (p.good ? ", good enough to send" : ", not good enough to send");
}

// The lines that set the payload of a controller; none where it is not known well enough.
std::vector<std::string> controller_lines(const PayloadNow& p) {
  if (!p.held || !p.good) {
    return {};
  }
  Payload out;
  out.mass = p.mass;
  out.com = p.com;
  out.inertia = p.inertia;
  return {urscript_line(out), libfranka_line(out)};
}

// A chart over the time of the log, with the events as lines.
Chart replay_chart(const OnlineReplay& replay, const std::string& id, const std::string& title,
                   const std::string& y_label, std::vector<Series> series) {
  Chart out = time_chart(id, title, title + " over time", y_label, std::move(series));
  out.y_shown = {0.0};
  for (const OnlineReplay::Event& event : replay.events) {
    out.rules.push_back({true, event.t, "event"});
  }
  return out;
}

std::vector<Series> mass_curves(const OnlineReplay& replay) {
  const Vector mass = replay.payload.col(0);
  const Vector half = replay.payload.col(1);
  // Before anything is known the interval would flatten all else: it is drawn up to three times this at least
  // [kg].
  constexpr double least = 0.5;
  const double most = 3.0 * std::max(mass.size() > 0 ? mass.maxCoeff() : 0.0, least);
  return {{"95 % confidence interval", "measured", Series::Kind::band, replay.t,
           (mass - half).cwiseMax(-most), (mass + half).cwiseMin(most)},
          {"mass", "measured", Series::Kind::line, replay.t, mass}};
}

Section charts_section(const std::string& id, const std::string& title, const std::string& how_to_read,
                       std::vector<Plot> plots) {
  return {id, title, title, {{Sentence{how_to_read}}, plots_block("", std::move(plots))}, Shown::page};
}

// Joints without a threshold have no external torque over it.
Section contacts_section(const OnlineReplay& replay) {
  const std::string id = "contact";
  const std::string title = "Contacts";
  if (replay.external.isZero(0.0)) {
    return {id,
            title,
            title,
            {{Sentence{"No joint has learned a threshold, so that no contact can be detected"}}},
            Shown::page};
  }
  return charts_section(
      id, title, "Above 1: contact",
      {replay_chart(replay, "external", "External torque over its threshold", "torque over threshold",
                    curves(replay.t, replay.joints, replay.external))});
}

Document replay_document(const OnlineReplay& replay) {
  const Vector& t = replay.t;
  const std::string now = payload_words(replay.last);
  Document out{.title = replay.source + " · rivid online",
               .heading = replay.source,
               .subtitle = "replayed as a control loop would have seen it · " + number(replay.f_m) + " Hz",
               .line = replay.source + ", " + number(replay.f_m) + " Hz",
               .headline = "At the end: " + now,
               .verdict = replay.last.good ? Mark::good : Mark::mixed};
  out.opening = {{table_of(replay.events, {{{"", format::significant(5), "s"}, &OnlineReplay::Event::t},
                                           {{""}, &OnlineReplay::Event::text}})},
                 {FindingList{replay.warnings}},
                 {Sentence{"at the end: " + now}, Shown::screen}};
  if (const auto lines = controller_lines(replay.last); !lines.empty()) {
    out.opening.push_back(
        {table_of(lines, {{{"", format::code}, [](const std::string& line) { return line; }}}), Shown::page});
  }
  out.sections = {
      charts_section(
          "payload", "Payload",
          "Payload at the flange. Vertical lines are events: the payload changes where the test exceeds its "
          "threshold, 1",
          {replay_chart(replay, "mass", "Mass", "mass [kg]", mass_curves(replay)),
           replay_chart(replay, "centre-of-mass", "Centre of mass, flange frame", "centre of mass [m]",
                        curves(t, {"x", "y", "z"}, replay.payload.middleCols(2, 3))),
           replay_chart(replay, "change", "Test of a change of the payload over its threshold",
                        "test over threshold", curves(t, {"test"}, replay.suspicion))}),
      charts_section(
          "friction", "Friction",
          "Torque error by the drift of friction since the identification; identify again if it exceeds the "
          "residual of the identification",
          {replay_chart(replay, "friction-error", "Torque error by drifted friction",
                        "torque error [N·m or N]", curves(t, replay.joints, replay.torque_error))}),
      contacts_section(replay)};
  return out;
}

}  // namespace

}  // namespace detail

std::string to_csv(const OnlineReplay& replay) {
  detail::require_same_sizes("to_csv", replay);
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

std::string in_words(const OnlineReplay& replay, std::size_t screen) {
  detail::require_same_sizes("in_words", replay);
  std::string out = detail::text_of(detail::replay_document(replay), screen);
  for (const std::string& line : detail::controller_lines(replay.last)) {
    out += line + '\n';
  }
  return out;
}

std::string to_html(const OnlineReplay& replay) {
  detail::require_same_sizes("to_html", replay);
  if (replay.t.size() == 0) {
    throw InputError("to_html: the replay has no record");
  }
  return detail::html_of(detail::replay_document(replay));
}

}  // namespace rivid
