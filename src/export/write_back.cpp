#include "export/write_back.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

void take(JointValues& to, const StandardParameter& parameter, double value, JointType type) {
  const auto text = [&] {
    const std::string_view its_unit = unit(parameter.kind, type);
    return parameter.name() + " = " + number(value, 4) + (its_unit == "1" ? "" : " " + std::string(its_unit));
  };
  const KindRow& row = about(parameter.kind);
  switch (role(parameter.kind)) {
    case Role::inertial:
      to.inertial[static_cast<Index>(parameter.kind)] = value;
      return;
    case Role::rotor:
      if (!row.coupled) {
        to.Ia = value;
        to.rotor = value != 0.0 ? text() : std::string();
        return;
      }
      break;
    case Role::viscous:
    case Role::dry:
    case Role::constant:
      break;
  }
  if (row.coupled && value != 0.0) {
    to.coupled.push_back(text());
  } else if (row.basis == Basis::load) {
    to.load_friction = value;
  } else if (!row.coupled) {
    to.friction_terms.push_back({value, about(row.basis).in_c, row.direction});
  }
  std::optional<double>* const place = row.coupled                 ? nullptr
                                       : row.basis == Basis::speed ? &to.damping
                                       : row.basis == Basis::sign  ? &to.friction
                                                                   : nullptr;
  if (place != nullptr && row.direction == Direction::both) {
    *place = value;
    return;
  }
  if (place != nullptr) {
    *place = place->value_or(0.0) + 0.5 * value;
  }
  if (value != 0.0) {
    to.rest.push_back(text());
  }
}

}  // namespace

std::vector<std::string> JointValues::unsaid(bool with_rotor) const {
  std::vector<std::string> out = rest;
  if (with_rotor && !rotor.empty()) {
    out.insert(out.begin(), rotor);
  }
  return out;
}

std::vector<JointValues> joint_values(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
                                      std::string_view who) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  if (chi_st.size() != static_cast<Index>(parameters.size())) {
    throw InputError(std::string(who) + ": chi_st has " + std::to_string(chi_st.size()) +
                     " values, the robot has " + std::to_string(parameters.size()) + " standard parameters");
  }
  std::vector<JointValues> out(robot.joints.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = chi_st[static_cast<Index>(i)];
    if (!std::isfinite(value)) {
      throw InputError(std::string(who) + ": " + parameters[i].name() + " is " + number(value) +
                       ", must be finite");
    }
    const auto joint = static_cast<std::size_t>(parameters[i].joint);
    take(out[joint], parameters[i], value, robot.joints[joint].type);
  }
  return out;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) {
    out.append(out.empty() ? "" : ", ").append(part);
  }
  return out;
}

namespace {

constexpr std::string_view blanks = " \t\r\n";

// Line end and blanks that stand before the line that holds `at`; empty where other text does.
std::string line_start(std::string_view text, std::size_t at) {
  const std::size_t newline = text.rfind('\n', at);
  const std::size_t begin = newline == std::string_view::npos ? 0 : newline + 1;
  const std::size_t end = std::min(text.find_first_not_of(" \t", begin), at);
  const std::string_view ending = newline == std::string_view::npos          ? ""
                                  : newline > 0 && text[newline - 1] == '\r' ? "\r\n"
                                                                             : "\n";
  return std::string(ending) + std::string(text.substr(begin, end - begin));
}

}  // namespace

const StartTag::Attribute* StartTag::attribute(std::string_view wanted) const {
  const auto at = std::ranges::find(attributes, wanted, &Attribute::name);
  return at == attributes.end() ? nullptr : &*at;
}

