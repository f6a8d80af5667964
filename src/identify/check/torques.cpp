// Torques against what one set of parameters can make of the motion; and, where that fails, against motions
// and torques with one thing changed: the change that mends the fit, or makes inertia and friction positive,
// is what was wrong.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "identify/check/checks.hpp"
#include "identify/check/torque_probe.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Squared part of a joint's torque that the model leaves: from here on something is looked for, and from
// there on it is reported even where nothing is found.
constexpr double suspicious = 0.003;
constexpr double hopeless = 0.5;
// A change is believed where it leaves this part of what was left, or where it mends signs and makes nothing
// worse.
constexpr double convincing = 0.5;
constexpr double convincing_elsewhere = 0.6;  // of each half, with the parameters of the other one
// Halves that leave less of each other foretell each other.
constexpr double mostly_explained = 0.25;
// factor of what is left (squared) that counts as equal where faults go; a choice
constexpr double no_worse = 1.05;
constexpr double tie = 1.005;  // of two changes that fit as well, the first counts
// A delay is believed where it leaves this part of what was left (squared), in each half of the logs too, is
// so many samples long, and differs between the halves by no more than a part of itself.
constexpr double delay_convincing = 0.7;
constexpr double least_delay_samples = 2.0;
constexpr double same_delay = 0.25;
constexpr double longest_torque_delay = 0.3;  // [s] that is searched; a choice
// Where no more is left than this, a delay does no harm.
constexpr double harmless_delay = 1e-4;

// A change of a reading and what it would be called.
struct OtherReading {
  std::string_view code;
  std::string subject;
  std::string text;
  Reading reading;
};

std::string joint_name(const Robot& robot, Index j) { return robot.joints[static_cast<std::size_t>(j)].name; }

std::string base_name(const Robot& robot) { return robot.base.empty() ? "base" : robot.base; }

void add_sign_changes(const Robot& robot, const Reading& reading, std::vector<OtherReading>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    Reading r = reading;
    r.torque_sign[j] *= -1.0;
    out.push_back({"torque_sign", joint_name(robot, j), "its torque has the other sign", std::move(r)});
  }
  if (robot.size() > 1) {
    Reading all = reading;
    all.torque_sign *= -1.0;
    out.push_back({"torque_sign", "all joints", "all torques have the other sign", std::move(all)});
  }
  for (Index j = 0; j < robot.size(); ++j) {
    Reading r = reading;
    r.position_scale[j] *= -1.0;
    Reading both = r;
    both.torque_sign[j] *= -1.0;
    out.push_back({"position_sign", joint_name(robot, j), "its position has the other sign", std::move(r)});
    out.push_back({"position_sign", joint_name(robot, j), "its position and its torque have the other sign",
                   std::move(both)});
  }
}

// Zeros that are a quarter or half a turn away.
void add_zero_changes(const Robot& robot, const Reading& reading, std::vector<OtherReading>& out) {
  constexpr double quarter = 0.5 * std::numbers::pi;  // of a turn [rad]
  for (Index j = 0; j < robot.size(); ++j) {
    if (robot.joints[static_cast<std::size_t>(j)].type != JointType::revolute) {
      continue;
    }
    for (const double turns : {1.0, -1.0, 2.0}) {
      Reading r = reading;
      r.position_offset[j] += turns * quarter;
      out.push_back({"zero_offset", joint_name(robot, j),
                     "its zero is " + number(90.0 * turns) + "° away, offset = " +
                         number(turns * quarter, 6) + " for its column in [log] position",
                     std::move(r)});
    }
  }
}

