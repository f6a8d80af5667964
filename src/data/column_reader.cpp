#include "column_reader.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>

#include "data/iso_time.hpp"
#include "dialect.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"
#include "row_reader.hpp"
#include "threads.hpp"

namespace rivid::detail {

namespace {

// Bytes of a stretch: milliseconds of work, and little beside a file that is worth a second thread.
constexpr std::size_t stretch_bytes = std::size_t{1} << 20U;
// Bytes from one report of progress to the next.
constexpr std::size_t progress_bytes = std::size_t{8} << 20U;

// "#3" → 3; 0 where the text is no such number.
std::size_t field_number(std::string_view name) {
  std::size_t number = 0;
  if (!name.starts_with('#')) {
    return 0;
  }
  const char* const last = name.data() + name.size();
  const auto [end, error] = std::from_chars(name.data() + 1, last, number);
  return error == std::errc() && end == last ? number : 0;
}

// Fields by their names: the first two of each.
class FieldIndex {
 public:
  explicit FieldIndex(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto [at, is_new] = fields_.try_emplace(names[i], i, i);
      if (!is_new && at->second.first == at->second.second) {
        at->second.second = i;
      }
    }
  }

  // Both the same where one field alone has the name.
  [[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> find(std::string_view name) const {
    const auto at = fields_.find(name);
    return at == fields_.end() ? std::nullopt : std::optional(at->second);
  }

 private:
  std::unordered_map<std::string_view, std::pair<std::size_t, std::size_t>> fields_;
};

std::size_t chosen_field(const std::string& name, const Dialect& dialect, const FieldIndex& index,
                         const std::string& source) {
  const std::vector<std::string>& names = dialect.names;
  if (const auto found = index.find(name)) {
    if (found->first != found->second) {
      throw InputError(source + ": the column name " + in_quotes(name) + " stands more than once; ask for " +
                       field_name(found->first + 1) + " or " + field_name(found->second + 1));
    }
    return found->first;
  }
  const std::size_t number = field_number(name);
  if (number >= 1 && number <= names.size()) {
    return number - 1;
  }
  if (number > 0) {
    throw InputError(source + ": there is no column " + name + "; the lines have " +
                     std::to_string(names.size()) + " fields");
  }
  if (!dialect.header) {
    throw InputError(source + ": there is no column " + in_quotes(name) +
                     ", as no line names the columns; ask for them by number, #1 to #" +
                     std::to_string(names.size()));
  }
  throw InputError(source + ": there is no column " + in_quotes(name) + "; the columns are " + listed(names) +
                   did_you_mean(name, names));
}

// The fields that are asked for, counted from 0.
std::vector<std::size_t> chosen_fields(const TableOptions& options, const Dialect& dialect,
                                       const std::string& source) {
  std::vector<std::size_t> out;
  if (options.columns.empty()) {
    for (std::size_t field = 0; field < dialect.names.size(); ++field) {
      out.push_back(field);
    }
    return out;
  }
  const FieldIndex index(dialect.names);
  for (const std::string& name : options.columns) {
    out.push_back(chosen_field(name, dialect, index, source));
  }
  return out;
}

// The day of the first date among the fields of a line that are asked for.
std::optional<std::int64_t> day_of(std::string_view line, const Dialect& dialect,
                                   std::vector<std::size_t> fields) {
  std::vector<std::string_view> cells;
  split(line, dialect.separator, cells);
  std::ranges::sort(fields);
  for (const std::size_t field : fields) {
    if (const auto instant = field < cells.size() ? iso_time(cells[field]) : std::nullopt) {
      return instant->day;
    }
  }
  return std::nullopt;
}

std::size_t line_ends(std::string_view text) {
  std::size_t count = 0;
  const char* p = text.data();
  const char* const end = p + text.size();
  while (const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p))) {
    ++count;
    p = static_cast<const char*>(found) + 1;
  }
  return count;
}

// Adds the lines of further rows, of which none are known for rows behind the last run.
void append(LineNumbers& lines, const LineNumbers& more, Index row_of_first) {
  const Index moved = more.runs.empty() ? 0 : row_of_first - more.runs.front().row;
  for (const LineNumbers::Run& run : more.runs) {
    const Index row = run.row + moved;
    if (!lines.runs.empty() && lines.runs.back().row == row) {
      lines.runs.back().line = run.line;
    } else if (lines.runs.empty() || lines[row] != run.line) {
      lines.runs.push_back({row, run.line});
    }
  }
}

// Whole lines, and what reading them came to.
struct Stretch {
  std::string_view text;
  std::size_t end = 0;   // offset of the first byte behind it in the file
  std::size_t line = 0;  // number of its first line
  Index row = 0;         // of its first row
  Index rows = 0;
  LineNumbers lines;
  RowReader::End ended = RowReader::End::complete;
  std::size_t ended_at = 0;  // line
  std::exception_ptr failure = {};

