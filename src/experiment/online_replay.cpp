#include "rivid/experiment/online_replay.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/error.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// A contact that lasts is one event. The link is not known where the rows alone show it.
struct ContactEvents {
  bool before = false;
  void take(double t, const RobotState<double>& state, const std::vector<std::string>& joints,
            std::vector<OnlineReplay::Event>& to) {
    if (const Index link = state.observer().link(); state.contact() && !before) {
      to.push_back(
          {t, "external torque" + (link < 0 ? "" : " on " + joints[static_cast<std::size_t>(link)])});
    }
    before = state.contact();
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
std::string without_threshold(const ContactObserver<double>& contact, const OnlineReplayOptions& options,
                              const std::vector<std::string>& joints) {
  std::vector<std::string> out;
  for (Index j = 0; j < contact.size(); ++j) {
    if (!contact.learned(j)) {
      out.push_back(joints[static_cast<std::size_t>(j)]);
    }
  }
  constexpr double enough = 120.0;  // [s] to learn for; a choice
  return out.empty() ? ""
                     : "too little motion to learn thresholds of contacts: " + listed(out) + "; learn for " +
                           number(std::max(enough, 2.0 * options.learn)) +
                           " s of the motion that they are for (--learn), in a log at least twice as long";
}

// Ticks that were not as they should be.
std::string bad_ticks(const TickGate<double>::Counts& counts) {
  std::string out;
  for (const auto& [count, what] :
       {std::pair{counts.lost, "lost"}, std::pair{counts.gaps, "gaps"},
        std::pair{counts.not_finite, "without numbers"}, std::pair{counts.repeated, "repeated"},
        std::pair{counts.late, "late"}, std::pair{counts.glitches, "glitches"}}) {
    out += count == 0 ? "" : (out.empty() ? "ticks: " : ", ") + std::to_string(count) + " " + what;
  }
  return out;
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
    out = identify_payloads(arm, std::span(&loaded, 1), estimation,
                            {.gain_sigma = Vector::Constant(model.robot.size(), options.gain_sigma)});
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
  const Matrix q = log.q.transpose();
  const Matrix tau = effort(model.robot, log).transpose();
  options.state.payload.rows.f_m = log.f_m;
  options.state.learn = std::min(options.learn, 0.5 * static_cast<double>(q.cols()) / log.f_m);
  RobotState<double> state(model, dynamics, options.state);
  const Index step = std::max<Index>(std::lround(options.interval * log.f_m), 1);
  const Index records = (q.cols() + step - 1) / step;
  OnlineReplay out;
  out.source = log.source;
  out.f_m = log.f_m;
  for (const Joint& joint : model.robot.joints) {
    out.joints.push_back(joint.name);
  }
  out.t = out.suspicion = Vector::Zero(records);
  out.payload = Matrix::Zero(records, 6);
  out.torque_error = out.external = Matrix::Zero(records, n);
  ContactEvents touches;
  ChangeEvents changes;
  bool learned = false;
  for (Index k = 0; k < q.cols(); ++k) {
    const double t = static_cast<double>(k) / log.f_m;
    const Index changed = state.payload_changes();
    const TickQuality quality = state.update(log.t.size() == q.cols() ? log.t[k] : t, q.col(k), tau.col(k));
    if (quality.gap) {
      out.events.push_back({t, "gap: " + counted(quality.lost, "tick") + " lost"});
    }
    if (!learned && state.left_to_learn() == 0.0) {
      learned = true;
      if (const std::string blind = without_threshold(state.observer(), options, out.joints);
          !blind.empty()) {
        out.events.push_back({options.state.learn, blind});
      }
    }
    touches.take(t, state, out.joints, out.events);
    if (state.payload_changes() != changed) {
      out.events.push_back({t, "the payload changes"});
      out.since = t;
    }
    changes.take(t, state.estimator().change(), out.events);
    if (k % step == 0) {
      const Index r = k / step;
      const OnlinePayload<double>& p = state.payload();
      out.t[r] = t;
      out.payload.row(r) << p.mass, p.mass_half_width(), p.com.transpose(), p.com_half_width();
      out.suspicion[r] = state.estimator().suspicion();
      out.external.row(r) = state.observer().relative().transpose();
      out.torque_error.row(r) = state.friction_gained().transpose();
    }
  }
  state.finish();
  out.last = state.payload();
  if (const std::string bad = bad_ticks(state.counts()); !bad.empty()) {
    out.events.push_back({static_cast<double>(q.cols()) / log.f_m, bad});
  }
  const PayloadReport judged =
      judged_from(model, log, std::lround(out.since * log.f_m), options.state.payload);
  out.warnings = judged.warnings;
  out.last.good = out.last.good && out.warnings.empty();
  out.last.held = out.last.held && std::ranges::none_of(judged.payloads, &Payload::none);
  return out;
}

}  // namespace rivid
