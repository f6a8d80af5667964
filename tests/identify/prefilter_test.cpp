#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "identify/rows/whitened_rows.hpp"
#include "support/complaint.hpp"
#include "support/random_matrix.hpp"
#include "support/scara_study.hpp"

namespace rivid::detail {
namespace {

// x_t = a_1 x_{t−1} + a_2 x_{t−2} + e_t with e of deviation 1.
Vector autoregressive(double a_1, double a_2, Index size, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  Vector out = Vector::Zero(size);
  for (Index t = 2; t < size; ++t) {
    out[t] = a_1 * out[t - 1] + a_2 * out[t - 2] + normal(bits);
  }
  return out;
}

// Rows [V W Y] of one column, with W = 0, so that Y is the residual.
void send(RowSink& to, const Vector& Y, const std::vector<Index>& samples, Index block) {
  for (Index first = 0; first < Y.size(); first += block) {
    const Index count = std::min(block, Y.size() - first);
    const RowsTarget target = to.room(count).target;
    for (Index k = 0; k < count; ++k) {
      target.data[k] = target.data[k + target.ld] = 0.0;
      target.data[k + 2 * target.ld] = Y[first + k];
    }
    to.commit(std::span(samples).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count)));
  }
}

std::vector<Index> consecutive(Index size) {
  std::vector<Index> out(static_cast<std::size_t>(size));
  std::iota(out.begin(), out.end(), Index{7});
  return out;
}

StreamingQr lagged(const Vector& Y, const std::vector<Index>& samples, Index lags, Index block = 100) {
  StreamingQr out(lags);
  LaggedResidualSink sink(out, Vector::Zero(1), {});
  send(sink, Y, samples, block);
  return out;
}

TEST(Autoregression, FindsOrderAndCoefficients) {
  constexpr Index size = 20000;
  const Autoregression found =
      autoregression(lagged(autoregressive(1.2, -0.5, size, 1), consecutive(size), 12), 0);
  ASSERT_EQ(found.ar.size(), 2);
  // Standard deviation of both coefficients: sqrt((1 − a_2²) / size).
  const double sigma = std::sqrt(0.75 / size);
  EXPECT_NEAR(found.ar[0], 1.2, 4.0 * sigma);
  EXPECT_NEAR(found.ar[1], -0.5, 4.0 * sigma);
  EXPECT_NEAR(found.innovation, 1.0, 4.0 / std::sqrt(2.0 * size));
}

TEST(Autoregression, OfWhiteNoiseHasOrderNull) {
  const Autoregression found =
      autoregression(lagged(autoregressive(0.0, 0.0, 5000, 2), consecutive(5000), 12), 0);
  EXPECT_EQ(found.ar.size(), 0);
}

TEST(Autoregression, TakesTheOrderThatIsAskedFor) {
  const StreamingQr rows = lagged(autoregressive(1.2, -0.5, 5000, 3), consecutive(5000), 6);
  const Autoregression found = autoregression(rows, 6);
  ASSERT_EQ(found.ar.size(), 6);
  EXPECT_NEAR(found.ar[0], 1.2, 4.0 / std::sqrt(5000.0));
}

// The lagged rows of a series with a gap are those of its two parts.
TEST(LaggedResiduals, DoNotReachOverGaps) {
  const Vector Y = autoregressive(0.9, 0.0, 300, 4);
  std::vector<Index> samples = consecutive(300);
  for (std::size_t k = 140; k < samples.size(); ++k) {
    samples[k] += 5;
  }
  const StreamingQr whole = lagged(Y, samples, 4, 37);
  StreamingQr parts = lagged(Y.head(140), consecutive(140), 4);
  parts.merge(lagged(Y.tail(160), consecutive(160), 4));
  EXPECT_EQ(whole.rows(), 300 - 2 * 4);
  // Another order of the same rows.
  EXPECT_LT((whole.R().transpose() * whole.R() - parts.R().transpose() * parts.R()).norm(),
            1e-12 * parts.R().squaredNorm());
}

