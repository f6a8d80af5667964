// Factors of logs and of loops: what is read can be written, read again and merged, and an identification
// from it ends.

#include "harness.hpp"
#include "rivid/experiment/factors_file.hpp"

namespace {

using namespace rivid;

// Reads, writes and reads again.
template <typename Decode>
auto round_trip(std::string_view bytes, const Decode& decode) {
  auto out = fuzz::accepted([&] { return decode(bytes); });
  if (out) {
    const std::string written = encoded(*out);
    const auto again = fuzz::read_back("factors can be read again", [&] { return decode(written); });
    fuzz::require(encoded(again) == written, "read(write(factors)) = factors");
  }
  return out;
}

void try_logs(std::string_view bytes) {
  static const Experiment experiment = read_experiment(RIVID_DATA "/scara/scara.toml");
  auto factors =
      round_trip(bytes, [](std::string_view from) { return decoded_factors(from, "log.factors"); });
  if (!factors) {
    return;
  }
  (void)fuzz::accepted([&] { return identify(experiment.robot, factors->factors, {.method = Wls{}}); });
  FactorsFile twice = *factors;
  twice.logs.clear();
  (void)fuzz::accepted([&] {
    merge(twice, *factors, "log.factors");
    return 0;
  });
}

void try_loops(std::string_view bytes) {
  auto loops = round_trip(bytes, [](std::string_view from) { return decoded_loop_factors(from, "loops"); });
  if (loops) {
    const LoopFactors same = *loops;
    (void)fuzz::accepted([&] {
      merge(*loops, same);
      return 0;
    });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const bool checksum_fits = input.choice(2) == 1;
  const std::size_t what = input.choice(3);
  std::string bytes(input.rest());
  if (checksum_fits && bytes.size() >= sizeof(std::uint64_t)) {
    fuzz::put_checksum(bytes);
  }
  if (what == 0) {
    try_logs(bytes);
  } else if (what == 1) {
    try_loops(bytes);
  } else {
    (void)round_trip(bytes, [](std::string_view from) { return decoded_loop_request(from, "request"); });
  }
  return 0;
}
