// Files of parameters: values that are read, written as standard parameters and read again are the same.

#include "harness.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/text.hpp"

namespace {

using namespace rivid;

const BaseParameters& base() {
  static const BaseParameters out = [] {
    Robot robot = read_urdf(RIVID_DATA "/scara/scara.urdf");
    return base_parameters(robot);
  }();
  return out;
}

std::string table_of(const Vector& chi_st) {
  static const auto names = read_urdf(RIVID_DATA "/scara/scara.urdf").standard_parameters();
  std::string out = "name,value\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    out += names[i].name() + "," + exact(chi_st[static_cast<Index>(i)]) + "\n";
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array<const char*, 3> endings = {".json", ".toml", ".csv"};
  fuzz::Input input(data, size);
  const std::string name = std::string("parameters") + endings[input.choice(endings.size())];
  const auto path = fuzz::file_with(input.rest(), name);
  const auto chi_st = fuzz::accepted([&] { return read_parameters(path, base()); });
  if (chi_st) {
    fuzz::require(chi_st->allFinite(), "parameters are finite");
    const Vector again = fuzz::read_back("parameters can be read again", [&] {
      return read_parameters(fuzz::file_with(table_of(*chi_st), "again.csv"), base());
    });
    fuzz::require(again == *chi_st, "read(write(x)) = x");
  }
  return 0;
}
