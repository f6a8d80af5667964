// Experiment files for every use, with a second file that they may name: the settings that come out, laid
// over the file, give themselves.

#include "rivid/experiment/experiment.hpp"

#include "harness.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"

namespace {

using namespace rivid;

// Values that TOML writes as JSON does. A word in the place of a number is laid over as such.
bool is_plain(const Setting& setting) {
  return setting.origin == "file" && setting.value.find_first_of("{\\") == std::string::npos &&
         setting.value != "null";
}

void expect_same_again(const std::filesystem::path& path, Use use, const std::vector<Setting>& before) {
  std::vector<std::string> laid_over;
  for (const Setting& setting : before) {
    if (is_plain(setting)) {
      laid_over.push_back(setting.key + "=" +
                          (setting.words.starts_with('"') ? setting.words : setting.value));
    }
  }
  const auto after = settings(
      fuzz::read_back("settings can be laid over", [&] { return read_experiment(path, use, laid_over); }),
      use);
  fuzz::require(after.size() == before.size(), "the same settings");
  for (std::size_t i = 0; i < after.size(); ++i) {
    fuzz::require(after[i].key == before[i].key && after[i].value == before[i].value,
                  before[i].key + " comes back: " + before[i].value + ", " + after[i].value);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool provided = [] {
    fuzz::file_with(test::content_of(RIVID_DATA "/scara/scara.urdf"), "scara.urdf");
    fuzz::file_with(test::content_of(RIVID_DATA "/six_axis/six_axis.urdf"), "six_axis.urdf");
    return true;
  }();
  fuzz::require(provided, "robots are there");
  fuzz::Input input(data, size);
  const std::size_t use = input.choice(4);
  const auto path = fuzz::file_with(input.file(), "experiment.toml");
  fuzz::file_with(input.rest(), "part.csv");
  if (use == 2) {
    const auto plan = fuzz::accepted([&] { return read_excitation(path); });
    (void)(plan && !settings(*plan).empty());
  } else if (use == 3) {
    (void)fuzz::accepted([&] { return read_monte_carlo(path); });
  } else {
    const Use read_for = use == 0 ? Use::identification : Use::simulation;
    const auto experiment = fuzz::accepted([&] { return read_experiment(path, read_for); });
    if (experiment) {
      expect_same_again(path, read_for, settings(*experiment, read_for));
    }
  }
  return 0;
}
