// Files of accumulators: what is read and written again has the same bytes.

#include "harness.hpp"
#include "rivid/solve/streaming_qr.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rivid;
  fuzz::Input input(data, size);
  const bool checksum_fits = input.choice(2) == 1;
  std::string bytes(input.rest());
  if (checksum_fits && bytes.size() >= sizeof(std::uint64_t)) {
    fuzz::put_checksum(bytes);
  }
  const auto written = fuzz::accepted([&] { return encoded(decoded_streaming_qr(bytes, "rows.qr")); });
  fuzz::require(!written || *written == bytes, "write(read(bytes)) = bytes");
  return 0;
}
