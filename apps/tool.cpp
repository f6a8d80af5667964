#include "tool.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <sstream>
#include <thread>
#include <type_traits>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/report/limits.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::apps {

namespace {

constexpr int megabyte_bits = 20;  // 2^20 bytes

// A file opened later must not take the number of a standard stream that is closed, and be written to as
// such.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) < 0) {
      // Takes the lowest free number. What is read-only refuses output as a closed stream does.
      static_cast<void>(::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
    }
  }
}

// Short names of options that several tools have.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> short_names = {
    {{"--quiet", "-q"}, {"--output", "-o"}, {"--verbose", "-v"}}};

std::string with_short_name(const std::string& name) {
  const auto at = std::ranges::find(short_names, name, [](const auto& pair) { return pair.first; });
  return at == short_names.end() ? name : std::string(at->second) + "," + name;
}

// Whether --force was given: what stands at the place of an output is replaced, whoever wrote it.
bool& replaces_foreign_files() {
  static bool force = false;
  return force;
}

// Of a command that writes files.
constexpr std::string_view force_option = "--force";

bool has(const Command& command, std::string_view name) {
  return std::ranges::find(command.arguments, name, &Argument::name) != command.arguments.end();
}

bool takes_force(const Command& command) { return has(command, force_option) || has(command, "--output"); }

// Options that identify had before rivid export.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> moved = {
    {{"--write-urdf", "urdf"}, {"--sidecar", "mjcf|drake|pinocchio"}, {"--write-header", "header"}}};

// What is the matter with an argument that the command does not have.
std::string unknown_argument(const Command& command, const std::string& argument) {
  const std::string name = argument.substr(0, argument.find('='));
  if (!name.starts_with('-')) {
    return in_quotes(argument) + " is one argument too many";
  }
  const auto at = std::ranges::find(moved, name, [](const auto& pair) { return pair.first; });
  if (command.name == "rivid identify" && at != moved.end()) {
    return name + " is now rivid export RESULT --to " + std::string(at->second);
  }
  std::vector<std::string> names = {"--help", "--max-size", "--color"};
  if (takes_force(command)) {
    names.emplace_back(force_option);
  }
  for (const Argument& known : command.arguments) {
    names.push_back(known.name);
  }
  return in_quotes(name) + " is no option of " + command.name + did_you_mean(name, names);
}

CLI::Option* added(CLI::App& app, const Argument& argument) {
  return std::visit(
      [&](auto* target) {
        if constexpr (std::is_same_v<decltype(target), bool*>) {
          bool& flag = target != nullptr ? *target : replaces_foreign_files();
          return app.add_flag(with_short_name(argument.name), flag, argument.text);
        } else {
          return app.add_option(with_short_name(argument.name), *target, argument.text)
              ->type_name(argument.value);
        }
      },
      argument.target);
}

// A check for one of the words of "auto|always|never".
CLI::Validator one_of(const std::string& choices) {
  const std::vector<std::string> words = CLI::detail::split(choices, '|');
  return {[words](const std::string& word) {
            return std::ranges::find(words, word) != words.end()
                       ? std::string()
                       : in_quotes(word) + " is none of " + quoted_list(words) + did_you_mean(word, words);
          },
          ""};
}

CLI::Validator within(const CommandLineNumber& number) {
  return {[&number](const std::string& word) {
            double value = 0.0;
            return !CLI::detail::lexical_cast(word, value) || !std::isfinite(value)
                       ? in_quotes(word) + " must be a number"
                   : number.range.holds(value) ? std::string()
                                               : out_of_range("it", value, number.unit, number.range);
          },
          ""};
}

bool is_number(const Argument::Target& target) {
  return std::visit(
      [](const auto* to) {
        using Value = std::decay_t<decltype(*to)>;
        return !std::is_same_v<Value, bool> &&
               (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::optional<int>> ||
                std::is_same_v<Value, std::optional<std::int64_t>>);
      },
      target);
}

void declare(CLI::App& app, const Argument& argument) {
  CLI::Option* const option = added(app, argument)->required(argument.required);
  if (argument.value.find('|') != std::string::npos) {
    option->check(one_of(argument.value));
  }
  if (is_number(argument.target)) {
    option->check(within(command_line_number(argument.name)));
  }
  if (!argument.needs.empty()) {
    option->needs(argument.needs);
  }
  if (!argument.excludes.empty()) {
    option->excludes(argument.excludes);
  }
  if (argument.one_each) {
    option->allow_extra_args(false);
  }
}

