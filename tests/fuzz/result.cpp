// result.json: a robot that is accepted can be computed with, and what is exported of it is well-formed.

#include <pugixml.hpp>

#include "harness.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/model.hpp"

namespace {

using namespace rivid;

void expect_exports(const IdentifiedRobot& identified, const std::filesystem::path& urdf) {
  for (const ModelFormat format : {ModelFormat::urdf, ModelFormat::mjcf, ModelFormat::sdf}) {
    const auto model = fuzz::accepted([&] {
      return exported_model(format, urdf, identified.robot, identified.chi_st,
                            {.force = true, .file = "model.xml", .origin = identified.run});
    });
    if (model && !model->files.empty()) {
      pugi::xml_document xml;
      fuzz::require(xml.load_string(model->files.front().text.c_str()), "an exported model is XML");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto urdf = fuzz::file_with(test::content_of(RIVID_DATA "/scara/scara.urdf"), "scara.urdf");
  fuzz::Input input(data, size);
  IdentifiedModelOptions options;
  options.force = input.choice(2) == 1;
  const std::size_t set = input.choice(3);
  if (set > 0) {
    options.parameters = set == 1 ? ParameterSet::estimate : ParameterSet::physical;
  }
  const auto path = fuzz::file_with(input.rest(), "result.json");
  const auto identified = fuzz::accepted([&] { return read_identified_robot(path, options); });
  if (identified) {
    fuzz::require(identified->chi_st.allFinite(), "parameters are finite");
    const auto model = fuzz::accepted([&] { return DynamicModel(identified->robot, identified->chi_st); });
    if (model) {
      (void)c_header(*model, c_identifier(identified->robot.name), identified->run);
    }
    expect_exports(*identified, urdf);
  }
  (void)fuzz::accepted([&] { return read_online_model(path, options); });
  (void)fuzz::accepted([&] { return result_of(test::content_of(path), path.string()); });
  return 0;
}
