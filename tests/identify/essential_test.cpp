#include "rivid/identify/essential.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "rivid/identify/identification.hpp"
#include "rivid/solve/inference.hpp"
#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

struct EssentialScara : public ::testing::Test, public test::ScaraStudy {
  EssentialScara() { encoder_noise = 2e-5; }

  [[nodiscard]] static SignalOptions exact() {
    return {.rows = RowScheme::exact, .torque_held = true, .decimation = {20}};
  }
  [[nodiscard]] static std::vector<std::string> names(const EssentialParameters& found) {
    std::vector<std::string> out;
    for (const EliminatedParameter& p : found.eliminated) {
      out.push_back(p.name);
    }
    return out;
  }
};

// What is left is the least-squares fit to the columns that are left, and F is what their loss says.
TEST_F(EssentialScara, AreThoseOfAFitToTheirColumns) {
  set("MY2", 0.0);
  const Log log = this->log(1.0, 3);
  const Identification found = identify(robot, log,
                                        {.method = Ols{},
                                         .signal = exact(),
                                         .covariance = {CovarianceKind::classical},
                                         .essential = Essential{}});
  ASSERT_TRUE(found.essential);
  const EssentialParameters& essential = found.essential->parameters;
  ASSERT_EQ(names(essential).front(), "MY2");

  const Rows rows = rivid::rows(robot, base, log, exact());
  const Matrix W = rows.W.dense();
  Vector Y(W.rows());
  Y << rows.Y[0], rows.Y[1];
  const auto loss = [&](const std::vector<Index>& kept, Vector& chi) {
    const Matrix columns = W(Eigen::all, kept);
    chi = columns.householderQr().solve(Y);
    return (Y - columns * chi).squaredNorm();
  };
  std::vector<Index> all;
  std::vector<Index> without;
  for (Index i = 0; i < base.size(); ++i) {
    all.push_back(i);
    if (i != index("MY2")) {
      without.push_back(i);
    }
  }
  Vector chi;
  const double full = loss(all, chi);
  const auto freedom = static_cast<double>(W.rows() - base.size());
  // The window of the decimation takes its share of the deviation, which is undone.
  const double factor = found.covariance.decimation_factor;
  const double F = factor * factor * (loss(without, chi) - full) / (full / freedom);
  constexpr double rounding = 1e-8;  // differences of losses by other factorisations
  EXPECT_NEAR(essential.eliminated.front().F, F, rounding * (1.0 + F));
  EXPECT_NEAR(essential.eliminated.front().p, f_tail(F, 1.0, freedom), rounding);
  loss(essential.kept, chi);
  EXPECT_LT((essential.chi(essential.kept) - chi).norm(), 1e-9 * chi.norm());
  // (18) for the columns that are left.
  const Matrix columns = W(Eigen::all, essential.kept);
  const Matrix C = full / freedom / (factor * factor) * (columns.transpose() * columns).inverse();
  EXPECT_LT((essential.C_chi(essential.kept, essential.kept) - C).norm(), 1e-8 * C.norm());
}

// MY2 = 0 and Fv2 = 0 go, in nearly all of 40 experiments; what is not zero and well seen stays in all of
// them.
TEST_F(EssentialScara, LoseWhatIsNotThere) {
  set("MY2", 0.0);
  set("Fv2", 0.0);
  constexpr int runs = 40;
  int lost = 0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Identification found =
        identify(robot, this->log(1.0, seed), {.method = Wls{}, .signal = exact(), .essential = Essential{}});
    ASSERT_TRUE(found.essential);
    const std::vector<std::string> gone = names(found.essential->parameters);
    lost += static_cast<int>(std::ranges::count(gone, "MY2") + std::ranges::count(gone, "Fv2"));
    for (const char* const name : {"ZZ1R", "Fc1", "ZZ2", "MX2", "Fc2"}) {
      EXPECT_EQ(std::ranges::count(gone, name), 0) << name << ", seed " << seed;
    }
    // What went is chance, one by one and all together.
    EXPECT_GE(found.essential->parameters.p, 0.05) << "seed " << seed;
    double F = 0.0;
    for (const EliminatedParameter& p : found.essential->parameters.eliminated) {
      EXPECT_GE(p.p, 0.05) << p.name << ", seed " << seed;
      F += p.F;
    }
    // Each step costs its own loss, all together their sum.
    const auto steps = static_cast<double>(found.essential->parameters.eliminated.size());
    EXPECT_NEAR(steps * found.essential->parameters.F, F, 1e-8 * (1.0 + F));
  }
  // 5 % of 80 removals are refused on average; 4 binomial deviations above that.
  EXPECT_GE(lost, 80 - 4 - 8);
}