std::string robot_instead(const std::string& robot, const std::string& log) {
  return robot + ": is a robot, an experiment file is required; rivid init " + robot + " " + log +
         " writes one";
}

// Word processors make one of two hyphens.
void refuse_long_dash(const std::string& argument) {
  for (const std::string_view dash : {"–", "—", "−"}) {
    if (argument.starts_with(dash)) {
      const std::string rest = argument.substr(dash.size());
      throw InputError(
          in_quotes(argument) + " begins with a long dash; did you mean " +
          in_quotes((rest.size() > 1 && std::isalpha(static_cast<unsigned char>(rest[0])) != 0 ? "--" : "-") +
                    rest) +
          "?");
    }
  }
}

// A help page for the terminal: what is longer than its lines goes on below the description.
std::string in_lines(const std::string& help) {
  constexpr std::size_t column = 30;  // where descriptions of options begin
  const std::size_t screen = screen_width();
  const std::size_t end = screen == 0 ? longest_line : std::min(screen, longest_line);
  std::string out;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t kept = line.starts_with(' ') && line.size() > column ? column : 0;
    const std::string text =
        display_width(line) > end ? folded(line.substr(kept), kept > 0 ? kept : 2, end) : line.substr(kept);
    out += line.substr(0, kept) + text + '\n';
  }
  return out;
}

// An exit code where help or version were asked for.
std::optional<int> parse(CLI::App& app, const Command& command, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    // The first one that is an option: what follows it may be its value.
    const std::vector<std::string> extras = app.remaining();
    const auto option = std::ranges::find_if(extras, [](const std::string& e) { return e.starts_with('-'); });
    throw InputError(unknown_argument(command, option == extras.end() ? extras.front() : *option) +
                     "; --help prints the usage");
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      std::ostringstream out;
      app.exit(e, out, out);
      print(in_lines(out.str()));
      return success;
    }
    throw InputError(std::string(e.what()) + "; --help prints the usage");
  }
  return std::nullopt;
}

}  // namespace

bool is_robot(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending == ".urdf" || ending == ".xacro";
}

int run_command(const Command& command, int argc, char** argv, const std::function<int()>& run) {
  for (int i = 1; i < argc; ++i) {
    refuse_long_dash(argv[i]);
  }
  CLI::App app(command.description, command.name);
  for (const Argument& argument : command.arguments) {
    declare(app, argument);
  }
  std::int64_t most_megabytes = default_input_limit >> megabyte_bits;
  app.add_option("--max-size", most_megabytes, "Largest file that is read [MiB]; default: 16384")
      ->type_name("NUMBER")
      ->check(within(command_line_number("--max-size")));
  app.add_option("--color", when_coloured(), "Colours: on a terminal without NO_COLOR, or always, or never")
      ->type_name("auto|always|never")
      ->check(one_of("auto|always|never"));
  if (takes_force(command) && !has(command, force_option)) {
    app.add_flag(std::string(force_option), replaces_foreign_files(),
                 "Replace files that rivid did not write, or that were edited since, too");
  }
  app.set_version_flag("--version", "rivid " + std::string(version));
  app.footer(command.footer);
  const std::optional<int> ended = parse(app, command, argc, argv);
  for (const Argument& argument : command.arguments) {
    int* const* const threads = std::get_if<int*>(&argument.target);
    if (argument.name == "--threads" && threads != nullptr && **threads == 0) {
      **threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 1024U));
    }
  }
  limit_inputs(static_cast<std::uintmax_t>(most_megabytes) << megabyte_bits);
  return ended ? *ended : run();
}

namespace {

// An arena of the allocator reserves 64 MB of addresses for each thread, of which a limit may leave too few
// for the work itself.
void share_arenas_within_limits() {
#ifdef M_ARENA_MAX
  rlimit addresses{};
  if (::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY) {
    ::mallopt(M_ARENA_MAX, 1);
  }
#endif
}

}  // namespace

