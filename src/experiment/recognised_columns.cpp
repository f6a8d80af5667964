#include "experiment/recognised_columns.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "data/dialect.hpp"
#include "data/log_columns.hpp"
#include "joined.hpp"
#include "rivid/data/log.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_lower(char c) { return c >= 'a' && c <= 'z'; }

std::string in_small_letters(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](char c) { return is_upper(c) ? static_cast<char>(c + 32) : c; });
  return out;
}

// Bytes of characters beyond ASCII are letters too.
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
}

// A name without its unit: "Axis1 Torque [Nm]".
struct ColumnName {
  std::vector<std::string> words;   // in small letters, without numbers
  std::optional<std::string> unit;  // as unit_scale() knows it
};

// What the words of a name say together.
struct ColumnMeaning {
  std::optional<ColumnKind> kind;   // none: no quantity, or more than one
  int strangeness = 0;              // words that say something else besides
  std::optional<std::string> unit;  // that of the program which writes such names
};

// What a word says about a column.
enum class ColumnWord {
  position,
  velocity,
  torque,
  control,
  wanted,
  time,
  no_matter,
  strange,
  other_quantity
};

// Words of one meaning, with blanks around each.
struct Meaning {
  std::string_view words;
  ColumnWord means;
  ColumnWord also = ColumnWord::no_matter;  // "qref" is a position that is wanted
};

constexpr std::array meanings = {
    Meaning{" q qm qpos jpos pos position positions angle angles theta θ winkel ", ColumnWord::position},
    Meaning{" qd dq qdot dqm qvel jvel vel velocity velocities speed speeds omega ω geschwindigkeit vitesse ",
            ColumnWord::velocity},
    Meaning{" tau taum τ torque torques trq effort efforts moment moments drehmoment couple couples force ",
            ColumnWord::torque},
    Meaning{" current currents curr cur strom courant i iq u v vtau control ctrl ", ColumnWord::control},
    // Where there is a current it is that.
    Meaning{" voltage spannung load pwm duty ", ColumnWord::control, ColumnWord::strange},
    Meaning{" ref reference target des desired d cmd command commanded set setpoint sp goal r "
            "soll consigne ",
            ColumnWord::wanted},
    Meaning{" qref qdes qcmd qr ", ColumnWord::position, ColumnWord::wanted},
    Meaning{" itarget targeti targetcurrent currenttarget icmd iref ", ColumnWord::control,
            ColumnWord::wanted},
    Meaning{" tautarget targettau targettorque torquetarget targetmoment momenttarget taucmd tauref ",
            ColumnWord::torque, ColumnWord::wanted},
    Meaning{" qdref dqref qddes dqdes qdcmd ", ColumnWord::velocity, ColumnWord::wanted},
    Meaning{" t time times timestamp timestamps stamp zeit temps ", ColumnWord::time},
    Meaning{" joint joints j axis ax a state states field data actual act meas measured msr real robot arm "
            "observation ist gelenk achse axe articulation ",
            ColumnWord::no_matter},
    Meaning{" link motor raw filtered filt ", ColumnWord::strange},
    Meaning{
        " qdd ddq qddot acc accel acceleration accelerations jerk ext external error err temperature temp "
        "tcp tool pose cartesian gravity friction coriolis estimated est hat model residual limit mode "
        "status ",
        ColumnWord::other_quantity}};

// Names that say by their program alone what they hold: their last words, and the unit of that program.
struct ProgramName {
  std::string_view words;
  ColumnKind kind;
  std::string_view unit = {};
};
constexpr std::array program_names = {
    ProgramName{" axis act", ColumnKind::position, "deg"},         // KUKA: AxisAct.A1
    ProgramName{" axis act a", ColumnKind::position, "deg"},       //
    ProgramName{" axis act real a", ColumnKind::position, "deg"},  // KUKA: AxisActReal.A1
    ProgramName{" rax", ColumnKind::position, "deg"},              // ABB: rax_1
    ProgramName{" mch ang", ColumnKind::position, "deg"},          // FANUC: $MCH_ANG[1]
    ProgramName{" qfrc actuator", ColumnKind::torque},             // MuJoCo: qfrc_actuator_0
    ProgramName{" observation state", ColumnKind::position},       // LeRobot: observation.state.0
    ProgramName{" action", ColumnKind::reference}};                // LeRobot: action.0

