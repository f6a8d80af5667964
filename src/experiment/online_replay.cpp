#include "rivid/experiment/online_replay.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/error.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

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

// Which joints have learned no threshold and see no contact; empty: all have.
std::string without_threshold(const ContactObserver<double>& contact,
                              const std::vector<std::string>& joints) {
  std::vector<std::string> out;
  for (Index j = 0; j < contact.size(); ++j) {
    if (!contact.learned(j)) {
      out.push_back(joints[static_cast<std::size_t>(j)]);
    }
  }
  return out.empty() ? "" : "too little motion to learn thresholds of contacts: " + listed(out);
}

// The payload of a log from some row on by identify_payloads(), judged; nothing where so little is moved that
// there is none.
PayloadReport judged_from(const OnlineModel& model, const Log& log, Index row,
                          const PayloadEstimatorOptions& options) {
  const Log since = excerpt(log, row, log.samples() - row);
  const LoadedLogs loaded{.name = log.source, .logs = std::span(&since, 1)};
  const IdentifiedArm arm{.robot = model.robot,
                          .chi = model.chi,
                          .C_chi = model.C_chi,
                          .gain_slopes = Matrix::Zero(model.chi.size(), model.robot.size()),
                          .gain_covariance = {}};
  Estimation estimation{.method = Wls{}};
  estimation.signal.torque_held = options.rows.torque_held;
  PayloadReport out;
  try {
    out = identify_payloads(arm, std::span(&loaded, 1), estimation);
    examine(arm.robot, {}, std::span(&loaded, 1), estimation, out);
  } catch (const InputError&) {
  }
  std::erase_if(out.warnings, [](const Finding& f) { return severity(f) != Severity::error; });
  return out;
}

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
    if (const std::string blind = k == learned ? without_threshold(contact, out.joints) : "";
        !blind.empty()) {
      out.events.push_back({t, blind});
    }
    touches.take(t, contact.link(), out.joints, out.events);
    if (payload.update(q.col(k), tau.col(k))) {
      out.events.push_back({t, "the payload changes"});
      payload_named = false;
      out.since = t;
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
      out.payload.row(r) << p.mass, p.mass_half_width(), p.com.transpose(), p.com_half_width();
      out.suspicion[r] = payload.suspicion();
      out.external.row(r) = contact.relative().transpose();
      for (Index j = 0; j < n; ++j) {
        out.torque_error(r, j) = friction.torque_error(j);
      }
    }
  }
  payload.finish();
  out.last = payload.payload();
  const PayloadReport judged = judged_from(model, log, std::lround(out.since * log.f_m), options.payload);
  out.warnings = judged.warnings;
  out.last.good = out.last.good && out.warnings.empty();
  out.last.held = out.last.held && std::ranges::none_of(judged.payloads, &Payload::none);
  return out;
}

}  // namespace rivid