int run_tool(std::string_view name, int (*tool)(int argc, char** argv), int argc, char** argv) {
  occupy_standard_streams();
  share_arenas_within_limits();
  exit_on_signals();
  const InputScope inputs;
  // What goes wrong while the command line is read is coloured as it says, too.
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    constexpr std::string_view option = "--color";
    if (argument.starts_with("--color=")) {
      when_coloured() = argument.substr(option.size() + 1);
    } else if (argument == option && i + 1 < argc) {
      when_coloured() = argv[i + 1];
    }
  }
  try {
    return tool(argc, argv);
  } catch (const InputError& e) {
    complain(name, "error", e.what());
    return bad_input;
  } catch (const std::filesystem::filesystem_error& e) {
    complain(name, "error", e.path1().string() + ": " + e.code().message());
    return bad_input;
  } catch (const std::bad_alloc&) {
    complain(name, "failure",
             "there is not enough memory; shorter logs, lower rates or fewer runs take less");
    return numerics;
  } catch (const std::exception& e) {
    complain(name, "failure", e.what());
    return numerics;
  }
}

void print_answer(const Given& how, const std::string& json, const std::string& words) {
  if (how.json || !how.quiet) {
    print(how.json ? json : words);
  }
}

void tell_written(const Given& how, const std::vector<PlannedFile>& files) {
  if (!how.quiet) {
    tell_written(files);
  }
}

void finish(const Given& how, Outputs& outputs, const std::vector<PlannedFile>& files,
            const std::string& json, const std::string& words) {
  outputs.commit();
  print_answer(how, json, words);
  tell_written(how, files);
}

void expect_experiment(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    return;  // reading it says what it is
  }
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::string name = file.string();
  constexpr std::array<std::string_view, 9> logs = {".csv", ".tsv", ".txt", ".dat",    ".mcap",
                                                    ".bag", ".mat", ".npz", ".parquet"};
  if (is_robot(file)) {
    throw InputError(robot_instead(name, "LOG.csv"));
  }
  if (std::ranges::find(logs, ending) != logs.end()) {
    throw InputError(name + ": is a log, an experiment file is required; rivid init ROBOT.urdf " + name +
                     " writes one");
  }
  if (ending == ".yaml" || ending == ".yml") {
    throw InputError(name + ": is YAML, experiment files are TOML; rivid init ROBOT.urdf LOG.csv writes one");
  }
  if (ending == ".json") {
    throw InputError(name +
                     ": is a result, an experiment file is required; rivid validate and "
                     "rivid export take results");
  }
}

namespace {

// Tables and texts that people edit. They bear no mark: the document of the run that wrote them has their
// SHA-256.
bool is_table(const PlannedFile& file) {
  constexpr std::array<std::string_view, 5> tables = {".csv", ".npz", ".toml", ".yaml", ".script"};
  return std::ranges::find(tables, file.extension) != tables.end();
}

// Documents of a run that was killed before they took their place. Its tables had, for they are the first to.
std::vector<InputText> unfinished_documents(const std::filesystem::path& folder) {
  std::vector<InputText> out;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (is_temporary_output(entry.path()) && entry.is_regular_file(error)) {
      out.push_back(read_input(entry.path()));
    }
  }
  return out;
}

void expect_own(const std::vector<PlannedFile>& files) {
  std::vector<InputText> marked;
  std::error_code error;
  const auto is_there = [&](const PlannedFile& f) {
    return std::filesystem::is_regular_file(f.path, error) && std::filesystem::file_size(f.path, error) > 0;
  };
  const auto refuse = [](const PlannedFile& f, const std::string& why) {
    throw InputError(f.path.string() + ": is there already and " + why +
                     "; name another file, or --force replaces it");
  };
  for (const PlannedFile& file : files) {
    if (is_there(file) && !is_table(file) && !file.continued) {
      marked.push_back(read_input(file.path));
      if (marked.back().bytes().find("rivid") == std::string_view::npos) {
        refuse(file, "was not written by rivid");
      }
    }
  }
  for (const PlannedFile& file : files) {
    if (is_there(file) && is_table(file) && !file.continued) {
      const std::string digest = input_sha256(file.path);
      // Behind the inputs, which a document names by their hashes as well.
      const auto names_it = [&](const InputText& text) {
        return text.bytes().find(digest, text.bytes().find("\"outputs\"")) != std::string_view::npos;
      };
      const std::filesystem::path folder = file.path.parent_path();
      if (std::ranges::none_of(marked, names_it) &&
          std::ranges::none_of(unfinished_documents(folder.empty() ? "." : folder), names_it)) {
        refuse(file, "was not written by the last run that wrote here, or was edited since");
      }
    }
  }
}

}  // namespace

