// Mutated command lines of all tools end in time, by no signal, with one of their exit codes, and an exit
// code 0 goes with finite numbers. RIVID_FAULT_ROUNDS=N makes N times as many.

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <regex>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;

using Command = std::vector<std::string>;

constexpr int lines_of_a_round = 60;
constexpr unsigned seed = 20261122;

int rounds() {
  const char* const text = std::getenv("RIVID_FAULT_ROUNDS");
  return text == nullptr ? 1 : std::atoi(text);
}

std::string joined(const Command& command) {
  std::string out;
  for (const std::string& word : command) {
    out += "'" + word + "' ";
  }
  return out;
}

class CommandLines : public rivid::test::IdentifyTool {
 protected:
  CommandLines() {
    constexpr std::size_t lines = 600;
    keep_lines("scara_s2.csv", lines);
    keep_lines("scara_validation.csv", lines);
    for (const char* const file : {"scara_iv.toml", "simulate_s1.toml", "montecarlo_s1.toml"}) {
      provide(file);
    }
    for (const char* const file : {"six_axis.urdf", "excite.toml"}) {
      folder().write(file, content_of(std::filesystem::path(RIVID_DATA) / "six_axis" / file));
    }
    EXPECT_EQ(identify({"scara.toml", "--physical", "--output", "model"}).exit_code, 0);
    for (const char* const tool :
         {RIVID_IDENTIFY, RIVID_SIMULATE, RIVID_MONTECARLO, RIVID_EXCITE, RIVID_ONLINE}) {
      const std::string help = outcome_of({tool, "--help"}, folder().path()).out;
      static const std::regex option("--[a-z][a-z-]+");
      for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at) {
        options_.push_back(at->str());
      }
    }
  }

  [[nodiscard]] Command mutated() {
    Command out = any(bases_);
    const int mutations = number(1, 4);
    for (int m = 0; m < mutations; ++m) {
      const auto at = [&] { return out.begin() + number(1, static_cast<int>(out.size()) - 1); };
      switch (number(0, 6)) {
        case 0:
          if (out.size() > 2) {
            out.erase(at());
          }
          break;
        case 1: {
          const std::string word = *at();
          out.insert(at(), word);
          break;
        }
        case 2:
          std::iter_swap(at(), at());
          break;
        case 3:
          *at() = any(values_);
          break;
        case 4:
          out.push_back(any(options_));
          out.push_back(any(values_));
          break;
        case 5:
          out.emplace_back("--set");
          out.push_back(any(keys_) + "=" + any(values_));
          break;
        default: {
          std::string& word = *at();
          if (!word.empty()) {
            word[static_cast<std::size_t>(number(0, static_cast<int>(word.size()) - 1))] =
                static_cast<char>(number(1, 255));
          }
        }
      }
    }
    return out;
  }

  // "/" would lead out of the folder of the test.
  [[nodiscard]] static bool stays(const Command& command) {
    return std::all_of(command.begin() + 1, command.end(), [](const std::string& word) {
      return word.find("..") == std::string::npos && (!word.starts_with('/') || word.starts_with("/dev/"));
    });
  }

  void expect_ends_well(const Command& command) const {
    // What hangs is ended, after minutes: the machine may be slow, or others may use it too.
    Command timed = {"/bin/sh", "-c", "ulimit -t 120; exec timeout -s KILL 600 \"$@\"", "sh"};
    timed.insert(timed.end(), command.begin(), command.end());
    const Outcome run = outcome_of(timed, folder().path());
    const std::string what = joined(command) + "\n" + run.err;
    ASSERT_EQ(run.signal, 0) << what;
    ASSERT_GE(run.exit_code, 0) << what;
    ASSERT_LE(run.exit_code, 3) << what;
    if (run.exit_code > 1) {
      ASSERT_NE(run.err, "") << what;
    }
    static const std::regex not_finite("(^|[ =:(])[-+]?(nan|inf)([ ,;)]|$)", std::regex::multiline);
    if (run.exit_code == 0) {
      ASSERT_FALSE(std::regex_search(run.out, not_finite)) << what << run.out;
    }
  }

  int number(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
  template <typename T>
  const T& any(const std::vector<T>& of) {
    return of[static_cast<std::size_t>(number(0, static_cast<int>(of.size()) - 1))];
  }

  std::mt19937_64 random_{seed};
  std::vector<std::string> options_;
  const std::vector<Command> bases_ = {
      {RIVID_IDENTIFY, "scara.toml"},
      {RIVID_IDENTIFY, "scara.toml", "--physical", "--report", "--output", "out"},
      {RIVID_IDENTIFY, "scara_iv.toml", "--json"},
      {RIVID_IDENTIFY, "scara.toml", "--log", "scara_s2.csv", "--validate", "scara_validation.csv"},
      {RIVID_IDENTIFY, "scara.toml", "--robust", "huber", "--write-rows", "rows.csv"},
      {RIVID_IDENTIFY, "check", "scara.toml", "--json"},
      {RIVID_IDENTIFY, "init", "scara.urdf", "scara_s2.csv", "--print"},
      {RIVID_IDENTIFY, "payload", "scara.toml", "--loaded", "scara_validation.csv", "--gains", "1"},
      {RIVID_IDENTIFY, "validate", "model", "scara_validation.csv"},
      {RIVID_IDENTIFY, "compare", "model", "--log", "scara_validation.csv", "--json"},
      {RIVID_IDENTIFY, "export", "model", "--to", "mjcf", "--output", "model.xml"},
      {RIVID_IDENTIFY, "export", "model", "--to", "urdf", "--diff"},
      {RIVID_IDENTIFY, "explain", "not_converged"},
      {RIVID_SIMULATE, "simulate_s1.toml", "--set", "reference.durations=0.2", "--json"},
      {RIVID_MONTECARLO, "montecarlo_s1.toml", "--runs", "1", "--set", "reference.durations=0.2", "--output",
       "mc"},
      {RIVID_EXCITE, "excite.toml", "--starts", "1", "--set", "excitation.evaluations=2", "--set",
       "excitation.duration=2", "--set", "excitation.rate_hz=100", "--output", "plan"},
      {RIVID_ONLINE, "scara_s2.csv", "--result", "model/result.json", "--gains", "1", "--output", "online"}};
  const std::vector<std::string> values_ = {"",
                                            "0",
                                            "-1",
                                            "1e308",
                                            "1e-308",
                                            "nan",
                                            "inf",
                                            "-inf",
                                            "1e18",
                                            "4294967296",
                                            "0x10",
                                            "1,5",
                                            "\"x\"",
                                            "[]",
                                            "[1, 2]",
                                            "[nan, 1]",
                                            "true",
                                            "off",
                                            "auto",
                                            "{a = 1}",
                                            "-",
                                            "--",
                                            "/dev/null",
                                            "/dev/zero",
                                            "none",
                                            "scara.urdf",
                                            "model",
                                            "scara_s2.csv",
                                            "model/result.json",
                                            "%s%n",
                                            "\x1B[31m",
                                            "\xFF\xFE",
                                            "a\nb",
                                            "*",
                                            "0.5",
                                            "2",
                                            std::string(5000, 'a'),
                                            "1e-9",
                                            "1000000",
                                            "q1"};
  const std::vector<std::string> keys_ = {"signal.decimation",
                                          "signal.cutoff_hz",
                                          "signal.order",
                                          "signal.trim",
                                          "signal.rows",
                                          "signal.torque_held",
                                          "method.name",
                                          "method.physical",
                                          "method.robust",
                                          "method.max_iterations",
                                          "method.tolerance",
                                          "method.covariance",
                                          "log.rate_hz",
                                          "log.torque_lag",
                                          "log.position",
                                          "log.time",
                                          "robot.gravity",
                                          "robot.friction",
                                          "robot.base_tolerance",
                                          "control.rate_hz",
                                          "control.omega_n",
                                          "control.zeta",
                                          "control.law",
                                          "reference.durations",
                                          "reference.via",
                                          "reference.type",
                                          "simulation.seed",
                                          "simulation.position_noise",
                                          "simulation.rtol",
                                          "simulation.max_steps",
                                          "simulation.max_seconds",
                                          "simulation.integrator",
                                          "excitation.duration",
                                          "excitation.rate_hz",
                                          "excitation.noise",
                                          "excitation.harmonics",
                                          "montecarlo.runs",
                                          "montecarlo.seed",
                                          "validation.files",
                                          "method.prefilter"};
};

TEST_F(CommandLines, EndInTimeWithAnAnswerOrARefusal) {
  for (int k = 0; k < lines_of_a_round * rounds();) {
    const Command command = mutated();
    if (!stays(command)) {
      continue;
    }
    ++k;
    expect_ends_well(command);
    if (HasFatalFailure()) {
      FAIL() << "command line " << k << " of seed " << seed;
    }
  }
}

}  // namespace
