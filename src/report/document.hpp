#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "rivid/finding.hpp"
#include "rivid/types.hpp"

// What a result says: sections of typed tables, sentences, findings and plots. Who makes a document decides
// every word, number and mark; text.cpp and html.cpp show it and decide nothing but how it looks.
namespace rivid::detail {

// A screen is narrow and has no plots, a page has them all.
enum class Shown { everywhere, screen, page };

// What a row or an item is singled out for.
enum class Mark {
  none,
  weak,    // the data hardly determine it
  unseen,  // the data do not show it
  apart,   // farther from another estimate than the intervals are wide
  gone,    // taken out of the model
  sum,     // of the rows above
  good,
  mixed,
  bad
};

// What stands for a mark in text: "?", "x", "!", "-", "✓", "✗"; nothing for sums.
[[nodiscard]] std::string_view sign(Mark mark);
// "weak", as style sheets call it.
[[nodiscard]] std::string_view name(Mark mark);

// How the cells of a column become text. Numbers stand at the right, everything else at the left.
struct Format {
  enum class Kind {
    text,
    name,         // a text that the row is called by
    code,         // a text for a program
    significant,  // so many digits
    fixed,        // so many decimals
    percent,      // of a fraction, with so many decimals
    deviation,    // as many decimals as the deviation of the value asks for
    interval,     // drawn
    share,        // drawn
    stack         // drawn
  };
  Kind kind = Kind::text;
  int digits = 0;

  [[nodiscard]] bool number() const { return kind >= Kind::significant && kind <= Kind::deviation; }
  [[nodiscard]] bool drawn() const { return kind >= Kind::interval; }
};

namespace format {
inline constexpr Format text = {};
inline constexpr Format name = {Format::Kind::name};
inline constexpr Format code = {Format::Kind::code};
inline constexpr Format count = {Format::Kind::fixed, 0};
inline constexpr Format percent = {Format::Kind::percent, 3};
inline constexpr Format deviation = {Format::Kind::deviation};
inline constexpr Format interval = {Format::Kind::interval};
inline constexpr Format share = {Format::Kind::share};
inline constexpr Format stack = {Format::Kind::stack};
constexpr Format significant(int digits) { return {Format::Kind::significant, digits}; }
constexpr Format fixed(int decimals) { return {Format::Kind::fixed, decimals}; }
constexpr Format percents(int decimals) { return {Format::Kind::percent, decimals}; }
}  // namespace format

struct Column {
  std::string heading;
  Format format = format::text;
  std::string unit = {};  // behind each of its numbers
  Shown shown = Shown::everywhere;
};

// An interval on an axis of its own, with a value in it and one to compare it with.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  double value = 0.0;
  double reference = std::numeric_limits<double>::quiet_NaN();
  std::string label = {};
};

// Parts of a bar, from its left end.
struct Stack {
  struct Part {
    std::string style;   // as style sheets call it
    double share = 0.0;  // of the width
  };
  std::vector<Part> parts;
  std::string label = {};
};

struct Cell {
  std::variant<std::string, double, Interval, Stack> value;
  double sigma = std::numeric_limits<double>::quiet_NaN();  // deviation of the value, for its decimals

  Cell(std::string text) : value(std::move(text)) {}
  Cell(const char* text) : value(std::string(text)) {}
  Cell(double number) : value(number) {}
  Cell(std::integral auto count) : value(static_cast<double>(count)) {}
  Cell(double number, double deviation) : value(number), sigma(deviation) {}
  Cell(Interval drawn) : value(std::move(drawn)) {}
  Cell(Stack drawn) : value(std::move(drawn)) {}
};

struct Row {
  std::vector<Cell> cells;  // one a column
  Mark mark = Mark::none;
};

// A block that a page folds away under this title; nothing: not folded.
struct Fold {
  std::string title = {};
  bool open = false;
};

struct Table {
  std::vector<Column> columns;
  std::vector<Row> rows = {};
  Fold fold = {};
};

// One column of a table with a row for each of some records: what it is called, how it is shown, where it
// comes from.
template <typename Record>
struct ColumnOf {
  Column column;
  std::function<Cell(const Record&)> cell;
};

