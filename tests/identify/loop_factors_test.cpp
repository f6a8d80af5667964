// Instrumental variables from logs that are elsewhere, against the same from the logs.

#include "rivid/identify/loop_factors.hpp"

#include <gtest/gtest.h>

#include "rivid/experiment/factors_file.hpp"
#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

class LoopsElsewhere : public ::testing::Test, public test::ScaraStudy {
 protected:
  // Exact rows and signs of the simulated loops; a control law whose gains follow the inertias.
  [[nodiscard]] Estimation estimation() const {
    Estimation out = iv();
    out.signal = {.torque_held = true, .decimation = {10}};
    return out;
  }

  [[nodiscard]] std::vector<Log> logs(int count) const {
    std::vector<Log> out;
    for (int k = 0; k < count; ++k) {
      out.push_back(log(1.0 + 0.3 * k, static_cast<std::uint64_t>(k + 1)));
    }
    return out;
  }

  [[nodiscard]] LogFactors factors_of(std::span<const Log> from, const Estimation& with) const {
    LogFactors out = log_factors(robot, from.front(), with.signal, blocks);
    for (const Log& log : from.subspan(1)) {
      merge(out, log_factors(robot, log, with.signal, blocks));
    }
    return out;
  }

  // Asks log by log, and takes each answer through its bytes.
  [[nodiscard]] LoopAsk ask(std::span<const Log> from, const Estimation& with) const {
    return [this, from, with](const LoopRequest& request) {
      const LoopRequest there = decoded_loop_request(encoded(request), "request");
      LoopFactors out = loop_factors(robot, from.front(), with, there, blocks);
      for (const Log& log : from.subspan(1)) {
        merge(out, decoded_loop_factors(encoded(loop_factors(robot, log, with, there, blocks)), "answer"));
      }
      return out;
    };
  }

  [[nodiscard]] Identification elsewhere(std::span<const Log> from, const Estimation& with) const {
    return identify(robot, factors_of(from, with), with, ask(from, with));
  }

  // Of the loops with the true parameters.
  [[nodiscard]] LoopRequest rows_request(bool simulated_signs) const {
    return {.pass = LoopPass::rows,
            .chi_st = base.to_standard(truth),
            .J = J,
            .simulated_signs = simulated_signs};
  }

  int blocks = 10;
};

// Rows are summed in another order: the rounding of the estimate grows with its condition, and passes through
// the iteration.
constexpr double rounding = 1e-7;

void expect_same_estimate(const Identification& found, const Identification& together) {
  ASSERT_EQ(together.status, Status::identified);
  ASSERT_EQ(found.status, Status::identified);
  ASSERT_EQ(found.iv->iterations.size(), together.iv->iterations.size());
  for (Index i = 0; i < together.chi.size(); ++i) {
    EXPECT_NEAR(found.chi[i], together.chi[i],
                rounding * together.parameters[static_cast<std::size_t>(i)].sigma);
  }
  const IvIteration& last = found.iv->iterations.back();
  const IvIteration& wanted = together.iv->iterations.back();
  EXPECT_TRUE(last.J.isApprox(wanted.J, rounding));
  EXPECT_TRUE(last.to_measured.q.isApprox(wanted.to_measured.q, rounding));
  EXPECT_TRUE(last.to_reference.qdd.isApprox(wanted.to_reference.qdd, rounding));
  EXPECT_EQ(last.effort.steps, wanted.effort.steps);
  EXPECT_TRUE(found.iv->first_stage_F.isApprox(together.iv->first_stage_F, rounding));
  EXPECT_TRUE(found.iv->loop.control_error.isApprox(together.iv->loop.control_error, rounding));
  EXPECT_TRUE(found.iv->loop.tracking_ratio.isApprox(together.iv->loop.tracking_ratio, rounding));
  EXPECT_NEAR(found.fit.relative_error, together.fit.relative_error, rounding);
}

TEST_F(LoopsElsewhere, GiveTheEstimateOfTheLogs) {
  const std::vector<Log> all = logs(3);
  expect_same_estimate(elsewhere(all, estimation()), identify(robot, all, estimation()));
}

TEST_F(LoopsElsewhere, GiveItWithSimulatedSignsAsWell) {
  const std::vector<Log> all = logs(2);
  Estimation with = estimation();
  std::get<Iv>(with.method).signs = Iv::Signs::simulated;
  expect_same_estimate(elsewhere(all, with), identify(robot, all, with));
}

TEST_F(LoopsElsewhere, AreAskedAgainWhereTheSignsOfTheFirstLoopTakeOver) {
  const std::vector<Log> all = logs(2);
  Estimation with = estimation();
  with.signal = unfiltered();  // signs of raw velocities are noise
  const Identification together = identify(robot, all, with);
  expect_same_estimate(elsewhere(all, with), together);
}

TEST_F(LoopsElsewhere, ClassicalDeviationsAreThoseOfTheLogs) {
  const std::vector<Log> all = logs(2);
  Estimation with = estimation();
  with.covariance.kind = CovarianceKind::classical;
  EXPECT_TRUE(elsewhere(all, with).C_chi.isApprox(identify(robot, all, with).C_chi, rounding));
}

