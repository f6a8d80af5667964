#include "identify/rows/row_source.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "identify/rows/factors.hpp"
#include "identify/rows/kept_rows.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/signal/filter.hpp"
#include "support/random_matrix.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Two joints that swing, at 200 Hz, with torques of no meaning.
Log swinging_log(Index samples) {
  Log log;
  log.source = "swing.csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
  log.q.resize(samples, 2);
  log.q.col(0) = (2.0 * log.t.array()).sin() + 0.3 * (7.1 * log.t.array()).cos();
  log.q.col(1) = (3.0 * log.t.array()).cos() + 0.2 * (9.3 * log.t.array()).sin();
  log.tau = 10.0 * log.q + test::random_matrix(samples, 2, 11);
  return log;
}

std::vector<SignalOptions> ways() {
  return {{.rows = RowScheme::paper, .trim = {{0, 0}}},
          {.rows = RowScheme::paper, .cutoff_hz = 20.0, .torque_cutoff_hz = 30.0},
          {.rows = RowScheme::paper, .cutoff_hz = 20.0, .velocity_threshold = {0.8, 0.1}},
          {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {20}},
          {.rows = RowScheme::paper,
           .cutoff_hz = 20.0,
           .decimation = {5, 1, 4},
           .velocity_threshold = {0.0, 0.5}},
          {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {100}, .trim = {{3, 0}}},
          {.trim = {{0, 0}}},
          {.torque_held = true, .cutoff_hz = 20.0, .decimation = {4, 5}},
          {.cutoff_hz = 20.0, .velocity_threshold = {0.8, 0.1}},
          {.cutoff_hz = 20.0, .convention = Convention::matlab},
          {.cutoff_hz = 20.0,
           .decimation = {10},
           .velocity_threshold = {0.3, 0.0},
           .convention = Convention::matlab}};
}

TEST(Factors, AreThoseOfTheRows) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  // Lengths that end within a piece, within a segment and at their borders.
  for (const Index samples : {1100, 4001, 5120, 5133}) {
    const Log log = swinging_log(samples);
    for (const SignalOptions& options : ways()) {
      const Rows held = rows(robot, base, log, options);
      const RowFactors found = factors(robot, base, log, options);
      EXPECT_EQ(found.left_out, held.left_out);
      for (std::size_t j = 0; j < 2; ++j) {
        const StreamingQr& qr = found.groups[j].qr;
        EXPECT_EQ(found.groups[j].columns, held.W.joints[j].columns);
        ASSERT_EQ(qr.rows(), held.Y[j].size());
        const Matrix& W = held.W.joints[j].W;
        const Matrix gram = W.transpose() * W;
        // Sums of products in another order.
        EXPECT_LT((qr.R().transpose() * qr.R() - gram).norm(), 1e-12 * gram.norm());
        EXPECT_LT((qr.R().transpose() * qr.qty() - W.transpose() * held.Y[j]).norm(), 1e-12 * gram.norm());
        EXPECT_NEAR(qr.y_norm(), held.Y[j].norm(), 1e-12 * held.Y[j].norm());
      }
    }
  }
}

TEST(Factors, AreTheSameWhateverTheThreads) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const Log log = swinging_log(7013);
  for (const SignalOptions& options : ways()) {
    const RowFactors one = factors(robot, base, log, options);
    for (const int threads : {2, 3, 7}) {
      const RowFactors several = factors(robot, base, log, options, threads);
      EXPECT_EQ(several.left_out, one.left_out);
      for (std::size_t j = 0; j < 2; ++j) {
        EXPECT_EQ(several.groups[j].qr.R(), one.groups[j].qr.R());
        EXPECT_EQ(several.groups[j].qr.qty(), one.groups[j].qr.qty());
        EXPECT_EQ(several.groups[j].qr.unreachable_norm(), one.groups[j].qr.unreachable_norm());
      }
    }
  }
  EXPECT_THROW((void)factors(robot, base, log, {}, 0), InputError);
}