// How units are written at the end of a name, and as unit_scale() knows them. Words, so that "[rad/s]",
// "(rad/s)" and "_rad_s" are one.
struct KnownUnit {
  std::string_view words;
  std::string_view unit;
};
constexpr std::array known_units = {
    KnownUnit{"rad s", "rad/s"}, KnownUnit{"deg s", "deg/s"}, KnownUnit{"° s", "deg/s"},
    KnownUnit{"m s", "m/s"},     KnownUnit{"mm s", "mm/s"},   KnownUnit{"rpm", "rpm"},
    KnownUnit{"rad", "rad"},     KnownUnit{"radian", "rad"},  KnownUnit{"radians", "rad"},
    KnownUnit{"deg", "deg"},     KnownUnit{"degree", "deg"},  KnownUnit{"degrees", "deg"},
    KnownUnit{"°", "deg"},       KnownUnit{"grad", "deg"},    KnownUnit{"mm", "mm"},
    KnownUnit{"nm", "Nm"},       KnownUnit{"n m", "Nm"},      KnownUnit{"n·m", "Nm"},
    KnownUnit{"mnm", "mNm"},     KnownUnit{"ma", "mA"},       KnownUnit{"amp", "A"},
    KnownUnit{"amps", "A"},      KnownUnit{"mv", "mV"},       KnownUnit{"volt", "V"},
    KnownUnit{"volts", "V"},     KnownUnit{"ms", "ms"},       KnownUnit{"msec", "ms"},
    KnownUnit{"millis", "ms"},   KnownUnit{"us", "us"},       KnownUnit{"usec", "us"},
    KnownUnit{"micros", "us"},   KnownUnit{"ns", "ns"},       KnownUnit{"nsec", "ns"},
    KnownUnit{"nanosec", "ns"},  KnownUnit{"sec", "s"},       KnownUnit{"secs", "s"},
    KnownUnit{"seconds", "s"}};
// Single letters are units only in brackets.
constexpr std::array bracketed_units = {KnownUnit{"s", "s"}, KnownUnit{"m", "m"}, KnownUnit{"n", "N"},
                                        KnownUnit{"a", "A"}, KnownUnit{"v", "V"}};

// Runs of letters, parted at capitals where two letters are before: "measuredJointPosition", but "dQ".
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> out;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) {
      out.push_back(in_small_letters(word));
    }
    word.clear();
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is_letter(name[i])) {
      end_word();
      continue;
    }
    if (is_upper(name[i]) && word.size() > 1 && is_lower(name[i - 1])) {
      end_word();
    }
    word += name[i];
  }
  end_word();
  return out;
}

template <std::size_t n>
std::optional<std::string> unit_in(const std::array<KnownUnit, n>& units, std::string_view words) {
  const auto found = std::ranges::find(units, words, &KnownUnit::words);
  return found == units.end() ? std::nullopt : std::optional(std::string(found->unit));
}

ColumnName parted(std::string_view name) {
  ColumnName out;
  const std::size_t open = name.find_last_of("[(");
  if (open != std::string_view::npos && open > 0 && open + 1 < name.size() && !is_digit(name[open + 1])) {
    const std::string inside = joined(words_of(name.substr(open)), " ");
    out.unit = unit_in(known_units, inside);
    if (!out.unit) {
      out.unit = unit_in(bracketed_units, inside);
    }
    if (out.unit) {
      out.words = words_of(name.substr(0, open));
      return out;
    }
  }
  out.words = words_of(name);
  for (const std::size_t count : {std::size_t{2}, std::size_t{1}}) {
    if (out.words.size() > count) {
      out.unit = unit_in(known_units, joined(std::span(out.words).last(count), " "));
      if (out.unit) {
        out.words.resize(out.words.size() - count);
        return out;
      }
    }
  }
  return out;
}

