#include "data/iso_time.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Takes the parts of a text from its front.
class IsoReader {
 public:
  explicit IsoReader(std::string_view text) : rest_(text) {}

  // A number of so many digits.
  std::optional<int> digits(std::size_t count) {
    int value = 0;
    if (rest_.size() < count) {
      return std::nullopt;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (rest_[i] < '0' || rest_[i] > '9') {
        return std::nullopt;
      }
      value = 10 * value + (rest_[i] - '0');
    }
    rest_.remove_prefix(count);
    return value;
  }

  // One of these characters; 0 for none of them.
  char one_of(std::string_view characters) {
    if (rest_.empty() || characters.find(rest_.front()) == std::string_view::npos) {
      return 0;
    }
    const char out = rest_.front();
    rest_.remove_prefix(1);
    return out;
  }

  // Digits behind a decimal mark.
  double fraction() {
    const std::size_t count = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
    const std::string number = "0." + std::string(rest_.substr(0, count));
    rest_.remove_prefix(count);
    return finite_number(number).value_or(0.0);
  }

  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

// Seconds of "+02:00", "-0930", "+02" behind their sign.
std::optional<int> offset(IsoReader& in, char sign) {
  const std::optional<int> hours = in.digits(2);
  if (!hours) {
    return std::nullopt;
  }
  in.one_of(":");
  const int minutes = in.at_end() ? 0 : in.digits(2).value_or(60);
  if (*hours > 23 || minutes > 59) {
    return std::nullopt;
  }
  return (sign == '-' ? -1 : 1) * (3600 * *hours + 60 * minutes);
}

}  // namespace

std::optional<IsoTime> iso_time(std::string_view text) {
  IsoReader in(text);
  const auto year = in.digits(4);
  if (!year || in.one_of("-") == 0) {
    return std::nullopt;
  }
  const auto month = in.digits(2);
  if (!month || in.one_of("-") == 0) {
    return std::nullopt;
  }
  const auto day = in.digits(2);
  if (!day || in.one_of("T ") == 0) {
    return std::nullopt;
  }
  const auto hours = in.digits(2);
  if (!hours || in.one_of(":") == 0) {
    return std::nullopt;
  }
  const auto minutes = in.digits(2);
  if (!minutes || in.one_of(":") == 0) {
    return std::nullopt;
  }
  const auto seconds = in.digits(2);
  const std::chrono::year_month_day date{std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!seconds || !date.ok() || *hours > 23 || *minutes > 59 || *seconds > 60) {
    return std::nullopt;
  }
  const double part = in.one_of(".,") != 0 ? in.fraction() : 0.0;
  in.one_of(" ");
  int east = 0;
  if (const char sign = in.one_of("+-"); sign != 0) {
    const auto found = offset(in, sign);
    if (!found) {
      return std::nullopt;
    }
    east = *found;
  } else {
    in.one_of("Z");
  }
  if (!in.at_end()) {
    return std::nullopt;
  }
  return IsoTime{.day = std::chrono::sys_days(date).time_since_epoch().count(),
                 .seconds = 3600 * *hours + 60 * *minutes + *seconds - east + part};
}

}  // namespace rivid::detail
