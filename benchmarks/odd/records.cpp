#include "odd/records.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <tuple>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::odd {

namespace {

constexpr std::string_view header =
    "seed,kind,way,number,method,used,status,outcome,material,counted,covered,rms_error,worst,worst_sigmas,"
    "worst_percent,warnings,friction,check,visible,joints,rate_hz,written_s,identified_s,message";
constexpr std::size_t columns = 24;
constexpr double seen_above = 0.2;  // of the squared residual
constexpr double tiny = 1e-300;     // in place of no error at all, under a logarithm

std::string key_of(const Name& name, const std::string& method) {
  return std::to_string(name.seed) + ' ' + name.text() + ' ' + method;
}

// Messages are the last column and may not end a line.
std::string on_a_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  std::ranges::replace(text, ',', ';');
  return text;
}

// "Fc 3 2;Fv 3 3".
std::string text_of(const decltype(Judgement::friction)& friction) {
  std::string out;
  for (const auto& [symbol, numbers] : friction) {
    out += (out.empty() ? "" : ";") + symbol + ' ' + std::to_string(numbers[0]) + ' ' +
           std::to_string(numbers[1]);
  }
  return out;
}

std::string line_of(const Record& r) {
  const Judgement& j = r.judgement;
  std::ostringstream out;
  out.precision(6);
  out << r.name.seed << ',' << r.name.kind->name << ',' << (r.name.way != nullptr ? r.name.way->name : "")
      << ',' << r.name.number << ',' << r.method << ',' << r.used << ',' << r.status << ',' << word(j.outcome)
      << ',' << (j.material ? 1 : 0) << ',' << j.counted << ',' << j.covered << ',' << j.rms_error << ','
      << j.worst << ',' << j.worst_sigmas << ',' << j.worst_percent << ',' << j.warnings << ','
      << text_of(j.friction) << ',' << r.check << ',' << r.visible << ',' << r.joints << ',' << r.rate_hz
      << ',' << r.written_s << ',' << r.identified_s << ',' << on_a_line(r.message);
  return out.str();
}

std::optional<Record> record_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    cells.push_back(cell);
  }
  cells.resize(std::max(cells.size(), columns));  // the message may be empty
  const auto kind = std::ranges::find(kinds(), cells[1], &Kind::name);
  if (kind == kinds().end()) {
    return std::nullopt;
  }
  const auto way = std::ranges::find(ways(), cells[2], &Way::name);
  Record out{
      .name = {std::stoull(cells[0]), &*kind, std::stoull(cells[3]), way == ways().end() ? nullptr : &*way},
      .method = cells[4],
      .used = cells[5],
      .status = cells[6],
      .check = cells[17],
      .message = cells[23],
      .judgement = {}};
  Judgement& j = out.judgement;
  for (const Outcome outcome : {Outcome::honest, Outcome::warned, Outcome::doubtful, Outcome::refused,
                                Outcome::wrong, Outcome::crashed}) {
    if (word(outcome) == cells[7]) {
      j.outcome = outcome;
    }
  }
  j.material = cells[8] == "1";
  j.counted = std::stol(cells[9]);
  j.covered = std::stol(cells[10]);
  j.rms_error = std::stod(cells[11]);
  j.worst = cells[12];
  j.worst_sigmas = std::stod(cells[13]);
  j.worst_percent = std::stod(cells[14]);
  j.warnings = cells[15];
  std::istringstream friction(cells[16]);
  for (std::string cell; std::getline(friction, cell, ';');) {
    std::istringstream words(cell);
    std::string symbol;
    std::array<Index, 2> numbers{};
    words >> symbol >> numbers[0] >> numbers[1];
    j.friction[symbol] = numbers;
  }
  out.visible = std::stod(cells[18]);
  out.joints = std::stoi(cells[19]);
  out.rate_hz = std::stod(cells[20]);
  out.written_s = std::stod(cells[21]);
  out.identified_s = std::stod(cells[22]);
  return out;
}

// What a line of a table counts.
struct Count {
  std::array<int, 6> outcomes{};
  int all = 0;
  int material = 0;
  int wrong_and_checked = 0;  // that check() has nothing against
  bool checked = false;
  int seen = 0;  // of which it is known whether the fault is visible
  int visible = 0;
  int wrong_and_visible = 0;
  Index counted = 0;
  Index covered = 0;
  double seconds = 0.0;

  void add(const Record& r) {
    ++all;
    ++outcomes[static_cast<std::size_t>(r.judgement.outcome)];
    material += r.judgement.material ? 1 : 0;
    checked = checked || r.check != "-";
    wrong_and_checked += r.judgement.outcome == Outcome::wrong && r.check.empty() ? 1 : 0;
    seen += std::isnan(r.visible) ? 0 : 1;
    visible += r.visible > seen_above ? 1 : 0;
    wrong_and_visible += r.visible > seen_above && r.judgement.outcome == Outcome::wrong ? 1 : 0;
    counted += r.judgement.counted;
    covered += r.judgement.covered;
    seconds += r.identified_s;
  }