StartTag start_tag(std::string_view text, std::size_t name_begin) {
  StartTag out;
  out.name_end = text.find_first_of(" \t\r\n/>", name_begin);
  out.name = text.substr(name_begin, out.name_end - name_begin);
  std::size_t at = text.find_first_not_of(blanks, out.name_end);
  while (text[at] != '>' && text[at] != '/') {
    const std::size_t name_end = text.find_first_of(" \t\r\n=", at);
    const std::size_t quote = text.find_first_of("\"'", name_end);
    const std::size_t closing = text.find(text[quote], quote + 1);
    out.attributes.push_back(
        {text.substr(at, name_end - at), text.substr(quote + 1, closing - quote - 1), quote + 1});
    at = text.find_first_not_of(blanks, closing + 1);
  }
  out.closed = text[at] == '/';
  out.end = text.find('>', at) + 1;
  return out;
}

void Splice::replace(std::size_t begin, std::size_t length, std::string content) {
  edits_.push_back({begin, length, std::move(content)});
}

void Splice::set(const StartTag& tag, std::string_view attribute, const std::string& value) {
  if (const StartTag::Attribute* const present = tag.attribute(attribute)) {
    replace(present->begin, present->value.size(), value);
  } else {
    replace(tag.name_end, 0, " " + std::string(attribute) + "=\"" + value + "\"");
  }
}

void Splice::insert_child(const StartTag& parent, const std::vector<std::string>& lines) {
  const std::string outer = line_start(text_, parent.end - 1);
  std::string before = outer.empty() ? outer : outer + "  ";
  if (!parent.closed) {
    // As the first of its children stands, in a line of its own or not.
    const std::size_t next = text_.find_first_not_of(blanks, parent.end);
    const bool same_line = text_.substr(parent.end, next - parent.end).find('\n') == std::string_view::npos;
    const bool is_end = text_.substr(next, 2) == "</";
    before = same_line ? std::string() : is_end ? before : line_start(text_, next);
  }
  std::string content;
  for (const std::string& line : lines) {
    content += before.empty() ? line.substr(line.find_first_not_of(' ')) : before + line;
  }
  if (parent.closed) {
    const std::size_t slash = text_.rfind('/', parent.end);
    replace(slash, parent.end - slash, ">" + content + outer + "</" + std::string(parent.name) + ">");
  } else {
    replace(parent.end, 0, content);
  }
}

std::string Splice::result() const {
  std::vector<Edit> edits = edits_;
  std::ranges::stable_sort(edits, {}, &Edit::begin);
  std::string out;
  std::size_t done = 0;
  for (const Edit& edit : edits) {
    out.append(text_.substr(done, edit.begin - done)).append(edit.content);
    done = edit.begin + edit.length;
  }
  return out.append(text_.substr(done));
}

}  // namespace rivid::detail

