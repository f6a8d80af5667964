// Streaming QR of [W Y]: GFLOP/s, the part of the machine's multiply-add peak, and how many times faster than
// Eigen's HouseholderQR on all rows at once, than the same on blocks under the previous triangle, and than
// LAPACK's dgeqrf where CMake found a LAPACK. The rows come from one large matrix; those "in cache" from a
// block that stays. All take turns within every iteration, and the fastest turn of each counts, so that a
// busy machine hurts all alike. Operations are counted as 2 b² + 4 b a row, the same for all.

#include "rivid/solve/streaming_qr.hpp"

#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <limits>
#include <random>

#include "peak.hpp"

#ifdef RIVID_LAPACK
extern "C" void dgeqrf_(const int* rows, const int* columns, double* A, const int* stride, double* tau,
                        double* work, const int* work_size, int* info);
#endif

namespace {

using rivid::Index;
using rivid::Matrix;
using rivid::Vector;

constexpr Index rows = 20480;
constexpr Index block = 512;

template <typename Run>
void best_of(double& best, const Run& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

constexpr double never = std::numeric_limits<double>::infinity();

// Normal deviates.
Matrix deviates(Index count, Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(count, columns, [&] { return normal(random); });
}

// Rows that stay in the cache, the last `carried` columns carried along, in steps of so many rows.
void add_from_cache(const Matrix& rows_in_cache, Index carried, Index step = block) {
  const Index b = rows_in_cache.cols() - carried;
  rivid::StreamingQr qr(b, carried);
  for (Index first = 0; first < rows; first += step) {
    qr.add(rows_in_cache.block(first % block, 0, step, b),
           rows_in_cache.block(first % block, b, step, carried));
  }
  benchmark::DoNotOptimize(qr.R().data());
}

// Eigen alone, the way a user would stream with it.
void eigen_on_blocks(const Matrix& WY, Matrix& triangle) {
  const Index all = WY.cols();
  triangle = Matrix::Zero(all, all);
  Matrix stacked;
  for (Index first = 0; first < rows; first += block) {
    stacked.resize(all + block, all);
    stacked.topRows(all) = triangle;
    stacked.bottomRows(block) = WY.middleRows(first, block);
    const Eigen::HouseholderQR<Eigen::Ref<Matrix>> qr(stacked);
    triangle = stacked.topRows(all).triangularView<Eigen::Upper>();
  }
}

void streaming_qr(benchmark::State& state) {
  const Index b = state.range(0);
  const Matrix WY = deviates(rows, b + 1, 20260801);
  const Matrix one_block = WY.topRows(block);
  Matrix scratch = WY;
  Matrix triangle;

  double streaming = never;
  double in_cache = never;
  double one_shot = never;
  double on_blocks = never;
  for (auto _ : state) {
    double now = never;
    best_of(now, [&] {
      rivid::StreamingQr qr(b);
      for (Index first = 0; first < rows; first += block) {
        qr.add(WY.block(first, 0, block, b), WY.block(first, b, block, 1));
      }
      benchmark::DoNotOptimize(qr.R().data());
    });
    state.SetIterationTime(now);
    streaming = std::min(streaming, now);
    // The way rivid works: a block is made, used and forgotten.
    best_of(in_cache, [&] { add_from_cache(one_block, 1); });
    scratch = WY;
    best_of(one_shot, [&] { const Eigen::HouseholderQR<Eigen::Ref<Matrix>> qr(scratch); });
    best_of(on_blocks, [&] { eigen_on_blocks(WY, triangle); });
  }
  const double operations = static_cast<double>(rows * (2 * b * b + 4 * b));
  state.counters["GFLOP/s"] = 1e-9 * operations / streaming;
  state.counters["x_one_shot"] = one_shot / streaming;
  state.counters["x_blocks"] = on_blocks / streaming;

  const rivid::benchmarks::Peak machine = rivid::benchmarks::peak(rivid::Simd::best);
  double peak_time = never;
  for (int k = 0; k < 100; ++k) {
    best_of(peak_time, machine.run);
  }
  const double per_operation = machine.lanes > 2 ? 2.0 : 1.0;  // fused or not
  const double peak = per_operation * machine.lanes * machine.operations / peak_time;
  state.counters["peak_GFLOP/s"] = 1e-9 * peak;
  state.counters["of_peak"] = operations / streaming / peak;
  state.counters["of_peak_in_cache"] = operations / in_cache / peak;

#ifdef RIVID_LAPACK
  double lapack = never;
  for (int k = 0; k < 3; ++k) {
    scratch = WY;
    const auto m = static_cast<int>(rows);
    const auto n = static_cast<int>(b + 1);
    const int work_size = 64 * n;
    Vector tau(n);
    Vector work(work_size);
    int info = 0;
    best_of(lapack, [&] { dgeqrf_(&m, &n, scratch.data(), &m, tau.data(), work.data(), &work_size, &info); });
  }
  state.counters["x_dgeqrf"] = lapack / streaming;
#endif
}

// One pass over [V | W Y] in units of one over [W Y].
void joint_factorisation(benchmark::State& state) {
  const Index b = state.range(0);
  const Matrix VWY = deviates(block, 2 * b + 1, 20260802);
  const Matrix WY = VWY.rightCols(b + 1);
  double ols = never;
  double joint = never;
  for (auto _ : state) {
    best_of(ols, [&] { add_from_cache(WY, 1); });
    double now = never;
    best_of(now, [&] { add_from_cache(VWY, b + 1); });
    state.SetIterationTime(now);
    joint = std::min(joint, now);
  }
  state.counters["ols_passes"] = joint / ols;
}

// Rows that come one by one, in units of the same in blocks.
void single_rows(benchmark::State& state) {
  const Index b = state.range(0);
  const Matrix WY = deviates(block, b + 1, 20260803);
  double blocks = never;
  double single = never;
  for (auto _ : state) {
    best_of(blocks, [&] { add_from_cache(WY, 1); });
    double now = never;
    best_of(now, [&] { add_from_cache(WY, 1, 1); });
    state.SetIterationTime(now);
    single = std::min(single, now);
  }
  state.counters["x_blocks"] = single / blocks;
}

// What merging the parts of two threads or files costs.
void merge(benchmark::State& state) {
  const Index b = state.range(0);
  const Matrix WY = deviates(block, b + 1, 20260804);
  rivid::StreamingQr one(b);
  one.add(WY.leftCols(b), WY.rightCols(1));
  rivid::StreamingQr other = one;
  for (auto _ : state) {
    other.merge(one);
  }
}

}  // namespace

BENCHMARK(streaming_qr)
    ->ArgName("columns")
    ->Arg(40)
    ->Arg(61)
    ->Arg(69)
    ->Arg(100)
    ->Iterations(15)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(joint_factorisation)
    ->ArgName("columns")
    ->Arg(40)
    ->Arg(61)
    ->Arg(100)
    ->Iterations(15)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(single_rows)
    ->ArgName("columns")
    ->Arg(61)
    ->Iterations(15)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(merge)->ArgName("columns")->Arg(61)->Unit(benchmark::kMicrosecond);
