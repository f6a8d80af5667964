// rivid init: a draft that says it is complete is an experiment file that can be read.

#include "rivid/experiment/draft.hpp"

#include "harness.hpp"
#include "rivid/experiment/experiment.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rivid;
  static const std::string scara = test::content_of(RIVID_DATA "/scara/scara.urdf");
  fuzz::Input input(data, size);
  const std::vector<std::filesystem::path> logs = {fuzz::file_with(input.file(), "log.csv")};
  const auto urdf = fuzz::file_with(input.rest().empty() ? scara : input.rest(), "robot.urdf");
  const auto file = fuzz::folder().path() / "robot.toml";
  const auto draft = fuzz::accepted([&] { return draft_experiment(file, urdf, {}, logs); });
  if (draft && draft->complete) {
    fuzz::file_with(draft->text, "robot.toml");
    const Experiment experiment =
        fuzz::read_back("a complete draft is readable", [&] { return read_experiment(file); });
    (void)fuzz::accepted([&] { return read_logs(experiment.log, experiment.robot); });
  }
  return 0;
}