// Long logs are shared out in stretches.
TEST(Factors, OfALongLogAreTheSameWhateverTheThreadsAndThoseOfItsRows) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const Log log = swinging_log(50'021);
  const RowFactors one = factors(robot, base, log, {.cutoff_hz = 20.0});
  for (const int threads : {2, 3, 7}) {
    std::vector<double> fractions;
    const RowFactors several = factors(robot, base, log, {.cutoff_hz = 20.0}, threads,
                                       [&](double fraction) { fractions.push_back(fraction); });
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_EQ(several.groups[j].qr.R(), one.groups[j].qr.R());
      EXPECT_EQ(several.groups[j].qr.qty(), one.groups[j].qr.qty());
      EXPECT_EQ(several.groups[j].qr.unreachable_norm(), one.groups[j].qr.unreachable_norm());
      EXPECT_EQ(several.groups[j].qr.column_sums(), one.groups[j].qr.column_sums());
    }
    EXPECT_TRUE(std::ranges::is_sorted(fractions));
    EXPECT_EQ(fractions.back(), 1.0);
  }
  const Rows all = rows(robot, base, log, {.cutoff_hz = 20.0});
  for (std::size_t j = 0; j < 2; ++j) {
    StreamingQr whole(static_cast<Index>(one.groups[j].columns.size()));
    whole.add(all.W.joints[j].W, all.Y[j]);
    const Matrix R = whole.R();
    EXPECT_EQ(one.groups[j].qr.rows(), whole.rows());
    EXPECT_LT((one.groups[j].qr.R().cwiseAbs() - R.cwiseAbs()).norm(), 1e-11 * R.norm());
  }
}

TEST(Factors, TellHowFarTheyAre) {
  const Robot robot = test::scara();
  std::vector<double> fractions;
  (void)factors(robot, base_parameters(robot), swinging_log(5000), {}, 1,
                [&](double fraction) { fractions.push_back(fraction); });
  EXPECT_GT(fractions.size(), 5U);
  EXPECT_TRUE(std::ranges::is_sorted(fractions));
  EXPECT_EQ(fractions.back(), 1.0);
}

// Kilobytes at the worst moment of this process so far.
long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(Factors, TakeMemoryThatDoesNotGrowWithTheLog) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep what is given back";
#endif
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  constexpr Index samples = 2'000'000;
  Log log = swinging_log(1000);
  log.q.conservativeResize(samples, 2);
  log.tau.conservativeResize(samples, 2);
  log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
  for (Index k = 1000; k < samples; k += 1000) {
    log.q.middleRows(k, 1000) = log.q.topRows(1000);
    log.tau.middleRows(k, 1000) = log.tau.topRows(1000);
  }
  const auto positions = static_cast<long>(samples * 2 * sizeof(double) / 1024);
  for (const RowScheme scheme : {RowScheme::paper, RowScheme::exact}) {
    // Exact rows make torques of their own, tell for each sample and joint whether it moves, and look at one
    // joint's velocity and its noise at a time.
    const long series = scheme == RowScheme::paper ? positions : 3 * positions + positions / 4;
    for (const std::vector<int>& decimation : {std::vector<int>{}, {20}}) {
      const SignalOptions options{.rows = scheme, .decimation = decimation};
      const long before = peak_memory();
      (void)factors(robot, base, log, options);
      // W of the two joints would take 200 MB.
      constexpr long noise = 4096;  // pages that the C library takes on its own account
      EXPECT_LE(peak_memory() - before, series + 2048 + noise);
    }
  }
}

// Instruments in front of W: here the measured motion again, so V must be W, row by row.
TEST(RowSource, SendsOtherMotionsInTheSameRows) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const Log log = swinging_log(5133);
  for (SignalOptions options : ways()) {
    options.cutoff_hz = 0.0;
    for (const int threads : {1, 2}) {
      detail::ThreadTeam team(threads);
      detail::RowSource source(robot, base, log, options, team);
      std::vector<detail::HeldRows> held;
      held.reserve(2);
      std::vector<detail::RowSink*> sinks;
      for (std::size_t j = 0; j < 2; ++j) {
        sinks.push_back(
            &held.emplace_back(source.rows(), 2 * static_cast<Index>(source.columns(j).size()) + 1));
      }
      const std::vector<Motion> others = {options.exact_rows() ? detail::averaged_motion(log.q, log.f_m)
                                                               : differentiate(log.q, log.f_m)};
      source.send(sinks, others);
      const Rows expected = rows(robot, base, log, options);
      for (std::size_t j = 0; j < 2; ++j) {
        const auto b = static_cast<Index>(source.columns(j).size());
        EXPECT_EQ(held[j].rows().leftCols(b), expected.W.joints[j].W);
        EXPECT_EQ(held[j].rows().middleCols(b, b), expected.W.joints[j].W);
        EXPECT_EQ(held[j].rows().col(2 * b), expected.Y[j]);
        EXPECT_EQ(held[j].samples(), expected.samples[j]);
      }
    }
  }
}