  [[nodiscard]] std::string cells() const {
    const auto percent = [&](int part) { return fixed(100.0 * part / all, 1); };
    std::string out = " | " + std::to_string(all);
    for (const Outcome outcome : {Outcome::honest, Outcome::warned, Outcome::doubtful, Outcome::refused}) {
      out += " | " + percent(outcomes[static_cast<std::size_t>(outcome)]);
    }
    out += " | **" + percent(outcomes[static_cast<std::size_t>(Outcome::wrong)]) + "** (" +
           percent(material) + (checked ? "; " + percent(wrong_and_checked) : "") + ")";
    out += " | " + std::to_string(outcomes[static_cast<std::size_t>(Outcome::crashed)]);
    out +=
        " | " + (counted > 0 ? fixed(100.0 * static_cast<double>(covered) / static_cast<double>(counted), 1)
                             : std::string("–"));
    out += " | " + fixed(1e3 * seconds / all, 0);
    if (seen > 0) {
      out += " | " + std::to_string(wrong_and_visible) + " of " + std::to_string(visible);
    }
    return out + " |\n";
  }
};

std::vector<std::string_view> groups() {
  std::vector<std::string_view> out;
  for (const Kind& kind : kinds()) {
    if (std::ranges::find(out, kind.group) == out.end()) {
      out.push_back(kind.group);
    }
  }
  return out;
}

std::string table(std::span<const Record> records, const std::string& method) {
  std::map<std::string_view, Count> by_kind;
  std::map<std::string_view, Count> by_group;
  std::map<std::string_view, Count> by_way;
  Count rest;
  bool checked = false;
  bool seen = false;
  for (const Record& r : records) {
    if (r.method == method) {
      by_kind[r.name.kind->name].add(r);
      by_group[r.name.kind->group].add(r);
      if (r.name.way != nullptr) {
        by_way[r.name.way->name].add(r);
      }
      rest.add(r);
      checked = checked || r.check != "-";
      seen = seen || !std::isnan(r.visible);
    }
  }
  std::string out = "Method: " + method +
                    "\n\n| kind | N | honest % | warned % | doubtful % | refused % | wrong % (material" +
                    (checked ? "; check clean too" : "") + ") | crashed | coverage % | time [ms] |" +
                    (seen ? " wrong of visible |" : "") + "\n|---|---|---|---|---|---|---|---|---|---|" +
                    (seen ? "---|" : "") + '\n';
  for (const std::string_view group : groups()) {
    if (!by_group.contains(group)) {
      continue;
    }
    out += "| **" + std::string(group) + "**" + by_group[group].cells();
    for (const Kind& kind : kinds()) {
      if (kind.group == group && kind.name != group && by_kind.contains(kind.name)) {
        out += "| " + std::string(kind.name) + by_kind[kind.name].cells();
      }
    }
  }
  for (auto& [way, count] : by_way) {
    out += "| *" + std::string(way) + "*" + count.cells();
  }
  return out + "| **all**" + rest.cells();
}

// A method beside WLS.
struct Comparison {
  int answered_by_wls = 0;
  int answered = 0;  // of these
  double sum = 0.0;  // of the logarithms of the ratios of errors
};

// Geometric means of the errors over those of WLS, over the experiments that both identified.
std::string comparison(std::span<const Record> records, const std::string& method) {
  std::map<std::string, double> of_wls;
  for (const Record& r : records) {
    if (r.method == "wls" && r.status == "identified") {
      of_wls[key_of(r.name, {})] = r.judgement.rms_error;
    }
  }
  std::map<std::string_view, Comparison> found;
  for (const Record& r : records) {
    const auto wls = of_wls.find(key_of(r.name, {}));
    if (r.method != method || wls == of_wls.end()) {
      continue;
    }
    // A group of one kind has its name.
    for (const std::string_view name : std::set{r.name.kind->name, r.name.kind->group}) {
      Comparison& line = found[name];
      ++line.answered_by_wls;
      if (r.status == "identified") {
        ++line.answered;
        line.sum += std::log(std::max(r.judgement.rms_error, tiny) / std::max(wls->second, tiny));
      }
    }
  }
  std::string out;
  const auto add = [&](std::string_view name, const std::string& shown) {
    if (const auto line = found.find(name); line != found.end()) {
      const Comparison& it = line->second;
      out += "| " + shown + " | " + std::to_string(it.answered_by_wls) + " | " +
             fixed(100.0 * it.answered / it.answered_by_wls, 1) + " | " +
             (it.answered > 0 ? number(std::exp(it.sum / it.answered), 3) : std::string("–")) + " |\n";
    }
  };
  for (const std::string_view group : groups()) {
    add(group, "**" + std::string(group) + "**");
    for (const Kind& kind : kinds()) {
      if (kind.group == group && kind.name != group) {
        add(kind.name, std::string(kind.name));
      }
    }
  }
  return out.empty() ? out
                     : "\n| kind | answered by wls | of these by " + method +
                           " % | rms error over that of wls |\n|---|---|---|---|\n" + out;
}