void add_order_changes(const Robot& robot, const Reading& reading, std::vector<OtherReading>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    for (Index i = 0; i < j; ++i) {
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(j);
      const std::string pair = joint_name(robot, i) + " and " + joint_name(robot, j);
      Reading torques = reading;
      std::swap(torques.torque[a], torques.torque[b]);
      std::swap(torques.torque_sign[i], torques.torque_sign[j]);
      Reading positions = reading;
      std::swap(positions.position[a], positions.position[b]);
      std::swap(positions.position_scale[i], positions.position_scale[j]);
      Reading both = torques;
      both.position = positions.position;
      both.position_scale = positions.position_scale;
      out.push_back({"torque_order", pair, "their torques are exchanged", std::move(torques)});
      out.push_back({"position_order", pair, "their positions are exchanged", std::move(positions)});
      out.push_back({"joint_order", pair, "positions and torques are exchanged", std::move(both)});
    }
  }
  if (robot.size() > 2) {
    Reading reversed = reading;
    std::ranges::reverse(reversed.position);
    std::ranges::reverse(reversed.torque);
    reversed.position_scale.reverseInPlace();
    reversed.torque_sign.reverseInPlace();
    out.push_back({"joint_order", "all joints", "the columns run from tip to base", std::move(reversed)});
  }
}

void add_unit_changes(const Robot& robot, const Reading& reading, std::vector<OtherReading>& out) {
  for (const double scale : {degree, 1.0 / degree}) {
    const bool degrees = scale < 1.0;
    Reading every = reading;
    for (Index j = 0; j < robot.size(); ++j) {
      if (robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute) {
        Reading r = reading;
        r.position_scale[j] *= scale;
        every.position_scale[j] *= scale;
        out.push_back({"position_unit", joint_name(robot, j),
                       degrees ? "its position is in degrees" : "its position was turned from degrees twice",
                       std::move(r)});
      }
    }
    out.push_back({"position_unit", "all joints",
                   degrees ? "positions are in degrees" : "positions were turned from degrees twice",
                   std::move(every)});
  }
  for (const double scale : {0.5, 2.0, 1e-3, 1e3}) {
    const std::string times = number(1.0 / scale) + " times what it should be";
    Reading every = reading;
    every.position_scale *= scale;
    for (Index j = 0; robot.size() > 1 && j < robot.size(); ++j) {
      Reading r = reading;
      r.position_scale[j] *= scale;
      out.push_back({"position_scale", joint_name(robot, j), "its position is " + times, std::move(r)});
    }
    out.push_back({"position_scale", "all joints", "each position is " + times, std::move(every)});
  }
  for (Index j = 0; robot.size() > 1 && j < robot.size(); ++j) {
    for (const double scale : {1e-3, 1e3}) {
      Reading r = reading;
      r.torque_sign[j] *= scale;
      out.push_back({"torque_unit", joint_name(robot, j),
                     scale < 1.0 ? "its torque is a thousand times that of the others, as N·mm would be"
                                 : "its torque is a thousandth of that of the others, as kN·m would be",
                     std::move(r)});
    }
  }
}

void add_gravity_changes(const Robot& robot, const Reading& reading, std::vector<OtherReading>& out) {
  constexpr double standard_gravity = 9.80665;  // [m/s²] as Chain::gravity
  constexpr std::array axes = {"x", "y", "z"};
  const double g = reading.gravity.norm() > 0.0 ? reading.gravity.norm() : standard_gravity;
  if (reading.gravity.norm() > 0.0) {
    Reading r = reading;
    r.gravity.setZero();
    out.push_back(
        {"torque_without_gravity", "all joints", "torques hold nothing of the weight", std::move(r)});
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Reading r = reading;
      r.gravity = sign * g * Eigen::Vector3d::Unit(axis);
      if (!r.gravity.isApprox(reading.gravity)) {
        out.push_back({"gravity_direction", base_name(robot),
                       std::string("gravity points along ") + (sign < 0.0 ? "-" : "+") +
                           axes[static_cast<std::size_t>(axis)] + " of the base",
                       std::move(r)});
      }
    }
  }
}

// Every single change of a reading that is looked at. Those that change torques alone come first: they win
// ties.
std::vector<OtherReading> changes(const Robot& robot, const Reading& reading) {
  std::vector<OtherReading> out;
  add_sign_changes(robot, reading, out);
  add_order_changes(robot, reading, out);
  add_unit_changes(robot, reading, out);
  add_gravity_changes(robot, reading, out);
  add_zero_changes(robot, reading, out);
  return out;
}