// Rows of a joint that were sent, and the sinks that hold them.
struct Sent {
  Sent(const detail::RowSource& source, std::size_t others)
      : sinks(source.joints(), [&](std::size_t j) {
          return detail::HeldRows(source.rows(),
                                  static_cast<Index>((others + 1) * source.columns(j).size()) + 1);
        }) {}

  detail::JointSinks<detail::HeldRows> sinks;
};

void expect_same_rows(const Sent& a, const Sent& b) {
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_GT(a.sinks[j].size(), 0);
    EXPECT_EQ(a.sinks[j].rows(), b.sinks[j].rows());
    EXPECT_EQ(a.sinks[j].samples(), b.sinks[j].samples());
  }
}

// Of friction that follows the load too, whose columns are made of whole rows.
TEST(KeptRows, AreThoseOfRowsThatAreMadeAnew) {
  Robot robot = test::scara();
  for (const Friction friction : {Friction::symmetric, Friction::load}) {
    robot.joints[0].friction = friction;
    BaseParameters base = base_parameters(robot);
    base = at_load(base, Vector::LinSpaced(base.size(), 0.5, 2.0), Vector::Constant(2, 0.1));
    const Log log = swinging_log(5133);
    const std::vector<Motion> V = {differentiate(log.q + test::random_matrix(5133, 2, 3), log.f_m),
                                   differentiate(log.q.rowwise().reverse(), log.f_m)};
    for (const SignalOptions& options : ways()) {
      for (const int threads : {1, 2}) {
        detail::ThreadTeam team(threads);
        detail::RowSource source(robot, base, log, options, team);
        detail::KeptRows kept(robot, base, log, options, team);
        for (const std::size_t others : {0U, 1U, 2U, 0U}) {
          const std::span<const Motion> motions = std::span(V).first(others);
          const Sent expected(source, others);
          source.send(expected.sinks.sinks(), motions);
          const Sent found(source, others);
          kept.send(found.sinks.sinks(), motions);
          expect_same_rows(found, expected);
        }
      }
    }
  }
}

TEST(KeptRows, TakeNoMoreMemoryThanTheirBudget) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const std::vector<Log> logs(3, swinging_log(500'000));
  detail::ThreadTeam alone(1);
  const auto bytes_of = [&](const std::vector<int>& decimation) {
    const std::vector<SignalOptions> signals(3, {.decimation = decimation});
    std::vector<std::unique_ptr<detail::KeptRows>> kept;
    (void)detail::all_factors(robot, base, logs, signals, alone, {}, &kept);
    std::vector<std::size_t> out;
    for (const auto& log : kept) {
      out.push_back(log ? log->bytes() : 0);
    }
    return out;
  };
  EXPECT_EQ(bytes_of({}), std::vector<std::size_t>(3, 0)) << "rows that are not decimated are not kept";
  const std::vector<std::size_t> few = bytes_of({100});
  EXPECT_GT(*std::ranges::min_element(few), 0U);
  const std::vector<std::size_t> many = bytes_of({4});
  EXPECT_GT(many[0], detail::KeptRows::budget / 3);
  EXPECT_EQ(many[2], 0U);
  EXPECT_LE(many[0] + many[1] + many[2], detail::KeptRows::budget);
}

TEST(RowSource, RefusesAMotionOfOtherSamples) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const Log log = swinging_log(2000);
  detail::ThreadTeam alone(1);
  const SignalOptions options;
  detail::RowSource source(robot, base, log, options, alone);
  const std::vector<Motion> others = {differentiate(log.q.topRows(1999), log.f_m)};
  EXPECT_THROW(source.send({}, others), InputError);
}

TEST(ThreadTeam, DoesAllPiecesAndThrowsWhatTheyThrow) {
  for (const int size : {1, 2, 5}) {
    detail::ThreadTeam team(size);
    std::vector<int> counts(static_cast<std::size_t>(size), 0);
    for (int round = 0; round < 1000; ++round) {
      team.run([&](int member) { ++counts[static_cast<std::size_t>(member)]; });
    }
    EXPECT_EQ(counts, std::vector<int>(static_cast<std::size_t>(size), 1000));
    const auto fail = [&](int member) {
      if (member == size - 1) {
        throw InputError("no");
      }
    };
    EXPECT_THROW(team.run(fail), InputError);
    EXPECT_NO_THROW(team.run([](int) {}));
  }
}

}  // namespace
}  // namespace rivid
