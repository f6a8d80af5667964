// Torques against what one set of parameters can make of the motion; and, where that fails, against motions
// and torques with one thing changed: the change that mends the fit, or makes inertia and friction positive,
// is what was wrong.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "identify/check/checks.hpp"
#include "identify/check/reading_changes.hpp"
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
// Where most of the torques is explained already, something else than a reading may be wrong with them.
constexpr double mostly_explained = 0.25;
constexpr double convincing_then = 0.25;
constexpr double convincing_elsewhere_then = 0.3;
constexpr double no_worse = 1.05;
constexpr double tie = 1.005;  // of two changes that fit as well, the first counts
// A delay is believed where it leaves this part of what was left (squared), and is so many samples long.
constexpr double delay_convincing = 0.6;
constexpr double least_delay_samples = 2.0;
constexpr double longest_torque_delay = 0.3;  // [s]
// It does harm where so much is left, or where it is behind most of what is left.
constexpr double harmless_delay = 0.01;
constexpr double harmful_gain = 0.4;

bool only_signs(std::string_view code) { return code == "torque_sign" || code == "position_sign"; }

bool only_torques(std::string_view code) {
  return code == "torque_sign" || code == "torque_order" || code == "torque_unit";
}

// Signs of a torque and of its position are hard to distinguish where a joint hardly feels the others.
std::string rival(const TorqueProbe& probe, const Change& best, const ProbeScore& score,
                  const Reading& before) {
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
                number(100.0 * std::sqrt(now.total), 2) + " %");
  }
}

// A change and how the torques fit under it.
struct Mending {
  Change change;
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
  for (Change& change : changes(robot, reading)) {
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
    const bool doubted = before.left < mostly_explained;
    const bool mends_fit =
        best->score.total < (doubted ? convincing_then : convincing) * now.total &&
        after.left < (doubted ? convincing_elsewhere_then : convincing_elsewhere) * before.left;
    if (!mends_fit && !mends_signs) {
      break;
    }
    const Change& change = best->change;
    // A unit is reported once, even where single joints were seen to leave their limits.
    const bool told =
        change.code == "position_unit" ? out.has(change.code) : out.has(change.code, change.subject);
    if (!told) {
      out.add(change.code, change.subject,
              change.text + ": the model then leaves " +
                  instead(best->score.total, now.total, " of the torques") +
                  ", of each half with the other's parameters " + instead(after.left, before.left, "") +
                  (mends_signs ? ", and inertia and friction are positive" : "") +
                  rival(probe, change, best->score, reading));
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

Delay least_left(const TorqueProbe& probe, const Reading& reading, const std::vector<Index>& shifts,
                 Part part) {
  const Vector left = probe.left_at(reading, shifts, part);
  Index at = 0;
  const double least = left.minCoeff(&at);
  return {shifts[static_cast<std::size_t>(at)], least};
}

// Whether each half of the logs says so by itself.
bool halves_agree(const TorqueProbe& probe, const Reading& reading, const std::vector<Index>& shifts,
                  Index samples) {
  constexpr double same = 0.2;
  for (const Part part : {Part::first_half, Part::second_half}) {
    const double now = probe.left_at(reading, {0}, part)[0];
    const Delay found = least_left(probe, reading, shifts, part);
    const auto difference = static_cast<double>(std::abs(found.samples - samples));
    if (found.left > delay_convincing * now ||
        difference > std::max(least_delay_samples, same * std::abs(static_cast<double>(samples)))) {
      return false;
    }
  }
  return true;
}

void check_delay(const TorqueProbe& probe, const Reading& reading, Findings& out) {
  const double f_m = probe.logs().front().log->f_m;
  const double now = probe.left_at(reading, {0}, Part::some)[0];
  const std::vector<Index> shifts = shifts_for(f_m);
  const Delay coarse = least_left(probe, reading, shifts, Part::some);
  if (coarse.samples == 0 || coarse.left > delay_convincing * now ||
      !halves_agree(probe, reading, shifts, coarse.samples)) {
    return;
  }
  std::vector<Index> around;
  const Index width = std::min<Index>(std::abs(coarse.samples) / 6 + 1, 16);
  for (Index s = coarse.samples - width; s <= coarse.samples + width; ++s) {
    around.push_back(s);
  }
  const Delay found = least_left(probe, reading, around, Part::some);
  if (std::abs(static_cast<double>(found.samples)) < least_delay_samples) {
    return;
  }
  // Where the torques are explained well nevertheless, a delay changes little.
  const bool harms = now > harmless_delay || found.left < harmful_gain * now;
  const std::string samples = counted(std::abs(found.samples), "sample");
  const bool behind = found.samples > 0;
  out.add(harms ? "torque_delay" : "small_torque_delay", "all joints",
          "torques are " + samples + " (" + number(std::abs(static_cast<double>(found.samples)) / f_m, 2) +
              " s) " + (behind ? "behind" : "ahead of") + " the motion: the model then leaves " +
              number(100.0 * std::sqrt(found.left), 2) + " % of them instead of " +
              number(100.0 * std::sqrt(now), 2) + " %; " +
              (behind ? "add " + samples + " to" : "take " + samples + " from") + " [log] torque_lag");
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

}  // namespace

void check_torques(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base, Findings& out) {
  const auto [reading, score] = mended(probe, robot, out);
  check_gravity(probe, robot, reading, score, out);
  check_delay(probe, reading, out);
  check_sizes(probe, robot, base, reading, score.chi, out);
  check_unexplained(robot, score, out);
}

}  // namespace rivid::detail
