#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "support/process.hpp"
#include "support/temporary_folder.hpp"

// Compilers that generated headers are tried with.
namespace rivid::test {

struct Compiler {
  std::string name;
  std::vector<std::string> command;

  /// What main.c of the folder prints, compiled there.
  [[nodiscard]] std::string printed(const TemporaryFolder& folder) const {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"main.c", "-o", "main", "-lm"});
    const Outcome compiled = outcome_of(arguments, folder.path());
    EXPECT_EQ(compiled.exit_code, 0) << compiled.err;
    const Outcome run = outcome_of({(folder.path() / "main").string()}, folder.path());
    EXPECT_EQ(run.exit_code, 0);
    return run.out;
  }
};

inline std::vector<Compiler> compilers() {
  const std::vector<std::string> strict = {"-Wall", "-Wextra", "-Werror", "-pedantic", "-O1"};
  std::vector<Compiler> out;
  const auto add = [&](const std::string& name, std::vector<std::string> command) {
    command.insert(command.end(), strict.begin(), strict.end());
    out.push_back({name, std::move(command)});
  };
  const std::string c = RIVID_C_COMPILER;
  if (!c.empty()) {
    add("C99", {c, "-std=c99", "-x", "c"});
  }
  for (const char* const standard : {"-std=c++98", "-std=c++20"}) {
    add(standard, {RIVID_CXX_COMPILER, standard, "-x", "c++"});
  }
  return out;
}

}  // namespace rivid::test
