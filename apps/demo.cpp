#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "demo_files.hpp"
#include "programs.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

// A command of the demo, printed as the user would type it.
int step(int (*tool)(int, char**), const std::string& word, std::vector<std::string> arguments) {
  std::string line = "\n$ rivid " + word;
  arguments.insert(arguments.begin(), word);
  std::vector<char*> argv;
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
    line += argv.size() > 1 ? " " + argument : "";
  }
  tell(line + "\n");
  return tool(static_cast<int>(argv.size()), argv.data());
}

int demo(const std::filesystem::path& folder) {
  const auto in = [&](const char* name) { return (folder / name).string(); };
  const std::vector<std::pair<std::string, std::string_view>> contents = {
      {in("six_axis.urdf"), detail::six_axis_urdf()},
      {in("six_axis.toml"), detail::six_axis_toml()},
      {in("simulate.toml"), detail::simulate_toml()},
      {in("six_axis_reference.csv"), detail::reference_csv()}};
  std::vector<PlannedFile> files;
  for (const auto& [name, content] : contents) {
    files.push_back({name, std::filesystem::path(name).extension().string()});
  }
  Outputs outputs = planned({}, files);
  for (const auto& [name, content] : contents) {
    outputs.put(name, content);
  }
  outputs.commit();
  tell_written(files);
  const int simulated = step(simulate_tool, "simulate", {in("simulate.toml"), "--output", in("made")});
  if (simulated != success) {
    return simulated;
  }
  const std::string result = in("result");
  const int identified =
      step(identify_tool, "identify", {in("six_axis.toml"), "--report", "--output", result});
  show_page(folder / "result" / "report.html");
  return identified;
}

}  // namespace

int demo_command(int argc, char** argv) {
  std::filesystem::path folder = "rivid_demo";
  return run_command({.name = "rivid demo",
                      .description = "Simulates a robot of six joints, identifies it, and shows the report.",
                      .arguments = {{"folder", "DIR", "Folder for the files; default: rivid_demo", &folder},
                                    {"--force", "", "Replace files that are there"}},
                      .footer = "Exit codes: those of rivid simulate and rivid identify."},
                     argc, argv, [&] { return demo(folder); });
}

}  // namespace rivid::apps
