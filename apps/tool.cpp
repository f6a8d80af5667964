#include "tool.hpp"

#include <iostream>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::apps {

namespace {

void complain(const CLI::App& app, std::string_view kind, std::string_view what) {
  std::cerr << app.get_name() << ": " << kind << ": " << on_one_line(what) << '\n';
}

}  // namespace

int run_tool(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
      if (e.get_exit_code() == 0) {  // --help, --version
        return app.exit(e);
      }
      complain(app, "error", std::string(e.what()) + "; --help tells the usage");
      return bad_input;
    }
    return work();
  } catch (const InputError& e) {
    complain(app, "error", e.what());
    return bad_input;
  } catch (const std::exception& e) {
    complain(app, "failure", e.what());
    return numerics;
  }
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
