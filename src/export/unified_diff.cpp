#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/export/urdf.hpp"

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

// The shortest way from a to b by the greedy algorithm of Myers: of all points that d changes reach, diagonal
// by diagonal x − y, the furthest, for d = 0, 1, …
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
  constexpr std::size_t context = 3;  // lines, as diff -u has them
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