ColumnMeaning meaning_of(const std::vector<std::string>& words) {
  std::array<bool, static_cast<std::size_t>(ColumnWord::other_quantity) + 1> says{};
  ColumnMeaning out;
  for (const std::string& word : words) {
    const auto known = std::ranges::find_if(meanings, [&](const Meaning& meaning) {
      return meaning.words.find(' ' + word + ' ') != std::string_view::npos;
    });
    if (known == meanings.end()) {
      out.strangeness += 2;
      continue;
    }
    for (const ColumnWord means : {known->means, known->also}) {
      says[static_cast<std::size_t>(means)] = true;
      out.strangeness += static_cast<int>(means == ColumnWord::strange);
    }
  }
  const auto has = [&](ColumnWord word) { return says[static_cast<std::size_t>(word)]; };
  const int motions = static_cast<int>(has(ColumnWord::position)) +
                      static_cast<int>(has(ColumnWord::velocity)) + static_cast<int>(has(ColumnWord::torque));
  if (has(ColumnWord::other_quantity) || motions > 1) {
    return out;
  }
  const bool wanted = has(ColumnWord::wanted);
  if (has(ColumnWord::position)) {
    out.kind = wanted ? ColumnKind::reference : ColumnKind::position;
  } else if (has(ColumnWord::velocity)) {
    out.kind = wanted ? ColumnKind::reference_velocity : ColumnKind::velocity;
  } else if (has(ColumnWord::torque)) {
    out.kind = wanted ? ColumnKind::target_torque : ColumnKind::torque;
  } else if (has(ColumnWord::control)) {  // last: "current_position" is no current
    out.kind = wanted ? ColumnKind::target_current : ColumnKind::control;
  } else if (has(ColumnWord::time)) {
    out.kind = ColumnKind::time;
  } else if (const auto program = std::ranges::find_if(
                 program_names, [text = " " + joined(words, " ")](
                                    const ProgramName& name) { return text.ends_with(name.words); });
             program != program_names.end()) {
    out.kind = program->kind;
    out.strangeness = 0;
    if (!program->unit.empty()) {
      out.unit = std::string(program->unit);
    }
  }
  return out;
}

// Columns whose names differ in the joint alone.
struct Group {
  std::vector<std::string> columns;
  ColumnMeaning meaning;
};

// Of columns whose names are `pattern` but for the joint. The name says the unit, or the program that writes
// such names.
Group group_of(std::vector<std::string> columns, std::string_view pattern) {
  ColumnName parts = parted(pattern);
  Group out{std::move(columns), meaning_of(parts.words)};
  if (parts.unit) {
    out.meaning.unit = std::move(parts.unit);
  }
  return out;
}

bool same(char a, char b) { return (is_letter(a) && is_letter(b)) || (is_digit(a) && is_digit(b)); }

// `part` in `name`, not within a longer word or number.
std::size_t find_whole(std::string_view name, std::string_view part) {
  for (std::size_t at = name.find(part); at != std::string_view::npos; at = name.find(part, at + 1)) {
    const std::size_t end = at + part.size();
    if ((at == 0 || !same(name[at - 1], part.front())) &&
        (end == name.size() || !same(name[end], part.back()))) {
      return at;
    }
  }
  return std::string_view::npos;
}

// Names of joints as columns may have them: as they are, and without what all of them begin or end with.
std::vector<std::vector<std::string>> spellings(std::span<const std::string> joints) {
  std::vector<std::string> full;
  for (const std::string& joint : joints) {
    full.push_back(in_small_letters(joint));
  }
  std::vector<std::vector<std::string>> out = {full};
  if (joints.size() < 2) {
    return out;
  }
  const std::string& first = full.front();
  std::size_t begin = first.size();
  std::size_t end = first.size();
  for (const std::string& name : full) {
    begin = std::min(begin, static_cast<std::size_t>(std::ranges::mismatch(first, name).in1 - first.begin()));
    const auto tail = std::mismatch(first.rbegin(), first.rend(), name.rbegin(), name.rend());
    end = std::min(end, static_cast<std::size_t>(tail.first - first.rbegin()));
  }
  // Whole words only.
  while (begin > 0 && is_letter(first[begin - 1])) {
    --begin;
  }
  while (end > 0 && is_letter(first[first.size() - end])) {
    --end;
  }
  std::vector<std::string> core;
  for (const std::string& name : full) {
    if (name.size() <= begin + end) {
      return out;
    }
    core.push_back(name.substr(begin, name.size() - begin - end));
    // A bare number is the matter of numbered().
    if (std::ranges::none_of(core.back(), is_letter)) {
      return out;
    }
  }
  out.push_back(core);
  return out;
}

// Of joints whose names a column has in it, the longest: "wrist_1" is in "left_wrist_1". Their number where
// it has none.
std::size_t joint_of(const std::string& column, const std::vector<std::string>& joints) {
  std::size_t out = joints.size();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (find_whole(column, joints[j]) != std::string::npos &&
        (out == joints.size() || joints[j].size() > joints[out].size())) {
      out = j;
    }
  }
  return out;
}

