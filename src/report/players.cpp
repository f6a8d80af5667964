#include "rivid/report/players.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "joined.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Decimals of positions, velocities and coefficients: far below what an encoder resolves, and no exponents,
// which not every reader of such files knows.
constexpr int player_decimals = 12;
constexpr double libfranka_hz = 1000.0;  // [Hz] of its control interface
constexpr Index libfranka_joints = 7;    // of an arm that it controls
constexpr Index ur_joints = 6;           // of an arm of Universal Robots

std::string in_brackets(const Vector& values) {
  return "[" + detail::joined(values, ", ", [](double x) { return fixed(x, player_decimals); }) + "]";
}

struct PlayedState {
  Vector q;
  Vector qd;
  Vector qdd;
};

PlayedState played_at(const Reference& reference, double t) {
  const Index n = reference.joints();
  PlayedState out{Vector(n), Vector(n), Vector(n)};
  reference.at(t, out.q, out.qd, out.qdd);
  return out;
}

// What a person must know before pressing play, as comments.
std::string opening_comment(const Robot& robot, const Excitation& excitation) {
  std::string out = "# Written by rivid excite for " + on_one_line(robot.name) + ": " +
                    number(excitation.reference()->duration(), 6) +
                    " s from rest to rest.\n# Rest pose at both ends:";
  for (const double q : excitation.motion.q.row(0)) {
    out += " " + number(q, 6);
  }
  out += "\n# Largest use of each limit:";
  std::string separator = " ";
  for (const char* const quantity : {"position", "velocity", "acceleration", "jerk", "torque"}) {
    double most = -1.0;
    for (const LimitUse& use : excitation.forecast.limits) {
      most = use.quantity == quantity ? std::max(most, use.share) : most;
    }
    if (most >= 0.0) {
      out += separator + std::string(quantity) + " " + fixed(100.0 * most, 1) + " %";
      separator = ", ";
    }
  }
  const std::vector<ClearanceUse>& pairs = excitation.forecast.clearances;
  const auto left_out =
      std::ranges::find_if(pairs, [](const ClearanceUse& use) { return std::isnan(use.wanted); });
  const auto in_words = [](const ClearanceUse& use) {
    return number(use.distance, 4) + " m, " + on_one_line(use.first) + " from " + on_one_line(use.second);
  };
  out += pairs.begin() == left_out ? "\n# Collisions were not checked.\n"
                                   : "\n# Smallest distance: " + in_words(pairs.front()) + ".\n";
  const std::string near = detail::joined(std::ranges::subrange(left_out, pairs.end()), "; ", in_words);
  return out + (near.empty() ? "" : "# Not kept apart, since near in every pose: " + near + ".\n");
}

// Between points with positions, velocities and accelerations a controller's polynomials of fifth degree are
// off by A h⁶ / 46080 for a sine of amplitude A, h being the phase from point to point.
std::string joint_trajectory(const Robot& robot, const Excitation& excitation) {
  constexpr double points_a_second = 50.0;  // [Hz] at least; a choice, for motions without a highest harmonic
  // of the highest harmonic: off by 2e-8 of its amplitude, by the formula above
  constexpr double points_a_period = 20.0;
  const std::unique_ptr<const Reference> reference = excitation.reference();
  const double duration = reference->duration();
  const double highest_hz = excitation.series ? static_cast<double>(excitation.series->A.cols()) *
                                                    excitation.series->omega_f / (2.0 * std::numbers::pi)
                                              : 0.0;
  const auto intervals = static_cast<std::int64_t>(
      std::ceil(duration * std::max(points_a_second, points_a_period * highest_hz) - 1e-9));
  const auto name = [](const Joint& joint) { return nlohmann::json(joint.name).dump(); };
  std::string out = opening_comment(robot, excitation) + "joint_names: [" +
                    detail::joined(robot.joints, ", ", name) + "]\npoints:\n";
  for (std::int64_t k = 0; k <= intervals; ++k) {
    constexpr double in_nanoseconds = 1e9;  // of a second
    const auto nanoseconds = static_cast<std::int64_t>(
        std::llround(in_nanoseconds * duration * static_cast<double>(k) / static_cast<double>(intervals)));
    const PlayedState at = played_at(*reference, static_cast<double>(nanoseconds) / in_nanoseconds);
    out += "- positions: " + in_brackets(at.q) + "\n  velocities: " + in_brackets(at.qd) +
           "\n  accelerations: " + in_brackets(at.qdd) +
           "\n  time_from_start: {sec: " + std::to_string(nanoseconds / 1'000'000'000) +
           ", nanosec: " + std::to_string(nanoseconds % 1'000'000'000) + "}\n";
  }
  return out;
}

// Lists of some hundred numbers are what the interpreter can hold; the samples are not.
constexpr std::string_view ur_template =
    R"(# q_j(t) = q0_j + sum over l of A_jl / (l omega) sin(l omega t) - B_jl / (l omega) cos(l omega t)
# A and B: six numbers for the first harmonic, six for the second, and so on.
def rivid_excitation():
  omega = @omega
  duration = @duration
  A = @A
  B = @B
  movej(@begin, a=0.5, v=0.3)
  step = get_steptime()
@lead_in  t = 0.0
  while t < duration:
    t = t + step
    if t > duration:
      t = duration
    end
    q = @q0
    l = 0
    while l < @harmonics:
      w = omega * (l + 1)
      s = sin(w * t) / w
      c = cos(w * t) / w
      j = 0
      while j < @joints:
        q[j] = q[j] + A[@joints * l + j] * s - B[@joints * l + j] * c
        j = j + 1
      end
      l = l + 1
    end
    servoj(q, t=step, lookahead_time=0.1, gain=300)
  end
@lead_out  stopj(2.0)
end
)";

// A quintic move.
constexpr std::string_view ur_move =
    R"(  way = @way
  seconds = @seconds
  t = 0.0
  while t < seconds:
    t = t + step
    if t > seconds:
      t = seconds
    end
    u = t / seconds
    u = u * u * u * (10.0 + u * (6.0 * u - 15.0))
    q = @from
    j = 0
    while j < @joints:
      q[j] = q[j] + u * way[j]
      j = j + 1
    end
    servoj(q, t=step, lookahead_time=0.1, gain=300)
  end
)";