TEST_F(EssentialScara, OfInstrumentsAreThoseOfLeastSquaresOnGoodRows) {
  set("MY2", 0.0);
  const Log log = this->log(1.0, 2);
  Estimation method = iv();
  method.signal = exact();
  method.essential = Essential{};
  const Identification by_iv = identify(robot, log, method);
  const Identification by_wls =
      identify(robot, log, {.method = Wls{}, .signal = exact(), .essential = Essential{}});
  ASSERT_TRUE(by_iv.essential && by_wls.essential);
  EXPECT_EQ(by_iv.essential->parameters.kept, by_wls.essential->parameters.kept);
  for (const Index i : by_iv.essential->parameters.kept) {
    // Both are consistent: they differ by less than the error bars.
    EXPECT_NEAR(by_iv.essential->parameters.chi[i], by_wls.essential->parameters.chi[i],
                std::sqrt(by_wls.C_chi(i, i)));
  }
}

// The information is so poor that everything would go.
TEST_F(EssentialScara, KeepTheInertiaOfEachJoint) {
  const Matrix root = 1e-6 * Matrix::Identity(8, 8);
  const Matrix C = 1e12 * Matrix::Identity(8, 8);
  const Matrix q = Matrix::Zero(10, 2);
  const EssentialParameters found = essential(robot, base, truth, C, root, 1000.0, std::span(&q, 1));
  const std::vector<std::string> gone = names(found);
  EXPECT_EQ(found.kept, (std::vector<Index>{index("ZZ1R"), index("ZZ2")}));
  EXPECT_EQ(gone.size(), 6U);
}

// The information knows little more than ZZ1R − 200 Fv1: without Fv1 the inertia would be negative.
TEST_F(EssentialScara, KeepWhatTheMassMatrixNeeds) {
  Matrix root = 1e-6 * Matrix::Identity(8, 8);
  root(index("ZZ1R"), index("ZZ1R")) = 1.0;
  root(index("ZZ1R"), index("Fv1")) = -200.0;
  const Matrix inverse = root.inverse();
  const Matrix C = inverse * inverse.transpose();
  const Matrix q = Matrix::Zero(10, 2);
  const EssentialParameters found = essential(robot, base, truth, C, root, 1000.0, std::span(&q, 1));
  EXPECT_EQ(found.held, std::vector<std::string>{"Fv1"});
  EXPECT_EQ(found.kept, (std::vector<Index>{index("ZZ1R"), index("Fv1"), index("ZZ2")}));
}

// Of C = (RᵀR)⁻¹ the columns that are left have (R_kᵀ R_k)⁻¹, less than what they have among all.
TEST_F(EssentialScara, HaveTheCovarianceOfTheirColumns) {
  const Index Fv1 = index("Fv1");
  const Index ZZ1R = index("ZZ1R");
  Matrix root = 1e3 * Matrix::Identity(8, 8);
  root(Fv1, Fv1) = 1.0;
  root(ZZ1R, Fv1) = 300.0;
  const Matrix inverse = root.inverse();
  const Matrix all = inverse * inverse.transpose();
  const Matrix q = Matrix::Zero(10, 2);
  const EssentialParameters found = essential(robot, base, truth, all, root, 1000.0, std::span(&q, 1));
  ASSERT_EQ(names(found), std::vector<std::string>{"Fv1"});
  const Matrix columns = root(Eigen::all, found.kept);
  Matrix C = Matrix::Zero(8, 8);
  C(found.kept, found.kept) = Matrix((columns.transpose() * columns).inverse());
  EXPECT_LT((found.C_chi - C).norm(), 1e-12 * C.norm());
}

// F = 3.5 of one is chance, p = 6 %; of two it is not, p = 3 %.
TEST_F(EssentialScara, GoAsFarAsTheirLossTogetherIsChance) {
  Matrix root = 1e6 * Matrix::Identity(8, 8);
  for (const char* const name : {"Fv1", "Fv2"}) {
    root(index(name), index(name)) = std::sqrt(3.5) / truth[index(name)];
  }
  const Matrix inverse = root.inverse();
  const Matrix all = inverse * inverse.transpose();
  const Matrix q = Matrix::Zero(10, 2);
  const EssentialParameters found = essential(robot, base, truth, all, root, 1000.0, std::span(&q, 1));
  ASSERT_EQ(found.eliminated.size(), 1U);
  EXPECT_NEAR(found.eliminated[0].F, 3.5, 1e-9);
}

TEST_F(EssentialScara, RefuseASignificanceThatIsNone) {
  const Log log = this->log(1.0, 1);
  EXPECT_EQ(test::complaint_of([&] {
              return identify(
                  robot, log,
                  {.method = Wls{}, .signal = exact(), .essential = Essential{.significance = 1.5}});
            }),
            "identify(IDIM-WLS): essential: significance is 1.5, must lie between 0 and 1");
}

}  // namespace
}  // namespace rivid