// Columns that go by the names of the joints.
void add_named(std::span<const std::string> names, std::span<const std::string> joints,
               std::vector<Group>& out) {
  for (const std::vector<std::string>& spelling : spellings(joints)) {
    std::map<std::string, std::vector<std::string>> by_pattern;
    for (const std::string& name : names) {
      const std::string low = in_small_letters(name);
      const std::size_t joint = joint_of(low, spelling);
      if (joint < spelling.size()) {
        const std::size_t at = find_whole(low, spelling[joint]);
        // A separator stands in for the joint; capitals are kept, they part words.
        const std::string pattern = name.substr(0, at) + "#" + name.substr(at + spelling[joint].size());
        by_pattern[pattern].resize(spelling.size());
        by_pattern[pattern][joint] = name;
      }
    }
    for (auto& [pattern, columns] : by_pattern) {
      if (std::ranges::none_of(columns, &std::string::empty)) {
        out.push_back(group_of(std::move(columns), pattern));
      }
    }
  }
}

// Columns of a quantity that are too many or too few.
struct Misfit {
  ColumnKind kind;
  std::string text;
};

// Columns that are counted from 0 or 1, by any of the numbers in their names.
void add_numbered(std::span<const std::string> names, std::size_t joints, std::vector<Group>& out,
                  std::vector<Misfit>& misfits) {
  std::map<std::string, std::map<int, std::string>> by_pattern;
  for (const std::string& name : names) {
    for (std::size_t begin = 0; begin < name.size(); ++begin) {
      if (!is_digit(name[begin]) || (begin > 0 && is_digit(name[begin - 1]))) {
        continue;
      }
      int number = 0;
      const auto end = std::from_chars(name.data() + begin, name.data() + name.size(), number);
      if (end.ec == std::errc()) {
        by_pattern[name.substr(0, begin) + "#" + std::string(end.ptr, name.data() + name.size())][number] =
            name;
      }
    }
  }
  for (const auto& [pattern, columns] : by_pattern) {
    const int first = columns.begin()->first;
    if (first > 1 || columns.rbegin()->first - first + 1 != static_cast<int>(columns.size())) {
      continue;
    }
    Group group = group_of({}, pattern);
    for (const auto& [number, name] : columns) {
      group.columns.push_back(name);
    }
    if (columns.size() == joints) {
      out.push_back(std::move(group));
    } else if (columns.size() > 1 && group.meaning.kind && group.meaning.strangeness == 0) {
      misfits.push_back({.kind = *group.meaning.kind,
                         .text = in_quotes(group.columns.front()) + " to " + in_quotes(group.columns.back()) +
                                 " are " + counted(std::ssize(columns), "column") + ", the robot has " +
                                 counted(static_cast<std::ptrdiff_t>(joints), "joint") +
                                 ": is it the part that was meant (base, tip, moving)?"});
    }
  }
}

// A robot of one joint needs no number.
void add_single(std::span<const std::string> names, std::vector<Group>& out) {
  for (const std::string& name : names) {
    out.push_back(group_of({name}, name));
  }
}

// The group of a kind with the fewest strange words.
RecognisedColumns best(const std::vector<Group>& groups, ColumnKind kind, std::string_view key,
                       std::vector<std::string>& doubts) {
  const Group* found = nullptr;
  const Group* other = nullptr;
  for (const Group& group : groups) {
    if (group.meaning.kind != kind) {
      continue;
    }
    if (found == nullptr || group.meaning.strangeness < found->meaning.strangeness) {
      found = &group;
      other = nullptr;
    } else if (group.meaning.strangeness == found->meaning.strangeness && group.columns != found->columns) {
      other = &group;
    }
  }
  if (found == nullptr) {
    return {};
  }
  if (other != nullptr) {
    doubts.push_back(std::string(key) + " may be " + in_quotes(found->columns.front()) + " … or " +
                     in_quotes(other->columns.front()) + " …; the first is taken");
  }
  return {found->columns, found->meaning.unit};
}

using Words = std::span<const std::string_view>;

// Columns that are called alike but for their ends, the first of which is one of `firsts` as well; with what
// all begin with. Empty where one is missing, or one is of something else than a base.
std::pair<std::string, std::vector<std::string>> alike(std::span<const std::string> names, std::size_t from,
                                                       Words firsts, Words ends) {
  constexpr std::string_view others =
      " tcp tool ee eef effector hand flange gripper target desired reference ref cmd ";
  const std::string& name = names[from];
  const bool other = std::ranges::any_of(words_of(name), [&](const std::string& word) {
    return others.find(' ' + word + ' ') != std::string_view::npos;
  });
  if (other || std::ranges::none_of(
                   firsts, [&](std::string_view first) { return in_small_letters(name).ends_with(first); })) {
    return {};
  }
  const std::string stem = name.substr(0, name.size() - ends.front().size());
  std::vector<std::string> out;
  for (const std::string_view end : ends) {
    if (std::ranges::find(names, stem + std::string(end)) == names.end()) {
      return {};
    }
    out.push_back(stem + std::string(end));
  }
  return {stem, out};
}

