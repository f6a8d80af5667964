#include "tool.hpp"

#include <iostream>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::apps {

namespace {

void complain(std::string_view name, std::string_view kind, std::string_view what) {
  std::cerr << name << ": " << kind << ": " << on_one_line(what) << '\n';
}

}  // namespace

int run_tool(std::string_view name, int (*tool)(int argc, char** argv), int argc, char** argv) {
  try {
    return tool(argc, argv);
  } catch (const InputError& e) {
    complain(name, "error", e.what());
    return bad_input;
  } catch (const std::exception& e) {
    complain(name, "failure", e.what());
    return numerics;
  }
}

std::optional<int> parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help, --version
      return app.exit(e);
    }
    throw InputError(std::string(e.what()) + "; --help tells the usage");
  }
  return std::nullopt;
}

void print(const std::string& text) {
  if (!(std::cout << text << std::flush)) {
    throw InputError("standard output can not be written to");
  }
}

void tell(std::string_view kind, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::cerr << kind << ": " << line << '\n';
  }
}

void tell(std::string_view kind, const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings) {
    std::cerr << kind << " [" << warning.code << "] " << warning.text << '\n';
  }
}

std::filesystem::path output_folder(const std::filesystem::path& flag,
                                    const std::filesystem::path& experiment, std::string_view suffix) {
  return flag.empty() ? std::filesystem::path(experiment.stem().string() + std::string(suffix)) : flag;
}

Provenance provenance_of(const std::string& program, const std::vector<std::filesystem::path>& inputs,
                         Overrides overrides) {
  Provenance out{.program = program, .inputs = {}, .overrides = std::move(overrides)};
  for (const std::filesystem::path& input : inputs) {
    out.inputs.push_back(input_file(input));
  }
  return out;
}

}  // namespace rivid::apps
