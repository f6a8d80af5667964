#include "rivid/data/table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;
using test::TemporaryFile;

Table read(std::string_view content, const TableOptions& options = {}) {
  const TemporaryFile file(content);
  return read_table(file.path(), options);
}

std::string refusal(std::string_view content, const TableOptions& options = {}) {
  const TemporaryFile file(content);
  return complaint_of([&] { static_cast<void>(read_table(file.path(), options)); });
}

Matrix matrix(std::initializer_list<std::initializer_list<double>> rows) { return Eigen::MatrixXd(rows); }

TEST(ReadTable, ReadsNamesAndValues) {
  const Table table = read("t,q1\n0,1.5\n0.1,-2.5e1\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"t", "q1"}));
  EXPECT_EQ(table.values, matrix({{0, 1.5}, {0.1, -25}}));
  EXPECT_EQ(table.fields, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(table.column("q1"), 1);
  EXPECT_TRUE(table.source.ends_with("run1.csv"));
}

TEST(ReadTable, FindsTheSeparator) {
  const Matrix values = matrix({{0, 1.5, 2}, {1, 2.5, 3}});
  EXPECT_EQ(read("a,b,c\n0,1.5,2\n1,2.5,3\n").values, values);
  EXPECT_EQ(read("a;b;c\n0;1.5;2\n1;2.5;3\n").values, values);
  EXPECT_EQ(read("a\tb\tc\n0\t1.5\t2\n1\t2.5\t3\n").values, values);
  EXPECT_EQ(read("a b  c\n  0  1.5 2\n 1\t 2.5   3  \n").values, values);
  EXPECT_EQ(read("a, b, c\n0, 1.5, 2\n1 ,2.5 , 3\n").values, values);
  EXPECT_EQ(read("a\n1\n2\n").values, matrix({{1}, {2}}));
}

TEST(ReadTable, TakesTheSeparatorThatIsAskedFor) {
  EXPECT_EQ(read("1,5\n2,7\n").values, matrix({{1, 5}, {2, 7}}));
  EXPECT_EQ(read("1,5\n2,7\n", {.separator = Separator::semicolon}).values, matrix({{1.5}, {2.7}}));
  EXPECT_EQ(read("1 5\n2 7\n", {.separator = Separator::spaces}).values, matrix({{1, 5}, {2, 7}}));
  EXPECT_EQ(read("1\t5\n2\t7\n", {.separator = Separator::tab}).values, matrix({{1, 5}, {2, 7}}));
}

TEST(ReadTable, ReadsADecimalCommaWhereTheSeparatorIsNone) {
  const Matrix values = matrix({{0, 0.5}, {1.25, -2e-3}});
  EXPECT_EQ(read("a;b\n0;0,5\n1,25;-2,0e-3\n").values, values);
  EXPECT_EQ(read("a\tb\n0\t0,5\n1,25\t-2,0e-3\n").values, values);
  EXPECT_EQ(read("a b\n0 0,5\n1,25 -2,0e-3\n").values, values);
  EXPECT_EQ(read("a;b\n0;0,5\n1,25;-2,0e-3\n", {.decimal = Decimal::comma}).values, values);
}

TEST(ReadTable, ReadsADecimalCommaThatShowsOnlyLate) {
  std::string content = "a;b\n";
  for (int k = 0; k < 100; ++k) {
    content += "0;1\n";
  }
  const Table table = read(content + "0;1,5\n");
  EXPECT_EQ(table.rows(), 101);
  EXPECT_EQ(table.values(100, 1), 1.5);
}

TEST(ReadTable, ReadsALongFractionBehindADecimalComma) {
  const Table table = read("a;b\n0,12345678901234567890123;3,141592653589793\n");
  EXPECT_EQ(table.values, matrix({{0.12345678901234567890123, 3.141592653589793}}));
}

TEST(ReadTable, RefusesTwoDecimalMarksInOneFile) {
  EXPECT_TRUE(says(refusal("a;b\n1.5;2\n1;2,5\n"),
                   "run1.csv:2:1: column \"a\" holds \"1.5\", but the decimal mark is a comma in line 3"));
  EXPECT_TRUE(says(refusal("a;b\n1,5;2\n", {.decimal = Decimal::point}), "the decimal mark must be a point"));
  EXPECT_TRUE(says(refusal("a,b\n1,5\n", {.separator = Separator::comma, .decimal = Decimal::comma}),
                   "the separator and the decimal mark are both a comma"));
}

TEST(ReadTable, FindsWhetherThereIsAHeader) {
  const Table bare = read("0,1\n2,3\n");
  EXPECT_EQ(bare.values, matrix({{0, 1}, {2, 3}}));
  EXPECT_EQ(bare.names, (std::vector<std::string>{"#1", "#2"}));
  EXPECT_EQ(read("1,2\n3,4\n", {.header = Header::present}).names, (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(read("0,x\n1,y\n", {.columns = {"#1"}}).values, matrix({{0}, {1}}));
}

// numpy.savetxt(header=…) and rostopic echo -p.
TEST(ReadTable, TakesNamesFromTheCommentAboveTheFirstRow) {
  const auto names = [](const std::string& text, const TableOptions& options = {}) {
    const TemporaryFile file(text);
    return read_table(file.path(), options).names;
  };
  const std::vector<std::string> numbers = {"#1", "#2"};
  EXPECT_EQ(names("# t q1\n0 1\n1 2\n"), (std::vector<std::string>{"t", "q1"}));
  EXPECT_EQ(names("# made by hand\n%time,field.q\r\n0,1\r\n1,2\r\n"),
            (std::vector<std::string>{"time", "field.q"}));
  EXPECT_EQ(names("#t;q1;\n0;1;\n1;2;\n"), (std::vector<std::string>{"t", "q1"}));
  EXPECT_EQ(names("# t q1 q2\n0 1\n1 2\n"), numbers);
  EXPECT_EQ(names("# 0 1\n0 1\n1 2\n"), numbers) << "a row that was commented out";
  EXPECT_EQ(names("# t q1\n\n0 1\n1 2\n"), numbers) << "not right above";
  EXPECT_EQ(names("# t q1\n0 1\n1 2\n", {.header = Header::absent}), numbers);
  EXPECT_EQ(names("# x y\nt q1\n0 1\n"), (std::vector<std::string>{"t", "q1"}));
  EXPECT_EQ(names("# t q1\n0 1\n1 2\n", {.columns = {"#2"}}), std::vector<std::string>{"q1"});
}

TEST(ReadTable, DoesNotGuessWhetherAMixedLineIsAHeader) {
  EXPECT_TRUE(
      says(refusal("1,abc,3\n1,2,3\n"), "run1.csv:1:2: holds \"abc\" among numbers; if this line names"));
  EXPECT_EQ(read("1,abc\n1,2\n", {.header = Header::present}).rows(), 1);
  EXPECT_TRUE(says(refusal("1,abc\n1,2\n", {.header = Header::absent}),
                   "run1.csv:1:2: column #2 holds \"abc\", which is not a number"));
}

TEST(ReadTable, PassesOverByteOrderMarkCommentsAndBlankLines) {
  const Table table = read("\xEF\xBB\xBF# made by x\n\na,b\n% note\n1,2\n\n  # more\n3,4\n5,6\n   \n7,8\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table.values, matrix({{1, 2}, {3, 4}, {5, 6}, {7, 8}}));
  EXPECT_EQ(table.lines[0], 5U);
  EXPECT_EQ(table.lines[1], 8U);
  EXPECT_EQ(table.lines[2], 9U);
  EXPECT_EQ(table.lines[3], 11U);
  EXPECT_EQ(read("\xEF\xBB\xBF"
                 "1,2\n")
                .values,
            matrix({{1, 2}}));
}

TEST(ReadTable, CountsCommentsInTheLineOfAnError) {
  EXPECT_TRUE(says(refusal("# one\n\na,b\n1,2\n# five\n\n3,nan\n"), "run1.csv:7:2: column \"b\""));
}

TEST(ReadTable, ReadsCarriageReturnsAndALastLineWithoutItsEnd) {
  const Matrix values = matrix({{1, 2}, {3, 4}});
  EXPECT_EQ(read("a,b\r\n1,2\r\n3,4\r\n").values, values);
  EXPECT_EQ(read("a,b\r\n1,2\r\n3,4").values, values);
  EXPECT_EQ(read("a,b\n1,2\n3,4").values, values);
  EXPECT_EQ(read("a b\r\n1 2\r\n3 4 \r\n").values, values);
  EXPECT_EQ(read("1").values, matrix({{1}}));
  EXPECT_EQ(read("a,b\r\n\r\n1,2\r\n").names.back(), "b");
}

TEST(ReadTable, ReadsQuotedCells) {
  const Table table = read("\"t [s]\",\"q, first\"\n\"1.5\",2\n3,\"4\"\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"t [s]", "q, first"}));
  EXPECT_EQ(table.values, matrix({{1.5, 2}, {3, 4}}));
}

TEST(ReadTable, AcceptsASeparatorAtTheEndOfEveryRow) {
  const Matrix values = matrix({{1, 2}, {3, 4}});
  EXPECT_EQ(read("a,b,\n1,2,\n3,4,\n").values, values);
  EXPECT_EQ(read("a,b\n1,2,\n3,4,\r\n").values, values);
  EXPECT_EQ(read("a,b,\n1,2\n3,4\n").values, values);
  EXPECT_EQ(read("1;2;\n3;4;\n").values, values);
}

TEST(ReadTable, RefusesASeparatorAtTheEndOfSomeRows) {
  EXPECT_TRUE(says(refusal("a,b\n1,2,\n3,4\n"),
                   "run1.csv:3: the line has 2 fields, 2 are required and, as in the rows "
                   "before, a separator at its end"));
  EXPECT_TRUE(says(refusal("a,b\n1,2\n3,4,\n"), "run1.csv:3: the line has 3 fields, 2 are required"));
}

TEST(ReadTable, ParsesOnlyTheColumnsAskedFor) {
  const std::string content = "t,state,q1,note\n0,idle,1,\"a, b\"\n1,,2,\n2,\"x\"\"y\",3,nan\n";
  const Table table = read(content, {.columns = {"q1", "t"}});
  EXPECT_EQ(table.values, matrix({{1, 0}, {2, 1}, {3, 2}}));
  EXPECT_EQ(table.names, (std::vector<std::string>{"q1", "t"}));
  EXPECT_EQ(table.fields, (std::vector<std::size_t>{3, 1}));
  EXPECT_EQ(read(content, {.columns = {"#3", "t", "q1"}}).values, matrix({{1, 0, 1}, {2, 1, 2}, {3, 2, 3}}));
  EXPECT_EQ(read("idle 1\nrun 2\n# x\n", {.columns = {"#2"}}).values, matrix({{1}, {2}}));
  EXPECT_EQ(read("a,b\nx,1\n#c,d\ny,2\n", {.columns = {"b"}}).values, matrix({{1}, {2}}));
}

// Megabytes, which all processors read: rows "k k/8 -k", k from 0.
struct LargeFile {
  static constexpr Index rows = 200'000;

  // What stands in place of a row, or before it.
  std::map<Index, std::string> instead;
  std::map<Index, std::string> before;
  std::string end = "\n";

  [[nodiscard]] std::string content() const {
    std::string out = "a;b;c" + end;
    for (Index k = 0; k < rows; ++k) {
      if (const auto found = before.find(k); found != before.end()) {
        out += found->second;
      }
      const auto found = instead.find(k);
      char row[80];
      std::snprintf(row, sizeof row, "%ld;%.3f;%ld", static_cast<long>(k), static_cast<double>(k) / 8.0,
                    -static_cast<long>(k));
      out += (found != instead.end() ? found->second : row) + end;
    }
    return out;
  }

  // Whether a table holds the rows without those that hold something else.
  static void expect_in(const Table& table) {
    ASSERT_EQ(table.rows(), rows);
    const Vector k = Vector::LinSpaced(rows, 0.0, static_cast<double>(rows - 1));
    EXPECT_EQ(table.values.col(0), k);
    EXPECT_EQ(table.values.col(1), k / 8.0);
    EXPECT_EQ(table.values.col(2), -k);
  }
};

TEST(ReadTable, ReadsLargeFiles) {
  LargeFile file;
  ASSERT_GT(file.content().size(), std::size_t{3} << 20U);
  const Table plain = read(file.content());
  LargeFile::expect_in(plain);
  EXPECT_EQ(plain.lines.runs.size(), 1U);
  EXPECT_EQ(plain.lines[LargeFile::rows - 1], static_cast<std::size_t>(LargeFile::rows) + 1);
  file.end = "\r\n";
  LargeFile::expect_in(read(file.content()));
  std::string without_end = file.content();
  without_end.resize(without_end.size() - 2);
  LargeFile::expect_in(read(without_end));
}

TEST(ReadTable, CountsTheLinesOfLargeFilesWithComments) {
  LargeFile file;
  for (Index k = 3; k < LargeFile::rows; k += 1 + k / 3) {
    file.before[k] = k % 2 == 0 ? "# a comment\n\n" : "\n";
  }
  file.before[LargeFile::rows - 1] = "# near the end\n";
  const Table table = read(file.content() + "# at the end\n\n");
  LargeFile::expect_in(table);
  std::size_t line = 2;
  for (Index k = 0; k < LargeFile::rows; ++k, ++line) {
    if (const auto found = file.before.find(k); found != file.before.end()) {
      line += static_cast<std::size_t>(std::ranges::count(found->second, '\n'));
    }
    ASSERT_EQ(table.lines[k], line) << k;
  }
  EXPECT_EQ(table.lines.runs.size(), file.before.size() + 1);
}

// Wherever it lies, and whatever is wrong with lines behind it.
TEST(ReadTable, NamesTheFirstBadLineOfALargeFile) {
  for (const Index k : {5L, 61'007L, 130'003L, LargeFile::rows - 1}) {
    LargeFile file;
    file.instead[k] = "1;x y;2";
    for (Index later = k + 1; later < LargeFile::rows; later += 20'011) {
      file.instead[later] = later % 2 == 0 ? "1;2" : "1;nan;2";
    }
    EXPECT_TRUE(says(refusal(file.content()), "run1.csv:" + std::to_string(k + 2) +
                                                  ":2: column \"b\" holds \"x y\", which is not a number"));
  }
}

TEST(ReadTable, FindsADecimalCommaLateInALargeFile) {
  LargeFile file;
  file.instead[150'000] = "150000;18750,0;-150000";
  EXPECT_TRUE(says(refusal(file.content()),
                   "run1.csv:2:2: column \"b\" holds \"0.000\", but the decimal mark "
                   "is a comma in line 150002; one file must use one mark"));
  file.instead[90'000] = "x;1;2";
  EXPECT_TRUE(says(refusal(file.content()), "run1.csv:90002:1: column \"a\" holds \"x\""));
  std::string commas = LargeFile().content();
  std::ranges::replace(commas, '.', ',');
  LargeFile::expect_in(read(commas));
}

TEST(ReadTable, CountsTheDatesOfALargeFileFromItsFirstDay) {
  const auto dated = [](Index first) {
    std::string content = "t,q\n";
    for (Index k = 0; k < LargeFile::rows; ++k) {
      const Index day = 1 + k / 80'000;
      content += k < first
                     ? std::to_string(k)
                     : "2024-05-0" + std::to_string(day) + "T00:00:" + std::to_string(10 + k % 50) + "Z";
      content += "," + std::to_string(k) + "\n";
    }
    return content;
  };
  for (const Index first : {0L, 100'000L}) {
    const Table table = read(dated(first));
    ASSERT_EQ(table.rows(), LargeFile::rows);
    for (Index k = 0; k < LargeFile::rows; ++k) {
      const Index day = k / 80'000 - first / 80'000;
      ASSERT_EQ(table.values(k, 0), static_cast<double>(k < first ? k : 86400 * day + 10 + k % 50)) << k;
    }
    EXPECT_EQ(table.values.col(1), Vector::LinSpaced(LargeFile::rows, 0.0, LargeFile::rows - 1.0));
  }
}

TEST(ReadTable, ReadsALargeFileOfBlankLines) {
  const Table table = read("a,b\n1,2\n" + std::string(5'000'000, '\n') + "3,4\n");
  EXPECT_EQ(table.values, matrix({{1, 2}, {3, 4}}));
  EXPECT_EQ(table.lines[1], 5'000'003U);
}

TEST(ReadTable, TellsAMissingColumnWithTheNamesThereAre) {
  const std::string message = refusal("t,q1,q2\n0,1,2\n", {.columns = {"Q_1"}});
  EXPECT_TRUE(says(message, "there is no column \"Q_1\"; the columns are t, q1, q2; did you mean \"q1\"?"));
  EXPECT_TRUE(says(refusal("0,1\n1,2\n", {.columns = {"q1"}}),
                   "no line names the columns; ask for them by number, #1 to #2"));
  EXPECT_TRUE(
      says(refusal("t,q1\n1,2\n", {.columns = {"#3"}}), "there is no column #3; the lines have 2 fields"));
  EXPECT_FALSE(says(refusal("t,q1\n1,2\n", {.columns = {"velocity"}}), "did you mean"));
  EXPECT_TRUE(says(refusal("t\n1\n", {.columns = {""}}), "columns holds an empty name"));
}

TEST(ReadTable, RefusesANameThatStandsTwiceWhereItIsAskedFor) {
  const std::string content = "t,q1,q1\n0,1,2\n";
  EXPECT_TRUE(says(refusal(content, {.columns = {"q1"}}),
                   "the column name \"q1\" stands more than once; ask for #2 or #3"));
  EXPECT_EQ(read(content, {.columns = {"#3", "t"}}).values, matrix({{2, 0}}));
  const Table all = read(content);
  EXPECT_EQ(all.columns(), 3);
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(all.column("q1")); }), "stands more than once"));
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(all.column("q2")); }), "there is no column \"q2\""));
}

TEST(ReadTable, RefusesWhatIsNotFinite) {
  EXPECT_TRUE(says(refusal("t,q1,q2\n0,1,2\n1,2,nan\n"),
                   "run1.csv:3:3: column \"q2\" holds \"nan\"; values must be finite"));
  EXPECT_TRUE(
      says(refusal("t,q1\n0,-inf\n"), "run1.csv:2:2: column \"q1\" holds \"-inf\"; values must be finite"));
  EXPECT_TRUE(says(refusal("t,q1\n0,Infinity\n"), "values must be finite"));
  EXPECT_TRUE(says(refusal("nan,1\n0,1\n"), "run1.csv:1:1: column #1 holds \"nan\"; values must be finite"));
  EXPECT_TRUE(says(refusal("t,q1\n0,1e999\n"), "holds \"1e999\", which is outside the range of a double"));
}

TEST(ReadTable, RefusesTextAndEmptyCells) {
  EXPECT_TRUE(says(refusal("t,q1\n0,1\n1,abc\n"),
                   "run1.csv:3:2: column \"q1\" holds \"abc\", which is not a number"));
  EXPECT_TRUE(
      says(refusal("t,q1,q2\n0,1,2\n1,,2\n"), "run1.csv:3:2: column \"q1\" is empty; a number is required"));
  for (const char* word :
       {"1.5x", "--1", "+-1", "1e", "1e+", ".", "-", "0x10", "1.2.3", "1 2", "1_000", "\"1"}) {
    EXPECT_TRUE(
        says(refusal(std::string("t,q1\n0,1\n1,") + word + "\n"), "run1.csv:3:2: column \"q1\" holds"))
        << word;
  }
}

TEST(ReadTable, RefusesTooFewAndTooManyFields) {
  EXPECT_TRUE(says(refusal("a,b,c\n1,2,3\n1,2\n"), "run1.csv:3: the line has 2 fields, 3 are required"));
  EXPECT_TRUE(says(refusal("a,b,c\n1,2,3\n1,2,3,4\n"), "run1.csv:3: the line has 4 fields, 3 are required"));
  EXPECT_TRUE(says(refusal("a,b,c\n1,2,3,4\n"), "run1.csv:2: the line has 4 fields, 3 are required"));
  EXPECT_TRUE(says(refusal("1 2 3\n1 2\n"), "run1.csv:2: the line has 2 fields, 3 are required"));
  EXPECT_TRUE(says(refusal("1 2 3\n1 2 \n", {.columns = {"#1"}}),
                   "run1.csv:2: the line has 2 fields, 3 are required"));
  EXPECT_TRUE(says(refusal("a,b,c\n1,2,3\n1,2", {.columns = {"a"}}), "run1.csv:3: the line has 2 fields"));
  EXPECT_TRUE(says(refusal("a\n1\n1,2\n", {.separator = Separator::comma}), "has 2 fields, 1 is required"));
}

TEST(ReadTable, RefusesFilesWithoutData) {
  EXPECT_TRUE(says(refusal(""), "run1.csv: the file is empty"));
  EXPECT_TRUE(says(refusal("\n# x\n\n"), "run1.csv: the file holds no data, only comments and blank lines"));
  EXPECT_TRUE(says(refusal("t,q1\n"), "run1.csv: the file holds a header but no data"));
  EXPECT_TRUE(says(refusal("t,q1\n\n# x\n"), "the file holds a header but no data"));
  EXPECT_TRUE(says(refusal("1,2\n", {.header = Header::present}), "the file holds a header but no data"));
}

TEST(ReadTable, RefusesWhatIsNoTextFile) {
  const TemporaryFile file("a\n1\n");
  const auto message = [](const std::filesystem::path& path) {
    return complaint_of([&] { static_cast<void>(read_table(path)); });
  };
  EXPECT_TRUE(says(message(file.folder() / "absent.csv"), "absent.csv: there is no such file"));
  EXPECT_TRUE(says(message(file.folder()), "is a directory, a file is required"));
  EXPECT_TRUE(says(refusal("\xFF\xFEt"), "is UTF-16 text; save it as UTF-8"));
  EXPECT_TRUE(says(refusal("\x1F\x8B..."), "is compressed by gzip; unpack it first"));
}

TEST(ReadTable, QuotesNoMoreThanFortyCharacters) {
  const std::string message = refusal("a,b\n1," + std::string(5000, 'x') + "\n");
  EXPECT_TRUE(says(message, "\"" + std::string(40, 'x') + "…\""));
  EXPECT_LT(message.size(), 300U);
  EXPECT_TRUE(says(refusal(std::string("a,b\n1,\x01\x02z\n")), "holds \"??z\""));
}

TEST(ReadTable, ReadsBackWhatWasPrinted) {
  constexpr std::uint64_t seed = 20260731;
  std::mt19937_64 generator(seed);
  const auto finite = [&] {
    while (true) {
      const auto value = std::bit_cast<double>(generator());
      if (std::isfinite(value)) {
        return value;
      }
    }
  };
  std::uniform_real_distribution<double> plain(-10.0, 10.0);
  std::uniform_real_distribution<double> exponent(-25.0, 25.0);
  constexpr int rows = 20000;
  constexpr int columns = 6;
  for (const char mark : {'.', ','}) {
    Matrix values(rows, columns);
    std::string content = "a;b;c;d;e;f\n";
    for (int k = 0; k < rows; ++k) {
      values.row(k) << finite(), plain(generator), std::pow(10.0, exponent(generator)), k * 1e-3,
          std::floor(1e4 * plain(generator)) / 1e4, static_cast<double>(generator() >> 1U);
      for (int c = 0; c < columns; ++c) {
        char cell[64];
        const int length = std::snprintf(cell, sizeof cell, "%.17g", values(k, c));
        std::replace(cell, cell + length, '.', mark);
        content.append(cell, static_cast<std::size_t>(length));
        content += c + 1 < columns ? ';' : '\n';
      }
    }
    const Table table = read(content);
    ASSERT_EQ(table.rows(), rows) << "seed " << seed;
    for (int k = 0; k < rows; ++k) {
      for (int c = 0; c < columns; ++c) {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(table.values(k, c)),
                  std::bit_cast<std::uint64_t>(values(k, c)))
            << "seed " << seed << ", row " << k << ", column " << c;
      }
    }
  }
}

