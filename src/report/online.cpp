#include "rivid/report/online.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "report/markup.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/report/ticks.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr double plot_width = 900.0;
constexpr double plot_height = 220.0;
constexpr double plot_margin = 60.0;
constexpr std::array replay_colours = {"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                       "#ff7f0e", "#8c564b", "#17becf"};

struct ReplayCurve {
  std::string name;
  Vector y;
  std::string colour;
};

struct ReplayPlot {
  std::string title;
  std::string unit;
  std::vector<ReplayCurve> curves;
};

std::string replay_svg(const ReplayPlot& plot, const Vector& t,
                       const std::vector<OnlineReplay::Event>& events) {
  double low = 0.0;
  double high = 1e-3;
  for (const ReplayCurve& curve : plot.curves) {
    for (const double y : curve.y) {
      low = std::isfinite(y) ? std::min(low, y) : low;
      high = std::isfinite(y) ? std::max(high, y) : high;
    }
  }
  const std::vector<double> levels = round_ticks(low, high);
  low = levels.front();
  high = levels.back();
  const double end = t.size() > 0 ? std::max(t[t.size() - 1], 1e-9) : 1.0;
  const auto x_of = [&](double at) { return plot_margin + (plot_width - plot_margin) * at / end; };
  const auto y_of = [&](double y) { return 20.0 + (plot_height - 40.0) * (high - y) / (high - low); };
  std::string out = "<h2>" + detail::escaped(plot.title) + "</h2>\n<svg viewBox=\"0 0 " + number(plot_width) +
                    " " + number(plot_height) + "\" role=\"img\">\n";
  const auto line = [&](double x1, double y1, double x2, double y2, const char* colour) {
    out += "<line x1=\"" + number(x1, 5) + "\" y1=\"" + number(y1, 5) + "\" x2=\"" + number(x2, 5) +
           "\" y2=\"" + number(y2, 5) + "\" stroke=\"" + colour + "\"/>\n";
  };
  const auto label = [&](double x, double y, const std::string& text, const std::string& colour) {
    out += "<text x=\"" + number(x, 5) + "\" y=\"" + number(y, 5) + "\" fill=\"" + colour + "\">" +
           detail::escaped(text) + "</text>\n";
  };
  for (const double y : levels) {
    line(plot_margin, y_of(y), plot_width, y_of(y), "#ddd");
    label(2.0, y_of(y) + 4.0, number(y, 3), "#444");
  }
  for (const double at : round_ticks(0.0, end)) {
    if (at > end) {
      break;
    }
    label(std::min(x_of(at) - 10.0, plot_width - 30.0), plot_height - 2.0, number(at, 3) + " s", "#444");
  }
  for (const OnlineReplay::Event& event : events) {
    line(x_of(event.t), 20.0, x_of(event.t), plot_height - 20.0, "#999");
  }
  double legend = plot_margin + 5.0;
  for (const ReplayCurve& curve : plot.curves) {
    out += "<polyline fill=\"none\" stroke=\"" + curve.colour + "\" points=\"";
    for (Index k = 0; k < t.size(); ++k) {
      if (std::isfinite(curve.y[k])) {
        out += number(x_of(t[k]), 5) + "," + number(y_of(curve.y[k]), 5) + " ";
      }
    }
    out += "\"/>\n";
    label(legend, 14.0, curve.name, curve.colour);
    legend += 12.0 + 7.5 * static_cast<double>(curve.name.size());
  }
  label(plot_width - 60.0, 14.0, plot.unit, "#444");
  return out + "</svg>\n";
}

std::vector<ReplayCurve> curves_of_joints(const OnlineReplay& replay, const Matrix& columns) {
  std::vector<ReplayCurve> out;
  for (Index j = 0; j < columns.cols(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    out.push_back({replay.joints[at], columns.col(j), replay_colours[at % replay_colours.size()]});
  }
  return out;
}

// As a result that a controller takes is written.
Payload payload_of(const OnlinePayload<double>& found) {
  Payload out;
  out.mass = found.mass;
  out.com = found.com;
  out.inertia = found.inertia;
  return out;
}

// A contact that lasts is one event.
struct ContactEvents {
  Index link = -1;
  void take(double t, Index now, const std::vector<std::string>& joints,
            std::vector<OnlineReplay::Event>& to) {
    if (now >= 0 && link < 0) {
      to.push_back({t, "external torque on " + joints[static_cast<std::size_t>(now)]});
    }
    link = now;
  }
};

// What a change was, once it is known.
struct ChangeEvents {
  using Change = PayloadEstimator<double>::Change;
  Change::Kind known = Change::Kind::none;
  void take(double t, const Change& change, std::vector<OnlineReplay::Event>& to) {
    if (change.kind != known &&
        (change.kind == Change::Kind::pick_up || change.kind == Change::Kind::release)) {
      to.push_back({t, change.kind == Change::Kind::pick_up ? "it was a pick-up" : "it was a release"});
    }
    known = change.kind;
  }
};

}  // namespace

OnlineReplay replay(const OnlineModel& model, const ModelData& dynamics, const Log& log,
                    OnlineReplayOptions options) {
  if (const auto fault = log.complaint()) {
    throw InputError("replay: " + *fault);
  }
  const Index n = model.robot.size();
  if (log.q.cols() != n || dynamics.size() != n) {
    throw InputError("replay: " + log.source + " has " + counted(log.q.cols(), "joint") + ", the model has " +
                     std::to_string(n));
  }
  options.payload.rows.f_m = options.friction.rows.f_m = options.contact.f_m = log.f_m;
  PayloadEstimator<double> payload(model, options.payload);
  FrictionMonitor<double> friction(model, options.friction);
  ContactObserver<double> contact(dynamics, options.contact);
  const Matrix q = log.q.transpose();
  // As a loop has them: differences with the tick before.
  Matrix qd = Matrix::Zero(n, q.cols());
  if (q.cols() > 1) {
    qd.rightCols(q.cols() - 1) = (q.rightCols(q.cols() - 1) - q.leftCols(q.cols() - 1)) * log.f_m;
  }
  const Matrix tau = effort(model.robot, log).transpose();

  const Index step = std::max<Index>(std::lround(options.interval * log.f_m), 1);
  const Index records = (q.cols() + step - 1) / step;
  const Index learned = std::min(std::lround(options.learn * log.f_m), static_cast<long>(q.cols() / 2));
  OnlineReplay out;
  out.source = log.source;
  out.f_m = log.f_m;
  for (const Joint& joint : model.robot.joints) {
    out.joints.push_back(joint.name);
  }
  out.t = out.suspicion = Vector::Zero(records);
  out.payload = Matrix::Zero(records, 6);
  out.torque_error = out.external = Matrix::Zero(records, n);
  bool payload_named = false;  // to the observer of contacts, for which its weight is a push else
  ContactEvents touches;
  ChangeEvents changes;
  for (Index k = 0; k < q.cols(); ++k) {
    const double t = static_cast<double>(k) / log.f_m;
    using Mode = ContactObserver<double>::Mode;
    contact.update(q.col(k), qd.col(k), tau.col(k), k < learned ? Mode::learn : Mode::observe);
    touches.take(t, contact.link(), out.joints, out.events);
    if (payload.update(q.col(k), tau.col(k))) {
      out.events.push_back({t, "the payload changes"});
      payload_named = false;
    }
    if (!payload_named && payload.payload().good) {
      contact.set_payload(payload.inertial());
      payload_named = true;
    }
    changes.take(t, payload.change(), out.events);
    friction.set_payload(payload.inertial());
    friction.update(q.col(k), tau.col(k));
    if (k % step == 0) {
      const Index r = k / step;
      const OnlinePayload<double>& p = payload.payload();
      out.t[r] = t;
      out.payload.row(r) << p.mass, p.mass_half_width(), p.com.transpose(), 1.96 * p.com_sigma.maxCoeff();
      out.suspicion[r] = payload.suspicion();
      out.external.row(r) = contact.relative().transpose();
      for (Index j = 0; j < n; ++j) {
        out.torque_error(r, j) = friction.torque_error(j);
      }
    }
  }
  payload.finish();
  out.last = payload.payload();
  return out;
}

std::string to_csv(const OnlineReplay& replay) {
  std::string out = "t,mass,mass_half_width,com_x,com_y,com_z,com_half_width,suspicion";
  for (std::size_t j = 1; j <= replay.joints.size(); ++j) {
    out += ",friction_error" + std::to_string(j);
  }
  for (std::size_t j = 1; j <= replay.joints.size(); ++j) {
    out += ",external" + std::to_string(j);
  }
  out += '\n';
  for (Index k = 0; k < replay.t.size(); ++k) {
    out += number(replay.t[k], 9);
    const auto add = [&](double x) { out += "," + number(x, 7); };
    for (Index c = 0; c < replay.payload.cols(); ++c) {
      add(replay.payload(k, c));
    }
    add(replay.suspicion[k]);
    for (const Matrix* const columns : {&replay.torque_error, &replay.external}) {
      for (Index c = 0; c < columns->cols(); ++c) {
        add((*columns)(k, c));
      }
    }
    out += '\n';
  }
  return out;
}

std::string in_words(const OnlineReplay& replay) {
  std::string out = replay.source + ", " + number(replay.f_m) + " Hz\n";
  for (const OnlineReplay::Event& event : replay.events) {
    out += "  " + number(event.t, 5) + " s  " + event.text + '\n';
  }
  const OnlinePayload<double>& p = replay.last;
  out += "at the end: mass " + number(p.mass, 4) + " ± " + number(p.mass_half_width(), 2) + " kg";
  if (p.held) {
    out += ", centre of mass [" + number(1e3 * p.com[0], 4) + ", " + number(1e3 * p.com[1], 4) + ", " +
           number(1e3 * p.com[2], 4) + "] ± " + number(1.96e3 * p.com_sigma.maxCoeff(), 2) + " mm" +
           (p.body ? "" : ", inertia not seen");
  }
  out += p.good ? ", good enough to send\n" : ", not good enough to send\n";
  if (p.held && p.good) {
    out += urscript_line(payload_of(p)) + '\n' + libfranka_line(payload_of(p)) + '\n';
  }
  return out;
}

std::string to_html(const OnlineReplay& replay) {
  const Vector mass = replay.payload.col(0);
  const Vector half = replay.payload.col(1);
  // Before anything is known an interval would flatten all else.
  const double most = 3.0 * std::max(mass.size() > 0 ? mass.maxCoeff() : 0.0, 0.5);
  const auto shown = [&](const Vector& x) { return Vector(x.cwiseMin(most).cwiseMax(-most)); };
  const std::vector<ReplayPlot> plots = {
      {"Payload",
       "kg",
       {{"mass", mass, "#1f77b4"},
        {"95 % confidence", shown(mass + half), "#aac"},
        {"interval", shown(mass - half), "#aac"}}},
      {"Centre of mass, flange frame",
       "m",
       {{"x", replay.payload.col(2), "#1f77b4"},
        {"y", replay.payload.col(3), "#d62728"},
        {"z", replay.payload.col(4), "#2ca02c"}}},
      {"Test of a change of the payload, over its threshold", "1", {{"test", replay.suspicion, "#1f77b4"}}},
      {"Torque error by drifted friction", "N·m, N", curves_of_joints(replay, replay.torque_error)},
      {"External torque over its threshold", "1", curves_of_joints(replay, replay.external)}};
  std::string out =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>rivid_online</title>\n"
      "<style>body{font:14px sans-serif;max-width:60em;margin:1em auto}svg{width:100%;font-size:11px}"
      "h2{font-size:15px;margin:1em 0 0}pre{background:#f4f4f4;padding:.6em}</style></head><body>\n<h1>" +
      detail::escaped(replay.source) + "</h1>\n<pre>" + detail::escaped(in_words(replay)) + "</pre>\n";
  for (const ReplayPlot& plot : plots) {
    out += replay_svg(plot, replay.t, replay.events);
  }
  return out + "</body></html>\n";
}

}  // namespace rivid
