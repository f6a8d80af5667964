// Logs that say little or nothing, to every command and option that reads one: a result or a reason, never a
// signal. RIVID_FAULT_ROUNDS=N takes N of the three parts of all pairs.

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <regex>

#include "rivid/data/table.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::Index;
using rivid::Matrix;
using rivid::test::Outcome;
using rivid::test::outcome_of;

constexpr Index joints = 6;
constexpr std::size_t parts = 3;

std::size_t rounds() {
  const char* const text = std::getenv("RIVID_FAULT_ROUNDS");
  return text == nullptr ? 1 : static_cast<std::size_t>(std::atoi(text));
}

// LOG is the degenerate one, GOOD one of the same arm that determines everything. A line begins with an empty
// folder "to".
constexpr std::array commands = {
    "identify arm.toml --log LOG -o to --method ols --report --write-rows to/r.npz --write-friction to/f.csv",
    "identify arm.toml --log LOG -o to --method wls --report --write-rows to/r.csv --json",
    "identify arm.toml --log LOG -o to --method iv --report --write-rows to/r.npz --write-friction to/f.csv",
    "identify arm.toml --log LOG -o to --method iv --set method.prefilter=true --report",
    "identify arm.toml --log LOG -o to --method didim --report",
    "identify arm.toml --log LOG -o to --method output_error",
    "identify arm.toml --log LOG -o to --method auto --report",
    "identify arm.toml --log LOG -o to --dry-run",
    "identify arm.toml --log LOG -o to --method wls --robust huber --report",
    "identify arm.toml --log LOG -o to --method iv --robust bisquare",
    "identify arm.toml --log LOG -o to --method wls --physical --report",
    "identify arm.toml --log LOG -o to --method wls --set method.essential=true --report",
    "identify arm.toml --log LOG -o to --method wls --set robot.friction=\"auto\"",
    "identify arm.toml --log LOG -o to --method wls --set robot.friction=\"load\" --report",
    "identify arm.toml --log LOG -o to --method wls --set method.gains=\"estimate\"",
    "identify arm.toml --log GOOD -o to --method wls --set method.gains={mass=2,loaded=[\"LOG\"]}",
    "identify arm.toml --log LOG -o to --method wls --set method.gains={mass=2,loaded=[\"GOOD\"]}",
    "identify arm.toml --log LOG -o to --method wls --set signal.decimation=\"auto\" --report",
    "identify arm.toml --log LOG -o to --method wls --set signal.decimation=1",
    "identify arm.toml --log LOG -o to --method wls --set signal.rows=\"paper\" --set signal.cutoff_hz=20",
    "identify arm.toml --log LOG -o to --method wls --set method.covariance=\"hac\"",
    "identify arm.toml --log LOG -o to --method wls --set method.covariance=\"classical\"",
    "identify arm.toml --log GOOD -o to --method wls --validate LOG --report",
    "identify arm.toml --log GOOD LOG -o to --method wls --report",
    "identify arm.toml --log LOG GOOD -o to --method iv --report",
    "identify payload arm.toml --log GOOD --loaded LOG -o to",
    "identify payload arm.toml --log LOG --loaded GOOD -o to",
    "identify payload arm.toml --log LOG --loaded LOG -o to --gains 1",
    "identify payload arm.toml --log GOOD --loaded a=LOG b=GOOD -o to --json",
    "identify payload arm.toml --log GOOD --loaded LOG -o to --mass 2 --gains estimate",
    "identify payload arm.toml --log GOOD --loaded LOG -o to --model point --load-friction",
    "identify payload arm.toml --log GOOD --loaded LOG -o to --model body",
    "identify payload arm.toml --arm arm/result.json --loaded LOG -o to",
    "identify payload arm.toml --arm arm/result.json --loaded LOG -o to --gains 2 --flange 0,0,0.1,0,0,0",
    "identify check arm.toml --set log.files=\"LOG\"",
    "identify check arm.toml --set log.files=[\"LOG\",\"GOOD\"] --json",
    "identify init six_axis.urdf LOG -o to/draft.toml",
    "identify validate arm LOG -o to --report",
    "identify compare arm six_axis.urdf --log LOG -o to --report",
    "identify compare arm six_axis.urdf --log LOG GOOD --json",
    "identify factors arm.toml --log LOG -o to/a.factors + identify merge to/a.factors -o to --report",
    "identify factors arm.toml --log LOG GOOD -o to/b.factors --blocks 3 + identify merge to/b.factors -o to",
    "online LOG --result arm -o to --experiment arm.toml",
    "online LOG --result arm -o to --experiment arm.toml --measured --stride 1 --learn 0.1",
    "simulate simulate.toml -o to --set reference.file=\"LOG\"",
    "montecarlo montecarlo.toml -o to --runs 2 --threads 1 --set reference.file=\"LOG\"",
    "excite forecast excite.toml LOG -o to --report",
};

const std::map<std::string, std::string> tools = {{"identify", RIVID_IDENTIFY},
                                                  {"online", RIVID_ONLINE},
                                                  {"simulate", RIVID_SIMULATE},
                                                  {"montecarlo", RIVID_MONTECARLO},
                                                  {"excite", RIVID_EXCITE}};