// What an experiment would change to read its logs the other way. A column takes its sign, unit and zero with
// it.
std::vector<Change> changes_to_read(const Robot& robot, const Reading& before, const Reading& after) {
  std::vector<Change> out;
  const auto columns = [&](const std::string& key, const std::vector<Index> Reading::* column,
                           const Vector Reading::* scale, const Vector Reading::* offset) {
    for (Index j = 0; j < robot.size(); ++j) {
      const Index was = (after.*column)[static_cast<std::size_t>(j)];
      const Index from = std::ranges::find(before.*column, was) - (before.*column).begin();
      const double factor = (after.*scale)[j] / (before.*scale)[from];
      const double added = offset == nullptr ? 0.0 : (after.*offset)[j] - factor * (before.*offset)[from];
      const std::string joint = joint_name(robot, j);
      if (from != j) {
        out.push_back({.key = key + ".column", .joint = joint, .word = joint_name(robot, from)});
      }
      if (factor != 1.0) {
        out.push_back({key + ".scale", joint, {factor}});
      }
      if (added != 0.0) {
        out.push_back({key + ".offset", joint, {added}});
      }
    }
  };
  columns("log.position", &Reading::position, &Reading::position_scale, &Reading::position_offset);
  columns("log.torque", &Reading::torque, &Reading::torque_sign, nullptr);
  if (after.gravity != before.gravity) {
    const Eigen::Vector3d& g = after.gravity;
    out.push_back(g.norm() > 0.0 ? Change{.key = "robot.gravity", .numbers = {g[0], g[1], g[2]}}
                                 : Change{.key = "log.torque_without", .word = "gravity"});
  }
  return out;
}

bool only_signs(std::string_view code) { return code == "torque_sign" || code == "position_sign"; }

bool only_torques(std::string_view code) {
  return code == "torque_sign" || code == "torque_order" || code == "torque_unit";
}

// Signs of a torque and of its position are hard to distinguish where a joint hardly feels the others.
std::string rival(const TorqueProbe& probe, const OtherReading& best, const ProbeScore& score,
                  const Reading& before) {
  // factor of what is left (squared); a choice: the other sign is named up to it
  constexpr double nearly_as_well = 1.5;
  const bool torque = best.code == "torque_sign";
  if ((!torque && best.code != "position_sign") || best.subject == "all joints") {
    return "";
  }
  // The change of the one, made to the other.
  Reading other = before;
  other.torque_sign =
      before.torque_sign.cwiseProduct(best.reading.position_scale.cwiseQuotient(before.position_scale));
  other.position_scale =
      before.position_scale.cwiseProduct(best.reading.torque_sign.cwiseQuotient(before.torque_sign));
  const ProbeScore rivals = probe.score(other);
  return rivals.faults() == score.faults() && rivals.total < nearly_as_well * score.total
             ? std::string("; the other sign of its ") + (torque ? "position" : "torque") +
                   " does nearly as well"
             : "";
}

// Upside down, gravity turns the signs of first moments, which inertia hardly notices.
void check_gravity(const TorqueProbe& probe, const Robot& robot, const Reading& reading,
                   const ProbeScore& now, Findings& out) {
  // factor of what is left (squared); a choice: weak motions differ less by chance
  constexpr double clearly_better = 0.8;
  if (out.has("gravity_direction") || reading.gravity.norm() == 0.0) {
    return;
  }
  Reading other = reading;
  other.gravity *= -1.0;
  const ProbeScore upside_down = probe.score(other);
  // Each half of the logs with the other's parameters must say so too: where little is excited, either way
  // fits.
  if (upside_down.faults() <= now.faults() && upside_down.total < clearly_better * now.total &&
      probe.halves(other).left < clearly_better * probe.halves(reading).left) {
    out.add("gravity_direction", base_name(robot),
            "gravity points the other way: the model then leaves " +
                number(100.0 * std::sqrt(upside_down.total), 2) + " % of the torques instead of " +
                number(100.0 * std::sqrt(now.total), 2) + " %",
            changes_to_read(robot, reading, other));
  }
}

// A change and how the torques fit under it.
struct Mending {
  OtherReading change;
  ProbeScore score;
};