  [[nodiscard]] bool ended_in(RowReader::End how) const { return !failure && ended == how; }
  [[nodiscard]] bool complete() const { return ended_in(RowReader::End::complete); }
};

// The file in stretches, to be read with one format or another.
class Stretches {
 public:
  Stretches(InputText& input, const Dialect& dialect) : input_(input), dialect_(dialect) {
    const std::string_view data = input.bytes().substr(dialect.begin);
    // The last lines go through a copy that ends in a line end and in bytes that may be read past it.
    const std::size_t kept = std::min(data.size(), number_padding);
    const std::size_t last = data.substr(0, data.size() - kept).rfind('\n');
    const std::size_t main = last == std::string_view::npos ? 0 : last + 1;
    for (std::size_t begin = 0, end = 0; begin < main; begin = end) {
      end = std::min(begin + stretch_bytes, main);
      end = data.find('\n', end - 1) + 1;
      all_.push_back({.text = data.substr(begin, end - begin), .end = dialect.begin + end, .lines = {}});
    }
    tail_ = data.substr(main);
    if (!tail_.ends_with('\n')) {
      tail_ += '\n';
    }
    const std::size_t size = tail_.size();
    tail_.append(number_padding, '\n');
    all_.push_back(
        {.text = std::string_view(tail_).substr(0, size), .end = input.bytes().size(), .lines = {}});
    workers_ =
        std::min<std::size_t>(std::max(std::thread::hardware_concurrency(), 1U), (all_.size() + 1) / 2);
    count_lines();
  }

  // The number of lines, and no more than the bytes allow for: a file of blank lines must not claim memory.
  [[nodiscard]] Index most_rows(std::size_t columns) const {
    const std::size_t least_bytes = 2 * std::max<std::size_t>(columns, 1);
    const std::size_t bytes = input_.bytes().size() - dialect_.begin;
    return static_cast<Index>(std::min(lines_, (bytes + 1) / least_bytes + 1));
  }

  // Reads all rows. Where a stretch did not end well, the first of them.
  //
  // progress  called by the calling thread; may be empty
  const Stretch* read(const RowFormat& format, std::size_t columns,
                      const std::function<void(double)>& progress) {
    if (workers_ == 1 || static_cast<Index>(lines_) > most_rows(columns)) {
      return read_one_by_one(0, 0, format, progress);
    }
    const std::size_t bad = read_together(format, progress);
    if (bad == all_.size()) {
      return nullptr;
    }
    if (all_[bad].ended_in(RowReader::End::date_found)) {
      return read_one_by_one(bad, all_[bad].row, format, progress);
    }
    return &all_[bad];
  }

  // Closes the gaps that lines without a row have left between stretches; the rows that there are.
  [[nodiscard]] ReadColumns joined(const std::vector<double*>& columns) const {
    ReadColumns out;
    for (const Stretch& stretch : all_) {
      for (double* const column : columns) {
        if (stretch.row != out.rows) {
          std::memmove(column + out.rows, column + stretch.row,
                       static_cast<std::size_t>(stretch.rows) * sizeof(double));
        }
      }
      append(out.lines, stretch.lines, out.rows);
      out.rows += stretch.rows;
    }
    if (!out.lines.runs.empty() && out.lines.runs.back().row == out.rows) {
      out.lines.runs.pop_back();  // of comments behind the last row
    }
    return out;
  }

 private:
  // Calls work(worker) on several threads.
  template <typename Work>
  void run(const Work& work) const {
    std::vector<std::jthread> others;
    for (std::size_t worker = 1; worker < workers_ && started(others, work, worker); ++worker) {
    }
    work(std::size_t{0});
  }

  void count_lines() {
    std::vector<std::size_t> counts(all_.size());
    std::atomic<std::size_t> next = 0;
    run([&](std::size_t /*worker*/) {
      for (std::size_t k = next++; k < all_.size(); k = next++) {
        counts[k] = line_ends(all_[k].text);
      }
    });
    for (std::size_t k = 0; k < all_.size(); ++k) {
      all_[k].line = dialect_.line + lines_;
      all_[k].row = static_cast<Index>(lines_);
      lines_ += counts[k];
    }
  }