// The most frequent codes of lists "a;b", each with the share of the lists that it is in.
std::string frequent(const std::vector<std::string>& lists) {
  constexpr std::size_t shown = 4;
  std::map<std::string, int> counts;
  for (const std::string& list : lists) {
    std::set<std::string> codes;
    std::istringstream in(list);
    for (std::string code; std::getline(in, code, ';');) {
      codes.insert(code);
    }
    for (const std::string& code : codes) {
      ++counts[code];
    }
  }
  std::vector<std::pair<int, std::string>> sorted;
  for (const auto& [code, count] : counts) {
    sorted.emplace_back(-count, code);
  }
  std::ranges::sort(sorted);
  std::string out;
  for (std::size_t i = 0; i < std::min(shown, sorted.size()); ++i) {
    out += (out.empty() ? "" : ", ") + sorted[i].second + ' ' +
           fixed(-100.0 * sorted[i].first / static_cast<double>(lists.size()), 0);
  }
  return out;
}

}  // namespace

RecordFile::RecordFile(std::filesystem::path file) : file_(std::move(file)) {
  std::ifstream in(file_);
  std::string line;
  if (!std::getline(in, line)) {
    std::ofstream(file_) << header << '\n';
    return;
  }
  if (line != header) {
    throw InputError(file_.string() + ": has other columns than the records of this program");
  }
  while (std::getline(in, line)) {
    if (const std::optional<Record> record = record_of(line)) {
      records_.push_back(*record);
      keys_.insert(key_of(record->name, record->method));
    }
  }
}

bool RecordFile::has(const Name& name, const std::string& method) const {
  return keys_.contains(key_of(name, method));
}

void RecordFile::append(std::span<const Record> records) {
  const std::lock_guard lock(mutex_);
  std::ofstream out(file_, std::ios::app);
  for (const Record& record : records) {
    out << line_of(record) << '\n';
    records_.push_back(record);
  }
  if (!out.flush()) {
    throw InputError(file_.string() + ": can not be written");
  }
}

std::string tables(std::span<const Record> records) {
  std::vector<std::string> methods;
  for (const Record& r : records) {
    if (std::ranges::find(methods, r.method) == methods.end()) {
      methods.push_back(r.method);
    }
  }
  std::string out;
  for (const std::string& method : methods) {
    out += (out.empty() ? "" : "\n") + table(records, method);
  }
  for (const std::string& method : methods) {
    out += method == "wls" ? std::string() : comparison(records, method);
  }
  return out;
}

std::string friction_table(std::span<const Record> records) {
  std::map<std::tuple<std::string_view, std::string_view, std::string_view>, std::array<Index, 2>> sums;
  for (const Record& r : records) {
    for (const auto& [symbol, numbers] : r.judgement.friction) {
      auto& sum = sums[{r.method, r.name.kind->name, symbol}];
      sum[0] += numbers[0];
      sum[1] += numbers[1];
    }
  }
  std::string out = "\n| method | kind | friction parameter | N | coverage % |\n|---|---|---|---|---|\n";
  for (const auto& [key, sum] : sums) {
    const auto& [method, kind, symbol] = key;
    out += "| " + std::string(method) + " | " + std::string(kind) + " | " + std::string(symbol) + " | " +
           std::to_string(sum[0]) + " | " +
           fixed(100.0 * static_cast<double>(sum[1]) / static_cast<double>(sum[0]), 1) + " |\n";
  }
  return out;
}

std::string code_table(std::span<const Record> records) {
  std::map<std::pair<std::string, std::string_view>, std::array<std::vector<std::string>, 2>> lists;
  for (const Record& r : records) {
    auto& found = lists[{r.method, r.name.kind->name}];
    found[0].push_back(r.judgement.warnings);
    found[1].push_back(r.check == "-" ? "" : r.check);
  }
  std::string out =
      "\n| method | kind | warnings of the result, % | findings of check, % |\n|---|---|---|---|\n";
  for (const auto& [key, found] : lists) {
    out += "| " + key.first + " | " + std::string(key.second) + " | " + frequent(found[0]) + " | " +
           frequent(found[1]) + " |\n";
  }
  return out;
}

}  // namespace rivid::odd