std::vector<Index> worst_first(const Vector& left) {
  std::vector<Index> out(static_cast<std::size_t>(left.size()));
  std::iota(out.begin(), out.end(), Index{0});
  std::ranges::stable_sort(out, std::greater{}, [&](Index j) { return left[j]; });
  return out;
}

// The change that mends most of what is wrong, by some of the rows; nothing where none does.
std::optional<Mending> likeliest(const TorqueProbe& probe, const Robot& robot, const Reading& reading) {
  const std::vector<JointFactor> factors = probe.factors(reading, Part::some);
  const ProbeScore now = probe.score(reading, factors);
  const std::vector<Index> order = worst_first(now.left);
  const double mends = (now.faults() > 0 ? no_worse : convincing) * now.total;
  std::optional<Mending> best;
  for (OtherReading& change : changes(robot, reading)) {
    const bool beyond = best && best->score.faults() == 0;  // what is better must fit better
    const double most = beyond ? std::min(mends, best->score.total / tie) : mends;
    const std::optional<ProbeScore> score = only_torques(change.code)
                                                ? probe.score_below(change.reading, most, factors)
                                                : probe.score_below(change.reading, Part::some, most, order);
    if (!score) {
      continue;
    }
    const bool mends_fit = score->total < convincing * now.total && score->faults() <= now.faults();
    const bool mends_signs = score->faults() < now.faults();
    if (!mends_fit && !mends_signs) {
      continue;
    }
    const bool better = !best || score->faults() < best->score.faults() ||
                        (score->faults() == best->score.faults() && tie * score->total < best->score.total);
    if (better) {
      best = Mending{std::move(change), *score};
    }
  }
  return best;
}

// "12 % of the torques instead of 34 %", of squared parts.
std::string instead(double now, double before, const std::string& of) {
  const double a = 100.0 * std::sqrt(now);
  const double b = 100.0 * std::sqrt(before);
  return number_beside(a, b, 2) + " %" + of + " instead of " + number_beside(b, a, 2) + " %";
}

// A way to read the logs and how well it fits.
struct Read {
  Reading reading;
  ProbeScore score;
};

// Looks for changes of the reading that mend what is wrong, one after the other; the reading that is believed
// at last. A change is believed where all rows, and each half of the logs with the parameters of the other
// one, say so.
Read mended(const TorqueProbe& probe, const Robot& robot, Findings& out) {
  Reading reading = probe.as_told();
  ProbeScore now = probe.score(reading, probe.told_factors());
  for (Index round = 0; round <= robot.size(); ++round) {
    if (now.left.maxCoeff() < suspicious && now.faults() == 0) {
      break;
    }
    std::optional<Mending> best = likeliest(probe, robot, reading);
    if (!best) {
      break;
    }
    best->score = probe.score(best->change.reading);
    const HalfScores before = probe.halves(reading);
    const HalfScores after = probe.halves(best->change.reading);
    // Signs alone are those of columns, and are told by halves that foretell each other.
    const bool mends_signs = best->score.faults() < now.faults() && after.faults < before.faults &&
                             only_signs(best->change.code) && after.left < mostly_explained &&
                             after.left < no_worse * before.left;
    const bool mends_fit =
        best->score.total < convincing * now.total && after.left < convincing_elsewhere * before.left;
    if (!mends_fit && !mends_signs) {
      break;
    }
    const OtherReading& change = best->change;
    // A unit is reported once, even where single joints were seen to leave their limits.
    const bool told =
        change.code == "position_unit" ? out.has(change.code) : out.has(change.code, change.subject);
    if (!told) {
      out.add(change.code, change.subject,
              change.text + ": the model then leaves " +
                  instead(best->score.total, now.total, " of the torques") +
                  ", of each half with the other's parameters " + instead(after.left, before.left, "") +
                  (mends_signs ? ", and inertia and friction are positive" : "") +
                  rival(probe, change, best->score, reading),
              changes_to_read(robot, reading, change.reading));
    }
    reading = change.reading;
    now = best->score;
  }
  return {std::move(reading), std::move(now)};
}