TEST(WhitenedSink, FiltersWithinStretches) {
  const Vector ar = Eigen::Vector3d(0.5, -0.3, 0.2);
  constexpr Index size = 1200;
  const Matrix x = test::random_matrix(size, 3, 5);
  std::vector<Index> samples = consecutive(size);
  const std::vector<std::size_t> gaps = {200, 202, 700};  // the second stretch is too short for a row
  for (const std::size_t gap : gaps) {
    for (std::size_t k = gap; k < samples.size(); ++k) {
      samples[k] += 2;
    }
  }
  for (const Index block : {1, 3, 100, 512}) {
    HeldRows held(size, 3);
    WhitenedSink sink(held, ar, 3);
    for (Index first = 0; first < size; first += block) {
      const Index count = std::min<Index>(block, size - first);
      const RowsTarget target = sink.room(count).target;
      for (Index c = 0; c < 3; ++c) {
        std::copy_n(x.col(c).data() + first, count, target.data + c * target.ld);
      }
      sink.commit(
          std::span(samples).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count)));
    }
    Index row = 0;
    for (Index t = 3; t < size; ++t) {
      const auto at = static_cast<std::size_t>(t);
      if (samples[at] - samples[at - 3] != 3) {
        continue;
      }
      ASSERT_LT(row, held.size());
      EXPECT_EQ(held.samples()[static_cast<std::size_t>(row)], samples[at]);
      const Eigen::RowVector3d expected =
          x.row(t) - 0.5 * x.row(t - 1) + 0.3 * x.row(t - 2) - 0.2 * x.row(t - 3);
      EXPECT_LT((held.rows().row(row) - expected).norm(), 1e-14 * 10.0) << "block " << block << " row " << t;
      ++row;
    }
    EXPECT_EQ(held.size(), row);
  }
}

struct PrefilteredIv : public ::testing::Test, public test::ScaraStudy {
  PrefilteredIv() {
    encoder_noise = 2e-5;
    method = iv();
    method.signal = {.rows = RowScheme::exact, .torque_held = true, .decimation = {20}};
    std::get<Iv>(method.method).prefilter = true;
  }
  Estimation method{.method = Iv{}};
};

TEST_F(PrefilteredIv, TellsItsNoiseModelsAndWhatItBeganWith) {
  const Log log = this->log(1.0, 1);
  const Identification found = identify(robot, log, method);
  ASSERT_EQ(found.status, Status::identified);
  ASSERT_TRUE(found.prefilter);
  ASSERT_EQ(found.prefilter->noise.size(), 2U);
  for (const NoiseModel& noise : found.prefilter->noise) {
    EXPECT_GT(noise.ar.size(), 0);
    EXPECT_GT(noise.innovation, 0.0);
  }
  Estimation plain = method;
  std::get<Iv>(plain.method).prefilter = false;
  const Identification before = identify(robot, log, plain);
  EXPECT_EQ(found.prefilter->chi, before.chi);
  for (Index i = 0; i < base.size(); ++i) {
    EXPECT_EQ(found.prefilter->sigma[i], before.parameters[static_cast<std::size_t>(i)].sigma);
  }
  // Both judge plain rows.
  EXPECT_EQ(found.fit.rows, before.fit.rows);
  EXPECT_GT(found.prefilter->rows, 10 * found.fit.rows);
}

TEST_F(PrefilteredIv, IsTheSameWhateverTheThreads) {
  const Log log = this->log(1.0, 2);
  std::get<Iv>(method.method).prefilter_order = 12;
  const Identification one = identify(robot, log, method);
  method.threads = 3;
  const Identification three = identify(robot, log, method);
  ASSERT_EQ(one.prefilter->noise[1].ar.size(), 12);
  EXPECT_EQ(one.chi, three.chi);
  EXPECT_EQ(one.C_chi, three.C_chi);
}

TEST_F(PrefilteredIv, RefusesThePapersRows) {
  const Log log = this->log(1.0, 1);
  method.signal.rows = RowScheme::paper;
  EXPECT_TRUE(test::says(test::complaint_of([&] { return identify(robot, log, method); }),
                         "prefilter works on exact rows: rows must be \"exact\""));
}

}  // namespace
}  // namespace rivid::detail
