#include "experiment/recognised_columns.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <map>
#include <utility>

#include "experiment/column_words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Columns whose names differ in the joint alone.
struct Group {
  std::vector<std::string> columns;
  std::vector<std::string> words;
  std::optional<std::string> unit;
};

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
    full.push_back(lower(joint));
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

// Columns that go by the names of the joints.
void add_named(std::span<const std::string> names, std::span<const std::string> joints,
               std::vector<Group>& out) {
  for (const std::vector<std::string>& spelling : spellings(joints)) {
    std::map<std::string, std::vector<std::string>> by_pattern;
    for (const std::string& name : names) {
      const std::string low = lower(name);
      // Of joints whose names are found, the longest: "wrist_1" is in "left_wrist_1".
      std::size_t joint = spelling.size();
      for (std::size_t j = 0; j < spelling.size(); ++j) {
        if (find_whole(low, spelling[j]) != std::string::npos &&
            (joint == spelling.size() || spelling[j].size() > spelling[joint].size())) {
          joint = j;
        }
      }
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
        ColumnName parts = parted(pattern);
        out.push_back({std::move(columns), std::move(parts.words), std::move(parts.unit)});
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
    ColumnName parts = parted(pattern);
    if (columns.size() != joints) {
      const ColumnMeaning reading = meaning_of(parts.words);
      if (columns.size() > 1 && reading.kind && *reading.kind != ColumnKind::other &&
          reading.strangeness == 0) {
        misfits.push_back({.kind = *reading.kind,
                           .text = in_quotes(columns.begin()->second) + " to " +
                                   in_quotes(columns.rbegin()->second) + " are " +
                                   counted(std::ssize(columns), "column") + ", the chain has " +
                                   counted(static_cast<std::ptrdiff_t>(joints), "joint") +
                                   ": is it the chain that was meant (base, tip)?"});
      }
      continue;
    }
    Group group{{}, std::move(parts.words), std::move(parts.unit)};
    for (const auto& [number, name] : columns) {
      group.columns.push_back(name);
    }
    out.push_back(std::move(group));
  }
}

// A robot of one joint needs no number.
void add_single(std::span<const std::string> names, std::vector<Group>& out) {
  for (const std::string& name : names) {
    ColumnName parts = parted(name);
    out.push_back({{name}, std::move(parts.words), std::move(parts.unit)});
  }
}

// The group of a kind with the fewest strange words.
RecognisedColumns best(const std::vector<Group>& groups, ColumnKind kind, std::string_view key,
                       std::vector<std::string>& doubts) {
  const Group* found = nullptr;
  const Group* other = nullptr;
  int least = 0;
  for (const Group& group : groups) {
    const ColumnMeaning reading = meaning_of(group.words);
    if (reading.kind != kind) {
      continue;
    }
    if (found == nullptr || reading.strangeness < least) {
      found = &group;
      other = nullptr;
      least = reading.strangeness;
    } else if (reading.strangeness == least && group.columns != found->columns) {
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
  return {found->columns, found->unit};
}

RecognisedColumns time_column(std::span<const std::string> names, std::vector<std::string>& doubts) {
  std::vector<Group> groups;
  add_single(names, groups);
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
  const auto find = [&](ColumnKind kind, std::string_view key) {
    RecognisedColumns found = best(groups, kind, key, out.doubts);
    for (const Misfit& misfit : misfits) {
      if (found.columns.empty() && misfit.kind == kind) {
        out.doubts.push_back(misfit.text);
      }
    }
    return found;
  };
  out.time = time_column(names, out.doubts);
  out.position = find(ColumnKind::position, "position");
  out.velocity = find(ColumnKind::velocity, "velocity");
  out.torque = find(ColumnKind::torque, "torque");
  if (out.torque.columns.empty()) {
    out.control = find(ColumnKind::control, "control");
  }
  out.reference = find(ColumnKind::reference, "reference");
  out.reference_velocity = find(ColumnKind::reference_velocity, "reference_velocity");
  return out;
}

}  // namespace rivid::detail
