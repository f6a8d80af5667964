// Logs, references and tables of torques: a log that is read, written and read again is the same.

#include "rivid/data/csv.hpp"

#include "harness.hpp"
#include "rivid/data/adjust.hpp"

namespace {

using namespace rivid;

void expect_same(const Log& a, const Log& b) {
  fuzz::require(a.t == b.t && a.q == b.q && a.qd == b.qd && a.tau == b.tau && a.v_tau == b.v_tau &&
                    a.q_r == b.q_r && a.qd_r == b.qd_r,
                "read(write(log)) = log");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const std::size_t what = input.choice(4);
  LogOptions options;
  options.table.separator = static_cast<Separator>(input.choice(5));
  options.table.decimal = static_cast<Decimal>(input.choice(3));
  options.table.header = static_cast<Header>(input.choice(3));
  const std::filesystem::path path = fuzz::file_with(input.rest(), "log.csv");
  if (what == 0) {
    const auto table = fuzz::accepted([&] { return read_table(path, options.table); });
    fuzz::require(!table || table->values.allFinite(), "a table is finite");
  } else if (what == 1) {
    const auto table = fuzz::accepted([&] { return read_torque_table(path, options.table); });
    fuzz::require(!table || !table->complaint(), "a table of torques can be used");
  } else {
    if (what == 3) {
      options.rate_hz = 1000.0;
    }
    const auto log = fuzz::accepted([&] { return read_csv(path, options); });
    if (log) {
      expect_same(*log, fuzz::read_back("a log can be read again", [&] {
        return read_csv(fuzz::file_with(to_csv(*log), "again.csv"), {.rate_hz = options.rate_hz});
      }));
    }
    (void)fuzz::accepted([&] { return read_reference(path, options); });
  }
  return 0;
}