std::string filled(std::string_view text, const std::vector<std::pair<std::string, std::string>>& values) {
  std::string out(text);
  for (const auto& [name, value] : values) {
    for (std::size_t at = out.find(name); at != std::string::npos; at = out.find(name, at + value.size())) {
      out.replace(at, name.size(), value);
    }
  }
  return out;
}

std::string ur_moves(const std::optional<PointToPoint>& lead) {
  std::string out;
  for (Index i = 0; lead && i < lead->durations.size(); ++i) {
    out += filled(ur_move, {{"@way", in_brackets(lead->via.row(i + 1) - lead->via.row(i))},
                            {"@from", in_brackets(lead->via.row(i))},
                            {"@seconds", fixed(lead->durations[i], player_decimals)},
                            {"@joints", std::to_string(ur_joints)}});
  }
  return out;
}

std::string ur_program(const Robot& robot, const Excitation& excitation) {
  const FourierSeries& series = *excitation.series;
  return opening_comment(robot, excitation) +
         filled(ur_template, {{"@omega", fixed(series.omega_f, player_decimals)},
                              {"@duration", fixed(series.duration, player_decimals)},
                              {"@A", in_brackets(series.A.reshaped())},
                              {"@B", in_brackets(series.B.reshaped())},
                              {"@begin", in_brackets(excitation.motion.q.row(0))},
                              {"@q0", in_brackets(series.q0)},
                              {"@harmonics", std::to_string(series.A.cols())},
                              {"@joints", std::to_string(ur_joints)},
                              {"@lead_in", ur_moves(excitation.lead_in)},
                              {"@lead_out", ur_moves(excitation.lead_out)}});
}

std::string libfranka_rows(const Excitation& excitation) {
  std::string out = "t";
  for (const char* const name : {"q", "qd", "qdd"}) {
    for (Index j = 1; j <= libfranka_joints; ++j) {
      out += "," + std::string(name) + std::to_string(j);
    }
  }
  out += '\n';
  const std::unique_ptr<const Reference> reference = excitation.reference();
  const auto samples = static_cast<std::int64_t>(std::ceil(reference->duration() * libfranka_hz - 1e-6));
  for (std::int64_t k = 0; k <= samples; ++k) {
    const double t = static_cast<double>(k) / libfranka_hz;
    const PlayedState at = played_at(*reference, t);
    out += fixed(t, 3);
    for (const Vector* const values : {&at.q, &at.qd, &at.qdd}) {
      for (const double value : *values) {
        out += "," + fixed(value, player_decimals);
      }
    }
    out += '\n';
  }
  return out;
}

std::optional<std::string> joints_complaint(Player player, const Robot& robot, Index wanted) {
  const std::string who = "player \"" + std::string(name(player)) + "\": ";
  if (robot.size() != wanted) {
    return who + "the robot has " + counted(robot.size(), "joint") + ", must have " + std::to_string(wanted);
  }
  for (const Joint& joint : robot.joints) {
    if (joint.type != JointType::revolute) {
      return who + joint.name + " is prismatic, must be revolute";
    }
  }
  return std::nullopt;
}

}  // namespace

std::string_view file_name(Player player) {
  switch (player) {
    case Player::ros:
      return "joint_trajectory.yaml";
    case Player::urscript:
      return "motion.script";
    case Player::libfranka:
      break;
  }
  return "libfranka.csv";
}

std::optional<std::string> complaint(Player player, const Robot& robot, const ExcitationOptions& options) {
  if (player == Player::ros) {
    return std::nullopt;
  }
  if (player == Player::urscript) {
    if (options.curve != CurveKind::fourier) {
      return "player \"urscript\": the program evaluates a Fourier series; design one with curve = "
             "\"fourier\"";
    }
    return joints_complaint(player, robot, ur_joints);
  }
  if (auto fault = joints_complaint(player, robot, libfranka_joints)) {
    return fault;
  }
  if (options.limits.acceleration.size() == 0 || options.limits.jerk.size() == 0) {
    return "player \"libfranka\": the arm stops where a joint exceeds its acceleration or jerk; give both in "
           "[excitation.limits], as the arm's interface specification lists them";
  }
  const double samples = options.duration * libfranka_hz;
  if (std::abs(samples - std::round(samples)) > 1e-6) {
    return "player \"libfranka\": duration is " + number(options.duration) +
           " s, must be a whole number of milliseconds";
  }
  return std::nullopt;
}

std::string player_file(Player player, const Robot& robot, const ExcitationOptions& options,
                        const Excitation& excitation) {
  if (const auto fault = complaint(player, robot, options)) {
    throw InputError("player_file: " + *fault);
  }
  switch (player) {
    case Player::ros:
      return joint_trajectory(robot, excitation);
    case Player::urscript:
      return ur_program(robot, excitation);
    case Player::libfranka:
      break;
  }
  return libfranka_rows(excitation);
}

}  // namespace rivid