TEST(ReadTable, RoundsEveryDecimalLikeTheStandardLibrary) {
  constexpr std::uint64_t seed = 7;
  std::mt19937_64 generator(seed);
  std::string content;
  std::vector<double> expected;
  for (int k = 0; k < 100000; ++k) {
    // Up to 21 digits with the point anywhere: halfway cases, carries and the border to the long way round.
    std::string cell = std::to_string(generator() >> (generator() % 64U));
    if (k % 4 == 0) {
      cell = std::to_string((std::uint64_t{1} << 53U) + (generator() % 4096U));
    }
    if (k % 7 == 0) {
      cell.push_back('5');
    }
    cell.insert(generator() % (cell.size() + 1), 1, '.');
    if (k % 3 == 0) {
      cell += 'e';
      cell += std::to_string(static_cast<int>(generator() % 60U) - 30);
    }
    expected.push_back(std::strtod(cell.c_str(), nullptr));
    content += cell + "\n";
  }
  const Table table = read(content, {.header = Header::absent});
  ASSERT_EQ(table.rows(), static_cast<Index>(expected.size()));
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_EQ(table.values(static_cast<Index>(k), 0), expected[k]) << "seed " << seed << ", row " << k;
  }
}

TEST(ReadTable, ReadsEveryLengthOfFileAlike) {
  for (int rows = 1; rows < 40; ++rows) {
    std::string content = "a,b\n";
    for (int k = 0; k < rows; ++k) {
      content += std::to_string(k) + "," + std::to_string(2 * k) + "\n";
    }
    for (const bool ended : {true, false}) {
      const Table table = read(ended ? content : content.substr(0, content.size() - 1));
      ASSERT_EQ(table.rows(), rows);
      for (int k = 0; k < rows; ++k) {
        ASSERT_EQ(table.values(k, 0), k);
        ASSERT_EQ(table.values(k, 1), 2 * k);
        ASSERT_EQ(table.lines[k], static_cast<std::size_t>(k) + 2);
      }
    }
  }
}

TEST(ReadTable, TellsItsProgress) {
  std::string content = "a,b\n";
  while (content.size() < (std::size_t{20} << 20U)) {
    content += "1.25,-3.75\n";
  }
  std::vector<double> fractions;
  static_cast<void>(read(content, {.progress = [&](double done) { fractions.push_back(done); }}));
  // How far the others are when the calling thread reports is not known.
  ASSERT_GE(fractions.size(), 2U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_GT(fractions.front(), 0.3);
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(ColumnNames, AreThoseOfTheHeaderOrNumbers) {
  const TemporaryFile named("t;q1;state\n0;1;idle\n");
  EXPECT_EQ(column_names(named.path()), (std::vector<std::string>{"t", "q1", "state"}));
  const TemporaryFile bare("0 1 2\n");
  EXPECT_EQ(column_names(bare.path()), (std::vector<std::string>{"#1", "#2", "#3"}));
}

}  // namespace
}  // namespace rivid