// Shifts of torques by whole samples, closer together near zero.
std::vector<Index> shifts_for(double f_m) {
  std::vector<Index> out = {0};
  const auto longest = static_cast<Index>(longest_torque_delay * f_m);
  for (Index s = 1; s <= longest; s = std::max(s + 1, s + s / 6)) {
    out.push_back(s);
    out.push_back(-s);
  }
  return out;
}

struct Delay {
  Index samples = 0;
  double left = 0.0;
};

Delay least_left(const TorqueProbe& probe, const Reading& reading, Part part,
                 const std::vector<Index>& shifts) {
  const Vector left = probe.left_at(reading, shifts, part);
  Index at = 0;
  const double least = left.minCoeff(&at);
  return {shifts[static_cast<std::size_t>(at)], least};
}

// Whether a half of the logs says so by itself.
bool half_has_delay(const TorqueProbe& probe, const Reading& reading, Part half,
                    const std::vector<Index>& shifts, const Delay& delay) {
  const Delay own = least_left(probe, reading, half, shifts);
  const auto apart = static_cast<double>(std::abs(own.samples - delay.samples));
  return own.left <= delay_convincing * probe.left_at(reading, {0}, half)[0] &&
         apart <= std::max(same_delay * static_cast<double>(std::abs(delay.samples)), least_delay_samples);
}

void check_delay(const TorqueProbe& probe, const Reading& reading, Findings& out) {
  const double f_m = probe.logs().front().log->f_m;
  const std::vector<Index> shifts = shifts_for(f_m);
  const double now = probe.left_at(reading, {0}, Part::some)[0];
  const Delay coarse = least_left(probe, reading, Part::some, shifts);
  const auto in = [&](Part half) { return half_has_delay(probe, reading, half, shifts, coarse); };
  if (coarse.samples == 0 || coarse.left > delay_convincing * now || !in(Part::first_half) ||
      !in(Part::second_half)) {
    return;
  }
  std::vector<Index> around;
  const Index width = std::min<Index>(std::abs(coarse.samples) / 6 + 1, 16);
  for (Index s = coarse.samples - width; s <= coarse.samples + width; ++s) {
    around.push_back(s);
  }
  const Delay found = least_left(probe, reading, Part::some, around);
  if (std::abs(static_cast<double>(found.samples)) < least_delay_samples) {
    return;
  }
  const bool harms = now > harmless_delay;
  const std::string samples = counted(std::abs(found.samples), "sample");
  const bool behind = found.samples > 0;
  out.add(harms ? "torque_delay" : "small_torque_delay", "all joints",
          "torques are " + samples + " (" + number(std::abs(static_cast<double>(found.samples)) / f_m, 2) +
              " s) " + (behind ? "behind" : "ahead of") + " the motion: the model then leaves " +
              number(100.0 * std::sqrt(found.left), 2) + " % of them instead of " +
              number(100.0 * std::sqrt(now), 2) + " %; " +
              (behind ? "add " + samples + " to" : "take " + samples + " from") + " [log] torque_lag",
          {{.key = "log.torque_lag", .numbers = {static_cast<double>(found.samples)}}});
}

void check_unexplained(const Robot& robot, const ProbeScore& score, Findings& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    if (score.left[j] > hopeless) {
      out.add("unexplained_torque", joint_name(robot, j),
              "the model leaves " + number(100.0 * std::sqrt(score.left[j]), 2) +
                  " % of its torque (mean taken off)");
    }
  }
}

void add_untested(const TorqueProbe& probe, const Robot& robot, Findings& out) {
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const JointFactor& factor = probe.told_factors()[j];
    const std::string& joint = robot.joints[j].name;
    if (factor.rows < TorqueProbe::wanted(factor) && !out.has("joint_still", joint)) {
      add_not_tested(joint, "sign, order, unit and delay of its columns", factor.rows,
                     TorqueProbe::wanted(factor), out);
    }
  }
}

}  // namespace

void check_torques(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base, Findings& out) {
  add_untested(probe, robot, out);
  const auto [reading, score] = mended(probe, robot, out);
  check_gravity(probe, robot, reading, score, out);
  check_delay(probe, reading, out);
  check_sizes(probe, robot, base, reading, score.chi, out);
  check_unexplained(robot, score, out);
}

}  // namespace rivid::detail