// @param mark  of a record's row
template <typename Records, typename Record = std::ranges::range_value_t<Records>>
[[nodiscard]] Table table_of(const Records& records, const std::vector<ColumnOf<Record>>& fields,
                             const std::type_identity_t<std::function<Mark(const Record&)>>& mark = {}) {
  Table out;
  for (const ColumnOf<Record>& field : fields) {
    out.columns.push_back(field.column);
  }
  for (const auto& record : records) {
    Row& row = out.rows.emplace_back(Row{{}, mark ? mark(record) : Mark::none});
    for (const ColumnOf<Record>& field : fields) {
      row.cells.push_back(field.cell(record));
    }
  }
  return out;
}

// What one record of a list says, by its place in the list. Rows of such tables are places in several lists.
using Indexed = ColumnOf<std::size_t>;

[[nodiscard]] inline auto places(std::size_t count) { return std::views::iota(std::size_t{0}, count); }

// Not a number behind the end.
[[nodiscard]] inline double at(const Vector& values, std::size_t i) {
  const auto k = static_cast<Index>(i);
  return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
}

// One thought, without its full stop.
struct Sentence {
  std::string text;
};

// A title within a section.
struct Heading {
  std::string text;
};

struct Item {
  std::string name = {};  // what the text is about; it follows at once
  std::string text = {};
  Mark mark = Mark::none;
};

struct List {
  std::string kind;  // "reasons", as style sheets call it
  std::vector<Item> items = {};
  Fold fold = {};
};

struct FindingList {
  static constexpr std::size_t shown = 3;  // at once: who reads twenty mends nothing
  std::vector<Finding> findings;
};

// Values that are shown large, each with what it is.
struct KeyFigures {
  std::vector<std::pair<std::string, std::string>> figures;
};

// What the colours of plots mean, by their names in style sheets.
struct Legend {
  std::vector<std::pair<std::string, std::string>> keys;
  std::string remark = {};
};

// Values over others: one curve, cloud, band or row of bars of a chart.
struct Series {
  enum class Kind { line, points, band, bars };
  std::string name;   // in legend and data
  std::string style;  // as style sheets call it
  Kind kind = Kind::line;
  Vector x = {};           // of bars their middles
  Vector y = {};           // not a number: a gap
  Vector upper = {};       // of a band
  bool exact = false;      // data in double precision, else single
  bool on_demand = false;  // hidden until the reader asks for it
  bool in_legend = true;
};

}  // namespace rivid::detail

namespace rivid {

template <>
inline constexpr std::array names_of<detail::Series::Kind> =
    std::to_array<std::string_view>({"line", "points", "band", "bars"});

}  // namespace rivid

namespace rivid::detail {

// A line over the whole width or height of a chart.
struct Rule {
  bool upright = true;
  double at = 0.0;
  std::string style;
};

// Series over two axes.
struct Chart {
  enum class Size { panel, wide };
  std::string id = {};  // of the figure, for links and names of files
  std::string title = {};
  std::string remark = {};
  std::string label = {};  // for a reader who does not see it
  std::string x_label = {};
  std::string y_label = {};
  std::vector<Series> series = {};
  std::vector<Rule> rules = {};
  std::vector<double> x_shown = {};  // values that the axes reach, besides the data
  std::vector<double> y_shown = {};
  bool logarithmic = false;  // ordinate
  Size size = Size::panel;
  double height = 230.0;
  std::optional<std::size_t> log = {};  // over the time of that log, along which the reader can move

  // As style sheets call it; those of all plots.
  [[nodiscard]] std::string_view style() const { return size == Size::wide ? "chart wide" : "chart panel"; }
};

// Columns as curves, each in a colour of its own.
[[nodiscard]] std::vector<Series> curves(const Vector& t, const std::vector<std::string>& names,
                                         const Matrix& columns);
// A chart over time; `label` is what it is to a reader who does not see it.
[[nodiscard]] Chart time_chart(const std::string& id, const std::string& title, const std::string& label,
                               const std::string& y_label, std::vector<Series> series,
                               Chart::Size size = Chart::Size::wide);

// A symmetric matrix of values between −1 and 1, as colours.
struct HeatMap {
  std::string id;
  std::string title;
  std::string remark;
  std::string label;
  std::vector<std::string> names;
  Matrix values;