class DegenerateLogs : public testing::Test {
 protected:
  DegenerateLogs() {
    provide("six_axis.toml", "arm.toml", "name = \"iv\"", "name = \"wls\"");
    provide("six_axis.urdf", "six_axis.urdf");
    provide("excite.toml", "excite.toml");
    provide("six_axis_reference.csv", "six_axis_reference.csv");
    provide("simulate.toml", "good.toml");
    const char* const fourier = "type = \"fourier\"\nomega_f = 0.6283185307179586";
    provide("simulate.toml", "simulate.toml", fourier, "type = \"logged\"");
    provide("montecarlo.toml", "montecarlo.toml", fourier, "type = \"logged\"");
    expect_done({RIVID_SIMULATE, "good.toml", "-o", "good", "-q"});
    const rivid::Table made = rivid::read_table(folder_.path() / "good/log.csv");
    names_ = made.names;
    good_ = made.values.topRows(2500);
    put("GOOD.csv", good_);
    expect_done({RIVID_IDENTIFY, "arm.toml", "--log", "good/log.csv", "-o", "arm", "-q"});
  }

  void expect_done(const std::vector<std::string>& command) const {
    const Outcome run = outcome_of(command, folder_.path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }

  void provide(const char* from, const char* to, const std::string& old = "",
               const std::string& by = "") const {
    std::string content = rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "six_axis" / from);
    if (!old.empty()) {
      const std::size_t at = content.find(old);
      ASSERT_NE(at, std::string::npos) << from << " does not hold " << old;
      content.replace(at, old.size(), by);
    }
    folder_.write(to, content);
  }

  void put(const std::string& file, const Matrix& rows) const {
    std::ostringstream out;
    for (std::size_t c = 0; c < names_.size(); ++c) {
      out << (c > 0 ? "," : "") << names_[c];
    }
    const Eigen::IOFormat plain(Eigen::FullPrecision, Eigen::DontAlignCols, ",", "\n");
    out << '\n';
    if (rows.rows() > 0) {
      out << rows.format(plain) << '\n';
    }
    folder_.write(file, out.str());
  }

  // Columns: t, q, v, the reference.
  [[nodiscard]] Matrix held(Index first, Index count) const {
    Matrix out = good_;
    for (const Index begin : {Index{1}, 1 + 2 * joints}) {
      out.middleCols(begin + first, count).rowwise() = good_.row(0).segment(begin + first, count);
    }
    return out;
  }

  [[nodiscard]] std::vector<std::string> written_logs() const {
    std::vector<std::pair<std::string, Matrix>> out;
    for (Index j = 0; j < joints; ++j) {
      out.emplace_back("held" + std::to_string(j + 1), held(j, 1));
    }
    out.emplace_back("wrist", held(0, 3));
    out.emplace_back("alone6", held(0, joints - 1));
    out.emplace_back("standing", held(0, joints));
    for (const Index rows : {0, 1, 2, 3, 5, 10, 20, 50, 100, 200, 400, 800}) {
      out.emplace_back("short" + std::to_string(rows), good_.topRows(rows));
    }
    Matrix zero = Matrix::Zero(good_.rows(), good_.cols());
    out.emplace_back("all_zero", zero);
    zero.col(0) = good_.col(0);
    out.emplace_back("zero", zero);
    Matrix equal = good_.col(1).replicate(1, good_.cols());
    equal.col(0) = good_.col(0);
    out.emplace_back("equal", equal);
    out.emplace_back("all_equal", good_.col(0).replicate(1, good_.cols()));
    Matrix without = good_;
    without.middleCols(1 + joints, joints).setZero();
    out.emplace_back("without_torque", without);
    std::vector<std::string> names;
    for (const auto& [name, rows] : out) {
      names.push_back(name + ".csv");
      put(names.back(), rows);
    }
    return names;
  }

  void expect_a_result_or_a_reason(std::string line, const std::string& log) const {
    line = std::regex_replace(line, std::regex("LOG"), log);
    line = std::regex_replace(line, std::regex("GOOD"), "GOOD.csv");
    SCOPED_TRACE("rivid_" + line);
    std::filesystem::remove_all(folder_.path() / "to");
    std::filesystem::create_directory(folder_.path() / "to");
    std::istringstream in(line);
    // A minute of work.
    const std::vector<std::string> timed = {"/bin/sh", "-c", "ulimit -t 60; exec \"$@\"", "sh"};
    std::vector<std::string> command = timed;
    const auto run = [&] {
      const Outcome end = outcome_of(command, folder_.path());
      EXPECT_EQ(end.signal, 0) << end.err;
      EXPECT_TRUE(end.exit_code >= 0 && end.exit_code <= 3) << end.exit_code << end.err;
      EXPECT_TRUE(end.exit_code < 2 || end.err.starts_with("rivid_")) << end.err;
      command = timed;
    };
    for (std::string word; in >> word;) {
      if (word == "+") {
        run();
      } else {
        command.push_back(command.size() > timed.size() ? word : tools.at(word));
      }
    }
    run();
  }

  rivid::test::TemporaryFolder folder_;
  std::vector<std::string> names_;
  Matrix good_;
};

TEST_F(DegenerateLogs, GiveAResultOrAReason) {
  const std::vector<std::string> logs = written_logs();
  const std::size_t taken = std::min(rounds(), parts);
  std::size_t tried = 0;
  for (std::size_t l = 0; l < logs.size(); ++l) {
    for (std::size_t c = 0; c < commands.size(); ++c) {
      // Of each command another log in each part.
      if ((l + c) % parts < taken) {
        expect_a_result_or_a_reason(commands[c], logs[l]);
        ++tried;
      }
    }
  }
  EXPECT_GE(tried, logs.size() * commands.size() * taken / parts - commands.size());
}

}  // namespace