Outputs planned(const std::vector<std::filesystem::path>& inputs, const std::vector<PlannedFile>& files,
                bool force) {
  force = force || replaces_foreign_files();
  Outputs out(inputs, force);
  for (const bool tables : {true, false}) {
    for (const PlannedFile& file : files) {
      if (is_table(file) == tables) {
        out.plan(file.path, file.extension);
      }
    }
  }
  if (!force) {
    expect_own(files);
  }
  return out;
}

std::string would_write(const std::vector<PlannedFile>& files) {
  std::string out;
  for (const PlannedFile& file : files) {
    out += "would write " + file.path.string() + "\n";
  }
  return out;
}

std::filesystem::path result_file(const std::filesystem::path& given) {
  std::error_code error;
  return std::filesystem::is_directory(given, error) ? given / "result.json" : given;
}

std::filesystem::path output_folder(const std::filesystem::path& flag,
                                    const std::filesystem::path& experiment, std::string_view suffix) {
  if (!flag.empty()) {
    return flag;
  }
  const std::filesystem::path out = experiment.stem().string() + std::string(suffix);
  std::error_code error;
  const auto canonical = [&](const std::filesystem::path& file) {
    return std::filesystem::weakly_canonical(file, error);
  };
  for (const auto& entry : std::filesystem::directory_iterator(out, error)) {
    const bool document = entry.path().extension() == ".json" && entry.is_regular_file(error);
    const std::filesystem::path other =
        document ? recorded_experiment(entry.path()) : std::filesystem::path();
    if (!other.empty() && !replaces_foreign_files() && canonical(other) != canonical(experiment)) {
      throw InputError(out.string() + ": holds what was made from " + other.string() + ", not from " +
                       experiment.string() + "; --output names another folder, --force replaces it");
    }
  }
  return out;
}

Argument set_argument(std::vector<std::string>& to) {
  return {.name = "--set",
          .value = "KEY=VALUE",
          .text = "A setting instead of the file's: signal.decimation=5; may be repeated",
          .target = &to,
          .one_each = true};
}

std::string in_lines(const std::vector<Setting>& settings) {
  std::vector<std::string> values;
  std::size_t key_width = 0;
  std::size_t value_width = 0;
  for (const Setting& s : settings) {
    // characters of a value that others line up behind; a choice of layout
    constexpr std::size_t widest = 40;
    // Of words that stand for a number the unit says nothing.
    const bool in_units = !s.unit.empty() && s.words == s.value;
    values.push_back(in_units ? s.words + " " + s.unit : s.words);
    key_width = std::max(key_width, s.key.size());
    value_width = std::max(value_width, std::min(display_width(values.back()), widest));
  }
  std::string out;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const std::size_t width = display_width(values[i]);
    out += settings[i].key + std::string(key_width - settings[i].key.size() + 2, ' ') + values[i] +
           std::string((width < value_width ? value_width - width : 0) + 2, ' ') + settings[i].origin + '\n';
  }
  return out;
}

void put_with_hash(const std::filesystem::path& file, std::string_view content, Outputs& outputs,
                   Provenance& provenance) {
  outputs.put(file, content);
  provenance.outputs.push_back({file.filename().string(), sha256(content)});
}

void add_origins(const std::vector<std::string>& set, const std::vector<std::filesystem::path>& inputs,
                 Provenance& to) {
  for (const std::string& setting : set) {
    const std::size_t equals = setting.find('=');
    to.overrides.emplace_back("set " + setting.substr(0, equals), setting.substr(equals + 1));
  }
  for (const std::filesystem::path& input : inputs) {
    to.inputs.push_back(input_file(input));
  }
}

Provenance provenance_of(const std::string& program, const Experiment& experiment, Use use,
                         Overrides overrides, const std::vector<std::string>& set) {
  Provenance out{.program = program,
                 .inputs = {},
                 .overrides = std::move(overrides),
                 .settings = settings(experiment, use)};
  add_origins(set, experiment.inputs(use), out);
  return out;
}

}  // namespace rivid::apps
