#include <gtest/gtest.h>

#include <filesystem>

#include "rivid/output.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "support/complaint.hpp"
#include "support/random_matrix.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

StreamingQr accumulator(Index columns, Index carried, std::uint64_t seed = 81) {
  StreamingQr qr(columns, carried);
  qr.add(test::random_matrix(700, columns, seed), test::random_matrix(700, carried, seed + 1));
  return qr;
}

std::string message(const std::string& content) {
  return test::complaint_of([&] { return decoded_streaming_qr(content, "part.qr"); });
}

void expect_same(const StreamingQr& a, const StreamingQr& b) {
  EXPECT_EQ(a.rows(), b.rows());
  EXPECT_EQ(a.R(), b.R());
  EXPECT_EQ(a.qt_carried(), b.qt_carried());
  EXPECT_EQ(a.unreachable_norms(), b.unreachable_norms());
  EXPECT_EQ(a.column_sums(), b.column_sums());
  EXPECT_EQ(a.y_sum(), b.y_sum());
}

TEST(StreamingQrFile, GivesBackEveryBit) {
  for (const Index columns : {0, 1, 17}) {
    for (const Index carried : {1, 18}) {
      const StreamingQr qr = accumulator(columns, carried);
      expect_same(decoded_streaming_qr(encoded(qr), "memory"), qr);
    }
  }
}

TEST(StreamingQrFile, CanBeMergedAndAddedToAsIfItHadNeverBeenAFile) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "part.qr";
  StreamingQr qr = accumulator(9, 1);
  write_file(path, encoded(qr));
  StreamingQr read = read_streaming_qr(path);
  for (StreamingQr* const each : {&qr, &read}) {
    each->merge(accumulator(9, 1, 83));
    each->add(test::random_matrix(3, 9, 85), test::random_matrix(3, 1, 86));
  }
  expect_same(read, qr);
}

// The layout is a promise: these bytes must be read for ever.
TEST(StreamingQrFile, HasTheLayoutThatItsHeaderDescribes) {
  StreamingQr qr(1);
  qr.add(Vector{{3.0, 4.0}}, Vector{{0.0, 0.0}});
  const std::string content = encoded(qr);
  const std::string expected_start(
      "rivid-QR"
      "\1\0\0\0"
      "\4\3\2\1"
      "\1\0\0\0\0\0\0\0"
      "\1\0\0\0\0\0\0\0"
      "\2\0\0\0\0\0\0\0",
      40);
  EXPECT_EQ(content.substr(0, 40), expected_start);
  EXPECT_EQ(content.size(), 40U + 8U * (1 + 1 + 1 + 2) + 8U);
  EXPECT_EQ(content.substr(40 + 8 * 3, 8), std::string("\0\0\0\0\0\0\x1c\x40", 8));  // the sum of W, 7
}

TEST(StreamingQrFile, SaysWhatIsWrong) {
  const std::string good = encoded(accumulator(5, 1));
  EXPECT_EQ(message("t,q1\n0,1\n"),
            "part.qr: is no factor written by rivid; it must start with \"rivid-QR\"");
  EXPECT_EQ(message(""), "part.qr: is no factor written by rivid; it must start with \"rivid-QR\"");
  EXPECT_EQ(message(good.substr(0, 5)), "part.qr: is truncated: 5 bytes of at least 48");
  EXPECT_EQ(
      message(good.substr(0, 100)),
      "part.qr: is truncated: 100 bytes; with 5 + 1 columns it must have " + std::to_string(good.size()));
  EXPECT_EQ(message(good + "x"), "part.qr: is too long: " + std::to_string(good.size() + 1) +
                                     " bytes; with 5 + 1 columns it must have " +
                                     std::to_string(good.size()));
  std::string other = good;
  other[8] = 2;
  EXPECT_EQ(message(other), "part.qr: has version 2 of the format; this rivid reads version 1");
  other = good;
  std::swap(other[12], other[15]);
  std::swap(other[13], other[14]);
  EXPECT_EQ(message(other), "part.qr: has its bytes in another order; the format is little-endian");
  other = good;
  other[23] = 1;
  EXPECT_NE(message(other).find("part.qr: is damaged: "), std::string::npos) << message(other);
}

TEST(StreamingQrFile, NoticesEveryDamagedByte) {
  const std::string good = encoded(accumulator(3, 2));
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    EXPECT_NE(message(bad), "") << "byte " << i;
    EXPECT_NE(message(good.substr(0, i)), "") << "length " << i;
  }
}

TEST(StreamingQrFile, ThatCanNotBeReadIsNamed) {
  const auto complaint = [](const std::filesystem::path& path) {
    return test::complaint_of([&] { return read_streaming_qr(path); });
  };
  EXPECT_EQ(complaint("/no/such/part.qr"), "/no/such/part.qr: there is no such file");
  EXPECT_EQ(complaint("/"), "/: is a directory, a file is required");
}

}  // namespace
}  // namespace rivid
