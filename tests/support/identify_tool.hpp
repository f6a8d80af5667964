#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "support/process.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::test {

using Json = nlohmann::json;

/// Command line of rivid_identify.
inline std::vector<std::string> identify_command(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {RIVID_IDENTIFY};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

/// The member of that name in a list of a result: a parameter, a joint.
inline Json named(const Json& list, std::string_view name) {
  const auto at = std::ranges::find_if(list, [&](const Json& item) { return item.at("name") == name; });
  if (at == list.end()) {
    ADD_FAILURE() << "there is no " << name << " in " << list.dump();
    return {};
  }
  return *at;
}

inline Json parameter(const Json& result, std::string_view name) {
  return named(result.at("parameters"), name);
}

/// The SCARA of data/scara in a folder of its own, to be spoiled, and rivid_identify run there.
class IdentifyTool : public testing::Test {
 protected:
  IdentifyTool() {
    for (const char* const file : {"scara.toml", "scara.urdf", "scara_s2.csv", "scara_validation.csv"}) {
      provide(file);
    }
  }

  /// Copies a file of data/scara into the folder.
  void provide(const std::string& file) const {
    folder_.write(file, content_of(std::filesystem::path(RIVID_DATA) / "scara" / file));
  }

  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

  [[nodiscard]] Outcome identify(const std::vector<std::string>& arguments) const {
    return outcome_of(identify_command(arguments), folder_.path());
  }

  /// Replaces a text that a file holds once.
  void edit(const std::string& file, std::string_view from, std::string_view to) const {
    std::string content = folder_.read(file);
    const std::size_t at = content.find(from);
    ASSERT_NE(at, std::string::npos) << file << " does not hold " << from;
    ASSERT_EQ(content.find(from, at + 1), std::string::npos) << file << " holds more than once: " << from;
    folder_.write(file, content.replace(at, from.size(), to));
  }

  /// Replaces a cell of a comma-separated file; both count from 1, and the header is line 1.
  void set_cell(const std::string& file, std::size_t line, std::size_t column, std::string_view to) const {
    std::string content = folder_.read(file);
    std::size_t at = 0;
    for (std::size_t l = 1; l < line; ++l) {
      at = content.find('\n', at) + 1;
    }
    for (std::size_t c = 1; c < column; ++c) {
      at = content.find(',', at) + 1;
    }
    folder_.write(file, content.replace(at, content.find_first_of(",\n", at) - at, to));
  }

  /// The log cut after so many lines, its header included.
  void keep_lines(const std::string& file, std::size_t lines) const {
    const std::string content = folder_.read(file);
    std::size_t at = 0;
    for (std::size_t l = 0; l < lines; ++l) {
      at = content.find('\n', at) + 1;
    }
    folder_.write(file, content.substr(0, at));
  }

  /// Rewrites each line of a file but the first.
  template <typename Rewrite>
  void rewrite_rows(const std::string& file, const Rewrite& rewrite) const {
    std::istringstream in(folder_.read(file));
    std::string out;
    std::string line;
    for (bool header = true; std::getline(in, line); header = false) {
      out += (header ? line : rewrite(line)) + "\n";
    }
    folder_.write(file, out);
  }

  /// result.json of a run that must succeed.
  [[nodiscard]] Json result_of(const std::vector<std::string>& arguments = {"scara.toml"},
                               int exit_code = 0) const {
    const Outcome run = identify(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(run.signal, 0);
    const std::string name = "scara_result/result.json";
    if (!std::filesystem::exists(folder_.path() / name)) {
      ADD_FAILURE() << "no result: " << run.err;
      return {};
    }
    return Json::parse(folder_.read(name));
  }

  /// Bad input: exit code 2, one line on standard error that holds all words, nothing else printed or
  /// written.
  void expect_refused(const std::vector<std::string_view>& words,
                      const std::vector<std::string>& arguments = {"scara.toml"}) const {
    expect_refused_by("rivid_identify", identify_command(arguments), words);
  }

  /// The same of any tool.
  void expect_refused_by(const std::string& program, const std::vector<std::string>& command,
                         const std::vector<std::string_view>& words) const {
    const std::vector<std::string> before = folder_.entries();
    const Outcome run = outcome_of(command, folder_.path());
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.signal, 0);
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(run.err.starts_with(program + ": error: ")) << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    EXPECT_TRUE(run.err.ends_with('\n')) << run.err;
    for (const std::string_view word : words) {
      EXPECT_NE(run.err.find(word), std::string::npos)
          << "the message is\n  " << run.err << "without\n  " << word;
    }
    EXPECT_EQ(folder_.entries(), before) << "files were left behind";
  }

 private:
  TemporaryFolder folder_;
};

/// Values and deviations of two results agree to a part of the largest value and deviation.
inline void expect_same_parameters(const Json& a, const Json& b, double tolerance) {
  const Json& first = a.at("parameters");
  const Json& second = b.at("parameters");
  ASSERT_EQ(first.size(), second.size());
  for (const char* const member : {"value", "sigma"}) {
    double scale = 0.0;
    for (const Json& p : first) {
      scale = std::max(scale, std::abs(p.at(member).get<double>()));
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].at("name"), second[i].at("name"));
      EXPECT_NEAR(first[i].at(member).get<double>(), second[i].at(member).get<double>(), tolerance * scale)
          << member << " of " << first[i].at("name");
    }
  }
}

}  // namespace rivid::test