  [[nodiscard]] static std::string_view style() { return "chart heat"; }
};

// Lines and ellipsoids in space, which the reader can turn.
struct Skeleton {
  struct Trace {
    std::string name;
    std::string style;                    // as style sheets call it
    std::vector<Eigen::Vector3d> points;  // [m]
  };
  struct Pose {
    double t = 0.0;                       // [s]
    std::vector<Eigen::Vector3d> joints;  // [m]
  };
  struct Ellipsoid {
    std::string name;
    std::string style;
    double mass = 0.0;  // [kg]
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();  // semi-axes as columns
  };
  std::string id;
  std::string title;
  std::string remark;
  std::string label;
  std::vector<Eigen::Vector3d> joints;  // of the line from base to tip [m]
  std::vector<Ellipsoid> ellipsoids = {};
  std::vector<Trace> traces = {};
  std::vector<Pose> poses = {};  // that the reader can go through, evenly in time

  [[nodiscard]] static std::string_view style() { return "chart skeleton"; }
};

// One row a value, with its interval and what it should be.
struct DotPlot {
  struct Dot {
    std::string name;
    Interval interval;
    Mark mark = Mark::none;
  };
  std::string id;
  std::string title;
  std::string remark;
  std::string label;
  std::string x_label;
  double reference = 0.0;
  std::array<double, 2> wanted = {};
  std::vector<Dot> dots = {};

  [[nodiscard]] static std::string_view style() { return "chart panel"; }
};

// How a value came to its interval, step by step.
struct PathPlot {
  std::string id;
  std::string title;
  std::string remark;  // the value that it came to
  std::string label;
  std::vector<double> steps;
  std::optional<std::array<double, 2>> interval = {};

  [[nodiscard]] static std::string_view style() { return "small"; }
};

using Plot = std::variant<Chart, HeatMap, Skeleton, DotPlot, PathPlot>;

struct Plots {
  struct Group {
    std::string heading = {};
    std::string remark = {};
    std::vector<Plot> plots = {};
  };
  std::string layout;  // "hero", "panels", "paths" or one under the other
  std::vector<Group> groups = {};
  Fold fold = {};
};

struct Block {
  std::variant<Sentence, Heading, Table, List, FindingList, KeyFigures, Legend, Plots> content;
  Shown shown = Shown::everywhere;
};

// Plots without a heading.
[[nodiscard]] inline Block plots_block(std::string layout, std::vector<Plot> plots,
                                       Shown shown = Shown::everywhere) {
  return {Plots{std::move(layout), {{"", "", std::move(plots)}}}, shown};
}

struct Section {
  std::string id = {};     // for links
  std::string title = {};  // of the link; none without
  std::string heading;
  std::vector<Block> blocks = {};
  Shown shown = Shown::everywhere;
  bool folded = false;  // on a page, below its heading
};

struct Document {
  std::string title;     // of the page
  std::string heading;   // what it is about
  std::string subtitle;  // what was done to it
  std::string line;      // the verdict on a screen
  std::string headline;  // and on a page
  Mark verdict = Mark::none;
  std::vector<Block> opening = {};     // what belongs to the verdict
  std::vector<Block> first_look = {};  // of a page, beside it
  std::vector<Section> sections = {};
};

// The text of a cell; "-" for what is not a finite number.
[[nodiscard]] std::string shown(const Column& column, const Cell& cell);

// Whether something shown so is shown there.
[[nodiscard]] constexpr bool is_on(Shown place, Shown where) {
  return where == Shown::everywhere || where == place;
}

// How the documents look. The text is UTF-8; its sentences are at most 100 columns wide.
//
// @param screen  columns of the terminal, in which tables go on below where they are wider; 0: there is none
[[nodiscard]] std::string text_of(const Document& document, std::size_t screen = 0);
[[nodiscard]] std::string html_of(const Document& document);
// The figure that report.js draws a plot in.
[[nodiscard]] std::string markup_of(const Plot& plot);
// What all plots of a document show, by their identifiers, as JSON that may stand in a <script>.
[[nodiscard]] std::string data_of(const Document& document);
// An interval on an axis of its own, as small as a cell of a table.
[[nodiscard]] std::string markup_of(const Interval& interval);

// What to do about a finding; nothing about a note.
[[nodiscard]] std::string_view advice(const Finding& finding);

// A fraction in per cent; "-" where it is not finite.
[[nodiscard]] std::string percent(double fraction);
// A value with as many decimals as its deviation asks for; "-" where it is not finite.
[[nodiscard]] std::string with_decimals_of(double value, double sigma);

}  // namespace rivid::detail