RecognisedColumns time_column(std::span<const std::string> names, std::vector<std::string>& doubts) {
  std::vector<Group> groups;
  add_single(names, groups);
  for (const std::string& name : names) {
    // They are a part of the seconds beside them.
    if (const auto nanoseconds = nanoseconds_of(name, names)) {
      std::erase_if(groups, [&](const Group& group) { return group.columns.front() == *nanoseconds; });
    }
  }
  return best(groups, ColumnKind::time, "time", doubts);
}

}  // namespace

RecognisedLog recognised_log(std::span<const std::string> names, std::span<const std::string> joints) {
  RecognisedLog out;
  std::vector<Group> groups;
  std::vector<Misfit> misfits;
  add_named(names, joints, groups);
  add_numbered(names, joints.size(), groups, misfits);
  if (joints.size() == 1) {
    add_single(names, groups);
  }
  out.time = time_column(names, out.doubts);
  for (const auto& [key, kind, columns] : log_keys) {
    if (kind == ColumnKind::control && !out.torque.columns.empty()) {
      continue;
    }
    RecognisedColumns& found = out.*columns;
    found = best(groups, kind, key, out.doubts);
    for (const Misfit& misfit : misfits) {
      if (found.columns.empty() && misfit.kind == kind) {
        out.doubts.push_back(misfit.text);
      }
    }
  }
  // Nothing has to be filled in for these.
  std::vector<std::string> silent;
  out.target_current = best(groups, ColumnKind::target_current, "target current", silent);
  out.target_torque = best(groups, ColumnKind::target_torque, "target torque", silent);
  return out;
}

RecognisedBase recognised_base(std::span<const std::string> names) {
  constexpr auto places = std::to_array<std::string_view>(
      {"base_x", "base_pos_x", "base_position_x", "base.x", "position.x", "position_x"});
  constexpr auto quaternions = std::to_array<std::string_view>(
      {"base_qw", "base_q_w", "base_quat_w", "base.qw", "orientation.w", "orientation_w"});
  constexpr auto rolls = std::to_array<std::string_view>({"base_roll", "base.roll"});
  constexpr auto forces =
      std::to_array<std::string_view>({"_fx", ".fx", "force_x", "force.x", "force/x", "_f_x"});
  constexpr auto xyz = std::to_array<std::string_view>({"x", "y", "z"});
  constexpr auto wxyz = std::to_array<std::string_view>({"w", "x", "y", "z"});
  constexpr auto rpy = std::to_array<std::string_view>({"roll", "pitch", "yaw"});
  // A pose of which nothing else is said may be that of a tool or of a camera.
  constexpr std::string_view bases = " base odom odometry root trunk torso pelvis floating ";
  const auto of_base = [&](const std::string& name) {
    return std::ranges::any_of(words_of(name), [&](const std::string& word) {
      return bases.find(' ' + word + ' ') != std::string_view::npos;
    });
  };
  RecognisedBase out;
  const auto take = [&](std::size_t i, Words firsts, Words ends, std::vector<std::string>& to) {
    if (to.empty() && of_base(names[i])) {
      to = alike(names, i, firsts, ends).second;
    }
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    take(i, places, xyz, out.position);
    take(i, quaternions, wxyz, out.orientation);
    take(i, rolls, rpy, out.orientation);
    if (auto [stem, columns] = alike(names, i, forces, xyz); !columns.empty()) {
      out.forces[stem] = std::move(columns);
    }
  }
  return out.position.empty() || out.orientation.empty() ? RecognisedBase() : out;
}

std::vector<std::string> joints_in(std::span<const std::string> names, std::span<const std::string> joints) {
  const std::vector<std::string> full = spellings(joints).front();
  std::vector<bool> named(joints.size() + 1, false);
  for (const std::string& name : names) {
    named[joint_of(in_small_letters(name), full)] = true;
  }
  std::vector<std::string> out;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (named[j]) {
      out.push_back(joints[j]);
    }
  }
  return out;
}

}  // namespace rivid::detail
