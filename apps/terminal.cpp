#include "terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::apps {

namespace {

// Names from files may hold escape sequences, which a terminal must not obey.
std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\n\t"), text.size());
    out += on_one_line(text.substr(0, end));
    out += text.substr(end, 1);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

// Whether a stream is coloured: --color, and by default a terminal unless NO_COLOR is set
// (https://no-color.org).
bool in_colours(int stream) {
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string_view(value != nullptr ? value : "");
  };
  const std::string& when = when_coloured();
  return when == "always" || (when == "auto" && ::isatty(stream) == 1 && variable("NO_COLOR").empty() &&
                              variable("TERM") != "dumb");
}

// Errors are red, warnings yellow, notes blue.
std::string coloured(std::string_view kind, int stream) {
  const std::string_view code = kind == "error" || kind == "failure" ? "31"
                                : kind == "warning"                  ? "33"
                                : kind == "note"                     ? "34"
                                                                     : "";
  return code.empty() || !in_colours(stream)
             ? std::string(kind)
             : "\033[1;" + std::string(code) + "m" + std::string(kind) + "\033[0m";
}

// Lines that begin with the severity of a finding, as "  warning [loop_mismatch] …", with that word in
// colour.
std::string with_colours(const std::string& text, int stream) {
  if (!in_colours(stream)) {
    return text;
  }
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t end = std::min(line.find_first_of(" :", begin), line.size());
    out += line.substr(0, begin) + coloured(line.substr(begin, end - begin), stream) + line.substr(end);
    out += lines.eof() ? "" : "\n";
  }
  return out;
}

using namespace std::chrono_literals;
constexpr auto patience = 1s;
constexpr auto redraw = 100ms;
constexpr int bar_width = 30;  // characters; a choice of layout

}  // namespace

std::string& when_coloured() {
  static std::string when = "auto";
  return when;
}

void complain(std::string_view name, std::string_view kind, std::string_view what) {
  std::cerr << name << ": " << coloured(kind, STDERR_FILENO) << ": " << on_one_line(what) << '\n';
}

void print(const std::string& text) {
  if (!(std::cout << with_colours(printable(text), STDOUT_FILENO) << std::flush)) {
    throw InputError("standard output can not be written to");
  }
}

std::size_t screen_width() {
  constexpr std::size_t narrowest = 40;  // characters of a line; tables fit no less
  winsize window = {};
  const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
  return known ? std::max<std::size_t>(window.ws_col, narrowest) : 0;
}

void tell(const std::string& text) { std::cerr << with_colours(printable(text), STDERR_FILENO); }

void tell(std::string_view kind, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::cerr << coloured(kind, STDERR_FILENO) << ": " << on_one_line(line) << '\n';
  }
}

void tell(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    std::cerr << with_colours(on_one_line(in_words(finding)), STDERR_FILENO) << '\n';
  }
}

void tell_written(const std::vector<PlannedFile>& files) {
  for (const PlannedFile& file : files) {
    tell("wrote " + file.path.string() + "\n");
  }
}

void show_page(const std::filesystem::path& page) {
  const std::string file = std::filesystem::absolute(page).string();
  tell("open " + file + "\n");
  const bool screen = std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
  if (!screen || ::isatty(STDOUT_FILENO) == 0 || ::fork() != 0) {
    return;
  }
  ::execlp("xdg-open", "xdg-open", file.c_str(), nullptr);
  ::_exit(1);
}

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && ::isatty(STDERR_FILENO) == 1), next_(Clock::now() + patience) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::operator()(std::string_view stage, double fraction) {
  const Clock::time_point now = Clock::now();
  if (!wanted_ || now < next_) {
    return;
  }
  next_ = now + redraw;
  drawn_ = true;
  const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * bar_width);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(bar_width - filled), '.');
  std::fprintf(stderr, "\r\033[K[%s] %3.0f %%  %.*s", bar.c_str(), 100.0 * fraction,
               static_cast<int>(stage.size()), stage.data());
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (drawn_) {
    std::fputs("\r\033[K", stderr);
    drawn_ = false;
  }
}

}  // namespace rivid::apps
