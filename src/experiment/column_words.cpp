#include "experiment/column_words.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace rivid::detail {

namespace {

// What a word says about a column.
enum class Word { position, velocity, torque, control, wanted, time, no_matter, strange, other_quantity };

// Words of one meaning, with blanks around each.
struct Meaning {
  std::string_view words;
  Word means;
  Word also = Word::no_matter;  // "qref" is a position that is wanted
};

constexpr std::array meanings = {
    Meaning{" q qm qpos jpos pos position positions angle angles theta ", Word::position},
    Meaning{" qd dq qdot dqm qvel jvel vel velocity velocities speed speeds omega ", Word::velocity},
    Meaning{" tau taum torque torques trq effort efforts moment moments force ", Word::torque},
    Meaning{" current currents curr cur i iq u v vtau control ctrl ", Word::control},
    Meaning{" voltage ", Word::control, Word::strange},  // where there is a current it is that
    Meaning{" ref reference target des desired d cmd command commanded set setpoint sp goal r ",
            Word::wanted},
    Meaning{" qref qdes qcmd qr ", Word::position, Word::wanted},
    Meaning{" qdref dqref qddes dqdes qdcmd ", Word::velocity, Word::wanted},
    Meaning{" t time times timestamp timestamps stamp ", Word::time},
    Meaning{" joint joints j axis ax a state states field data actual act meas measured msr real robot arm ",
            Word::no_matter},
    Meaning{" link motor raw filtered filt ", Word::strange},
    Meaning{
        " qdd ddq qddot acc accel acceleration accelerations jerk ext external error err temperature temp "
        "tcp tool pose cartesian gravity friction coriolis estimated est hat model residual limit mode "
        "status ",
        Word::other_quantity}};

// How units are written at the end of a name, and as unit_scale() knows them. Words, so that "[rad/s]", "(rad/s)" and
// "_rad_s" are one.
struct KnownUnit {
  std::string_view words;
  std::string_view unit;
};
constexpr std::array known_units = {
    KnownUnit{"rad s", "rad/s"}, KnownUnit{"deg s", "deg/s"}, KnownUnit{"° s", "deg/s"},
    KnownUnit{"m s", "m/s"},     KnownUnit{"mm s", "mm/s"},   KnownUnit{"rpm", "rpm"},
    KnownUnit{"rad", "rad"},     KnownUnit{"radian", "rad"},  KnownUnit{"radians", "rad"},
    KnownUnit{"deg", "deg"},     KnownUnit{"degree", "deg"},  KnownUnit{"degrees", "deg"},
    KnownUnit{"°", "deg"},       KnownUnit{"mm", "mm"},       KnownUnit{"nm", "Nm"},
    KnownUnit{"n m", "Nm"},      KnownUnit{"n·m", "Nm"},      KnownUnit{"mnm", "mNm"},
    KnownUnit{"ma", "mA"},       KnownUnit{"amp", "A"},       KnownUnit{"amps", "A"},
    KnownUnit{"mv", "mV"},       KnownUnit{"volt", "V"},      KnownUnit{"volts", "V"},
    KnownUnit{"ms", "ms"},       KnownUnit{"msec", "ms"},     KnownUnit{"millis", "ms"},
    KnownUnit{"us", "us"},       KnownUnit{"usec", "us"},     KnownUnit{"micros", "us"},
    KnownUnit{"ns", "ns"},       KnownUnit{"nsec", "ns"},     KnownUnit{"nanosec", "ns"},
    KnownUnit{"sec", "s"},       KnownUnit{"secs", "s"},      KnownUnit{"seconds", "s"}};
// Single letters are units only in brackets.
constexpr std::array bracketed_units = {KnownUnit{"s", "s"}, KnownUnit{"m", "m"}, KnownUnit{"n", "N"},
                                        KnownUnit{"a", "A"}, KnownUnit{"v", "V"}};

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

// Runs of letters, parted at capitals where two letters are before: "measuredJointPosition", but "dQ".
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> out;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) {
      out.push_back(lower(word));
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

}  // namespace

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](char c) { return is_upper(c) ? static_cast<char>(c + 32) : c; });
  return out;
}

ColumnName parted(std::string_view name) {
  ColumnName out;
  const auto joined = [](const std::vector<std::string>& words, std::size_t first) {
    std::string text;
    for (std::size_t i = first; i < words.size(); ++i) {
      text += (text.empty() ? "" : " ") + words[i];
    }
    return text;
  };
  const std::size_t open = name.find_last_of("[(");
  if (open != std::string_view::npos && open > 0 && open + 1 < name.size() && !is_digit(name[open + 1])) {
    const std::string inside = joined(words_of(name.substr(open)), 0);
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
      out.unit = unit_in(known_units, joined(out.words, out.words.size() - count));
      if (out.unit) {
        out.words.resize(out.words.size() - count);
        return out;
      }
    }
  }
  return out;
}

ColumnMeaning meaning_of(const std::vector<std::string>& words) {
  std::array<bool, static_cast<std::size_t>(Word::other_quantity) + 1> says{};
  ColumnMeaning out;
  for (const std::string& word : words) {
    const auto known = std::ranges::find_if(meanings, [&](const Meaning& meaning) {
      return meaning.words.find(' ' + word + ' ') != std::string_view::npos;
    });
    if (known == meanings.end()) {
      out.strangeness += 2;
      continue;
    }
    for (const Word means : {known->means, known->also}) {
      says[static_cast<std::size_t>(means)] = true;
      out.strangeness += static_cast<int>(means == Word::strange);
    }
  }
  const auto has = [&](Word word) { return says[static_cast<std::size_t>(word)]; };
  const int motions = static_cast<int>(has(Word::position)) + static_cast<int>(has(Word::velocity)) +
                      static_cast<int>(has(Word::torque));
  if (has(Word::other_quantity) || motions > 1) {
    return out;
  }
  const bool wanted = has(Word::wanted);
  if (has(Word::position)) {
    out.kind = wanted ? ColumnKind::reference : ColumnKind::position;
  } else if (has(Word::velocity)) {
    out.kind = wanted ? ColumnKind::reference_velocity : ColumnKind::velocity;
  } else if (has(Word::torque)) {
    out.kind = wanted ? ColumnKind::other : ColumnKind::torque;
  } else if (has(Word::control)) {  // last: "current_position" is no current
    out.kind = wanted ? ColumnKind::other : ColumnKind::control;
  } else if (has(Word::time)) {
    out.kind = ColumnKind::time;
  }
  return out;
}

}  // namespace rivid::detail