TEST_F(LoopsElsewhere, BlocksHaveEachRowOnce) {
  const Log one = log(1.0, 1);
  for (const bool signs : {false, true}) {
    for (const int count : {1, 4, 10}) {
      const LoopFactors found = loop_factors(robot, one, estimation(), rows_request(signs), count);
      ASSERT_TRUE(found.failure.empty()) << found.failure;
      ASSERT_EQ(std::ssize(found.blocks), count);
      std::vector<InstrumentalGroup> together = found.blocks.front();
      for (std::size_t g = 1; g < found.blocks.size(); ++g) {
        for (std::size_t j = 0; j < together.size(); ++j) {
          together[j].qr.merge(found.blocks[g][j].qr);
          EXPECT_LT(found.blocks[g][j].qr.rows(), 2 * found.groups[j].qr.rows() / count);
        }
      }
      for (std::size_t j = 0; j < together.size(); ++j) {
        EXPECT_EQ(together[j].qr.rows(), found.groups[j].qr.rows());
      }
      const std::vector<double> ones(together.size(), 1.0);
      const Vector chi = instrumental_variables(together, base.size(), ones).chi;
      EXPECT_TRUE(chi.isApprox(instrumental_variables(found.groups, base.size(), ones).chi, rounding));
    }
  }
}

TEST_F(LoopsElsewhere, DeviationsComeFromBlocks) {
  const std::vector<Log> all = logs(3);
  for (const int each : {10, 4}) {
    blocks = each;
    const Identification found = elsewhere(all, estimation());
    EXPECT_EQ(found.covariance.kind, CovarianceKind::blocks);
    EXPECT_EQ(found.covariance.blocks, 10);
  }
}

TEST_F(LoopsElsewhere, FailuresAreThoseOfTheLogs) {
  const std::vector<Log> all = logs(2);
  Estimation with = estimation();
  std::get<Iv>(with.method).simulation.max_steps = 100;
  const Identification found = elsewhere(all, with);
  const Identification together = identify(robot, all, with);
  EXPECT_EQ(found.status, Status::gave_up);
  EXPECT_EQ(found.reasons, together.reasons);
}

TEST_F(LoopsElsewhere, RefuseWhatNeedsSamples) {
  const std::vector<Log> all = logs(1);
  const auto refusal = [&](const Estimation& with) {
    return test::complaint_of([&] { return elsewhere(all, with); });
  };
  Estimation robust = estimation();
  robust.robust = Robust{};
  EXPECT_NE(refusal(robust).find("robust estimation weights single rows"), std::string::npos);
  Estimation didim = estimation();
  std::get<Iv>(didim.method).compares = Iv::Compares::torques;
  EXPECT_NE(refusal(didim).find("DIDIM needs all samples"), std::string::npos);
  Estimation transient = estimation();
  std::get<Iv>(transient.method).transient = 1.0;
  EXPECT_NE(refusal(transient).find("transient"), std::string::npos);
  Estimation prefilter = estimation();
  std::get<Iv>(prefilter.method).prefilter = true;
  EXPECT_NE(refusal(prefilter).find("prefilter"), std::string::npos);
  EXPECT_NE(refusal({.method = Wls{}, .signal = estimation().signal}).find("simulates no loops"),
            std::string::npos);
}

TEST_F(LoopsElsewhere, AnswersToDifferentRequestsAreNotMerged) {
  const std::vector<Log> all = logs(1);
  const LoopRequest rows = rows_request(true);
  LoopRequest others = rows;
  others.simulated_signs = false;
  const auto answer = [&](const LoopRequest& request) {
    return loop_factors(robot, all[0], estimation(), request);
  };
  LoopFactors found = answer(rows);
  ASSERT_TRUE(found.failure.empty()) << found.failure;
  EXPECT_NE(test::complaint_of([&] {
              merge(found, answer(others));
              return 0;
            }).find("requests"),
            std::string::npos);
  LoopRequest foreign = rows;
  foreign.J = Vector::Ones(3);
  EXPECT_NE(test::complaint_of([&] { return answer(foreign); }).find("not of robot"), std::string::npos);
}

TEST_F(LoopsElsewhere, DamagedAnswersAreRefused) {
  const std::vector<Log> all = logs(1);
  const std::string good = encoded(loop_factors(robot, all[0], estimation(), {}));
  EXPECT_EQ(encoded(decoded_loop_factors(good, "answer")), good);
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    EXPECT_NE(test::complaint_of([&] { return decoded_loop_factors(bad, "answer"); }), "") << at;
    EXPECT_NE(test::complaint_of([&] { return decoded_loop_factors(good.substr(0, at), "answer"); }), "")
        << at;
  }
  EXPECT_NE(test::complaint_of([&] { return decoded_loop_request(good, "request"); }), "");
}

}  // namespace
}  // namespace rivid