namespace rivid {

namespace {

using Lines = std::vector<std::string_view>;

// With their line ends, so that a last line without one differs from the same with one.
Lines lines_of(std::string_view text) {
  Lines out;
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    const std::size_t length = newline == std::string_view::npos ? text.size() : newline + 1;
    out.push_back(text.substr(0, length));
    text.remove_prefix(length);
  }
  return out;
}

struct Step {
  char mark;         // ' ', '-', '+'
  std::size_t a, b;  // lines of both texts that come before it
};

// The shortest way from a to b by the greedy algorithm of Myers: of all points that d changes reach, diagonal by
// diagonal x − y, the furthest, for d = 0, 1, …
std::vector<Step> steps(const Lines& a, const Lines& b) {
  const auto n = static_cast<std::ptrdiff_t>(a.size());
  const auto m = static_cast<std::ptrdiff_t>(b.size());
  const std::ptrdiff_t most = n + m;
  std::vector<std::ptrdiff_t> furthest(static_cast<std::size_t>(2 * most + 3), 0);
  // Diagonals count from the middle.
  const auto at = [](auto& v, std::ptrdiff_t k) -> auto& {
    return v[static_cast<std::size_t>(k + std::ssize(v) / 2)];
  };
  const auto goes_down = [&](const auto& v, std::ptrdiff_t k, std::ptrdiff_t d) {
    return k == -d || (k != d && at(v, k - 1) < at(v, k + 1));
  };
  std::vector<std::vector<std::ptrdiff_t>> trace;
  for (std::ptrdiff_t d = 0, done = 0; done == 0; ++d) {
    const auto middle = furthest.begin() + most + 1;
    trace.emplace_back(middle - d - 1, middle + d + 2);
    for (std::ptrdiff_t k = -d; k <= d && done == 0; k += 2) {
      std::ptrdiff_t x = goes_down(furthest, k, d) ? at(furthest, k + 1) : at(furthest, k - 1) + 1;
      while (x < n && x - k < m && a[static_cast<std::size_t>(x)] == b[static_cast<std::size_t>(x - k)]) {
        ++x;
      }
      at(furthest, k) = x;
      done = x >= n && x - k >= m ? 1 : 0;
    }
  }
  std::vector<Step> out;
  std::ptrdiff_t x = n;
  std::ptrdiff_t y = m;
  const auto step = [&](char mark) {
    x -= mark == '+' ? 0 : 1;
    y -= mark == '-' ? 0 : 1;
    out.push_back({mark, static_cast<std::size_t>(x), static_cast<std::size_t>(y)});
  };
  for (std::ptrdiff_t d = static_cast<std::ptrdiff_t>(trace.size()) - 1; d >= 0; --d) {
    const auto& v = trace[static_cast<std::size_t>(d)];
    const std::ptrdiff_t k = x - y;
    const bool down = goes_down(v, k, d);
    const std::ptrdiff_t x_before = d == 0 ? 0 : down ? at(v, k + 1) : at(v, k - 1);
    const std::ptrdiff_t y_before = d == 0 ? 0 : x_before - (down ? k + 1 : k - 1);
    while (x > x_before && y > y_before) {
      step(' ');
    }
    if (d > 0) {
      step(down ? '+' : '-');
    }
  }
  std::ranges::reverse(out);
  return out;
}

// "3,7": from line 3 on seven lines; of an empty range the line before it stands.
std::string range(std::size_t first, std::size_t count) {
  const std::string start = std::to_string(count == 0 ? first : first + 1);
  return count == 1 ? start : start + ',' + std::to_string(count);
}

}  // namespace

std::string unified_diff(std::string_view before, std::string_view after, std::string_view before_name,
                         std::string_view after_name) {
  constexpr std::size_t context = 3;
  const Lines a = lines_of(before);
  const Lines b = lines_of(after);
  const std::vector<Step> way = steps(a, b);
  const auto changes = [](const Step& step) { return step.mark != ' '; };
  std::string out;
  auto change = std::ranges::find_if(way, changes);
  while (change != way.end()) {
    const auto from = change - std::min<std::ptrdiff_t>(context, change - way.begin());
    // A hunk goes on while the next change is near.
    auto last = change;
    for (auto next = change; next != way.end() && next - last <= 2 * static_cast<std::ptrdiff_t>(context) + 1;
         next = std::find_if(next + 1, way.end(), changes)) {
      last = next;
    }
    const auto to = last + 1 + std::min<std::ptrdiff_t>(context, way.end() - last - 1);
    if (out.empty()) {
      out.append("--- ").append(before_name).append("\n+++ ").append(after_name).append("\n");
    }
    const auto lines = [&](char without) {
      return static_cast<std::size_t>(
          std::count_if(from, to, [&](const Step& step) { return step.mark != without; }));
    };
    out += "@@ -" + range(from->a, lines('+')) + " +" + range(from->b, lines('-')) + " @@\n";
    for (auto step = from; step != to; ++step) {
      const std::string_view line = step->mark == '+' ? b[step->b] : a[step->a];
      out.append(1, step->mark).append(line);
      if (!line.ends_with('\n')) {
        out.append("\n\\ No newline at end of file\n");
      }
    }
    change = std::find_if(to, way.end(), changes);
  }
  return out;
}

}  // namespace rivid
