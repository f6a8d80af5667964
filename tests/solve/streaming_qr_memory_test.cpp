#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstddef>

#include "rivid/solve/streaming_qr.hpp"

namespace rivid {
namespace {

// Kilobytes at the worst moment of this process so far.
long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// The rows, were they kept, would take 98 MB. benchmarks/streaming_qr_memory.cpp measures 1e7 of them.
TEST(StreamingQrMemory, DoesNotGrowWithTheRows) {
  constexpr Index columns = 60;
  constexpr Index block = 1000;
  Matrix W = Matrix::NullaryExpr(block, columns, [](Index r, Index c) {
    return static_cast<double>((r * 7919 + c * 104729) % 1009) - 504.0;
  });
  const Vector Y = W.rowwise().sum();
  StreamingQr qr(columns);
  const auto feed = [&](int blocks) {
    for (int k = 0; k < blocks; ++k) {
      W(k % block, k % columns) += 1.0;
      qr.add(W, Y);
    }
  };
  feed(4);
  const long before = peak_memory();
  feed(200);
  constexpr long noise = 4096;  // pages that the C library or a sanitizer take on their own account
  EXPECT_LE(peak_memory() - before, noise);
  EXPECT_EQ(qr.rows(), 204 * block);
}

}  // namespace
}  // namespace rivid
