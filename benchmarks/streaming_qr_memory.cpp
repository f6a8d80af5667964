// The most memory that the program ever held while 1e7 rows of 60 columns, 4.9 GB if they were kept, went
// through a StreamingQr.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <random>

#include "rivid/solve/streaming_qr.hpp"

namespace {

void ten_million_rows(benchmark::State& state) {
  constexpr rivid::Index columns = 60;
  constexpr rivid::Index block = 1000;
  constexpr rivid::Index blocks = 10'000;
  std::mt19937_64 random(20260805);
  std::normal_distribution<double> normal;
  const rivid::Matrix A = rivid::Matrix::NullaryExpr(block, columns + 1, [&] { return normal(random); });
  const rivid::Matrix B = rivid::Matrix::NullaryExpr(block, columns + 1, [&] { return normal(random); });
  rivid::Matrix WY(block, columns + 1);
  for (auto _ : state) {
    rivid::StreamingQr qr(columns);
    for (rivid::Index k = 0; k < blocks; ++k) {
      WY = A + std::sin(static_cast<double>(k)) * B;
      qr.add(WY.leftCols(columns), WY.rightCols(1));
    }
    benchmark::DoNotOptimize(qr.R().data());
    state.counters["rows"] = static_cast<double>(qr.rows());
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_MB"] = 1e-6 * 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace

BENCHMARK(ten_million_rows)->Iterations(1)->Unit(benchmark::kSecond);