  static void read_stretch(RowReader& reader, Stretch& stretch) {
    stretch.failure = {};
    try {
      stretch.ended = reader.read(stretch.text, stretch.row, stretch.line);
      stretch.rows = reader.row() - stretch.row;
      stretch.lines = reader.lines();
      stretch.ended_at = reader.line();
    } catch (...) {
      stretch.failure = std::current_exception();
    }
  }

  // From a stretch and its row on; the stretch that did not end well.
  const Stretch* read_one_by_one(std::size_t first, Index row, const RowFormat& format,
                                 const std::function<void(double)>& progress) {
    RowReader reader(format, true);
    for (std::size_t k = first; k < all_.size(); ++k) {
      Stretch& stretch = all_[k];
      stretch.row = row;
      read_stretch(reader, stretch);
      if (!stretch.complete()) {
        return &stretch;
      }
      row += stretch.rows;
      finish(stretch.end, format, progress);
    }
    return nullptr;
  }

  // Each stretch has its rows where they are if all lines before it hold one. The first stretch that did not
  // end well; those before it did.
  std::size_t read_together(const RowFormat& format, const std::function<void(double)>& progress) {
    std::atomic<std::size_t> next = 0;
    std::mutex finishing;
    std::size_t first_bad = all_.size();
    std::vector<bool> done(all_.size(), false);
    std::size_t finished = 0;
    const auto goes_on = [&](std::size_t k) {
      const std::scoped_lock lock(finishing);
      return k < first_bad;
    };
    run([&](std::size_t worker) {
      for (std::size_t k = next++; k < all_.size() && goes_on(k); k = next++) {
        RowReader reader(format, false);
        read_stretch(reader, all_[k]);
        const std::scoped_lock lock(finishing);
        if (!all_[k].complete()) {
          first_bad = std::min(first_bad, k);
          return;
        }
        done[k] = true;
        while (finished < all_.size() && done[finished]) {
          ++finished;
        }
        if (finished > 0) {
          finish(all_[finished - 1].end, format, worker == 0 ? progress : std::function<void(double)>());
        }
      }
    });
    return first_bad;
  }

  // All bytes before an offset of the file were read.
  void finish(std::size_t offset, const RowFormat& format, const std::function<void(double)>& progress) {
    if (!format.may_switch) {
      input_.forget(offset);
    }
    if (progress && offset >= next_progress_) {
      next_progress_ = offset + progress_bytes;
      progress(static_cast<double>(offset) / static_cast<double>(input_.bytes().size()));
    }
  }

  InputText& input_;
  const Dialect& dialect_;
  std::string tail_;
  std::vector<Stretch> all_;
  std::size_t lines_ = 0;
  std::size_t workers_ = 1;
  std::size_t next_progress_ = progress_bytes;
};

}  // namespace

ReadColumns read_columns(InputText& text, const std::string& source, const TableOptions& options,
                         const ColumnRoom& room) {
  const Dialect dialect = detail::dialect(text.bytes(), source, options);
  const std::vector<std::size_t> fields = chosen_fields(options, dialect, source);
  const std::size_t distinct = std::set(fields.begin(), fields.end()).size();
  Stretches stretches(text, dialect);
  RowFormat format{.dialect = dialect,
                   .source = source,
                   .mark = options.decimal == Decimal::comma ? ',' : '.',
                   .targets = {}};
  const std::string_view data = text.bytes().substr(dialect.begin);
  format.first_day = day_of(data.substr(0, data.find('\n')), dialect, fields);
  while (true) {
    // Whether a comma in a number makes all be read again.
    format.may_switch =
        format.mark == '.' && options.decimal == Decimal::automatic && dialect.separator != ',';
    const std::vector<double*> columns = room(fields.size(), stretches.most_rows(distinct));
    format.targets.assign(dialect.names.size(), nullptr);
    for (std::size_t k = 0; k < fields.size(); ++k) {
      format.targets[fields[k]] = columns[k];
    }
    const Stretch* const bad = stretches.read(format, distinct, options.progress);
    if (bad == nullptr) {
      ReadColumns out = stretches.joined(columns);
      for (std::size_t k = 0; k < fields.size(); ++k) {
        // A field that is asked for more than once was read once.
        if (const double* const read = format.targets[fields[k]]; read != columns[k]) {
          std::copy_n(read, out.rows, columns[k]);
        }
        out.names.push_back(dialect.names[fields[k]]);
        out.fields.push_back(fields[k] + 1);
      }
      if (options.progress) {
        options.progress(1.0);
      }
      return out;
    }
    if (bad->failure) {
      std::rethrow_exception(bad->failure);
    }
    format.mark = ',';
    format.comma_line = bad->ended_at;
  }
}

}  // namespace rivid::detail
