#include "rivid/model/kinds.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

namespace rivid {
namespace {

constexpr std::array speeds = {-3.0, -0.7, -1e-3, 1e-3, 0.7, 3.0};

TEST(ParameterKinds, HaveASymbolAndAUnitOfTheirOwn) {
  std::set<std::string_view> symbols;
  for (const KindRow& row : kind_rows) {
    EXPECT_EQ(&about(row.kind), &row);
    EXPECT_FALSE(row.symbol.empty());
    EXPECT_TRUE(symbols.insert(row.symbol).second) << row.symbol;
    EXPECT_FALSE(row.unit.revolute.empty() || row.unit.prismatic.empty()) << row.symbol;
    EXPECT_EQ(unit(row.kind, JointType::prismatic), row.unit.prismatic);
  }
}

TEST(ParameterKinds, AreEachMultipliedWithSomethingElse) {
  std::set<std::tuple<Basis, Direction, bool>> kinds;
  for (const KindRow& row : kind_rows) {
    if (row.basis != Basis::body) {
      EXPECT_TRUE(kinds.insert({row.basis, row.direction, row.coupled}).second) << row.symbol;
    }
  }
  std::set<std::vector<double>> columns;
  for (const KindRow& row : kind_rows) {
    if (is_friction(row.kind) && !row.coupled) {
      std::vector<double> column;
      for (const double speed : speeds) {
        // Times the load of the joint, where it follows that.
        column.push_back((row.basis == Basis::load ? 3.0 : 1.0) * friction_entry(row.kind, speed));
      }
      EXPECT_NE(column, std::vector<double>(speeds.size(), 0.0)) << row.symbol;
      EXPECT_TRUE(columns.insert(column).second) << row.symbol << " has the column of another kind";
    }
  }
}

TEST(ParameterKinds, HaveTheFunctionOfTheirRole) {
  for (const BasisRow& row : basis_rows) {
    const double forward = friction_function(row.basis, 0.0, 1.0);
    const double backward = friction_function(row.basis, 0.0, -1.0);
    SCOPED_TRACE(static_cast<int>(row.basis));
    switch (row.role) {
      case Role::inertial:
      case Role::rotor:
        EXPECT_EQ(friction_function(row.basis, 2.0, 1.0), 0.0);
        break;
      case Role::viscous:
        EXPECT_EQ(forward, 0.0);
        EXPECT_EQ(backward, 0.0);
        break;
      case Role::dry:
        EXPECT_GT(forward, 0.0);
        EXPECT_LT(backward, 0.0);
        break;
      case Role::constant:
        EXPECT_EQ(forward, backward);
        break;
    }
    // Friction with a positive coefficient brakes.
    for (const double speed : speeds) {
      if (row.role == Role::viscous || row.role == Role::dry) {
        EXPECT_GE(speed * friction_function(row.basis, speed, sign(speed)), 0.0) << speed;
      }
    }
  }
}

TEST(ParameterKinds, ReadTheTorquesOfThePaper) {
  const auto entry = [](ParameterKind kind, double qd) { return friction_entry(kind, qd); };
  using enum ParameterKind;
  for (const double qd : {-2.0, 0.0, 1.5}) {
    const double sign_qd = qd > 0.0 ? 1.0 : qd < 0.0 ? -1.0 : 0.0;
    EXPECT_EQ(entry(Fv, qd), qd);
    EXPECT_EQ(entry(Fc, qd), sign_qd);
    EXPECT_EQ(entry(off, qd), 1.0);
    EXPECT_EQ(entry(Fv_plus, qd), std::max(qd, 0.0));
    EXPECT_EQ(entry(Fv_minus, qd), std::min(qd, 0.0));
    EXPECT_EQ(entry(Fc_plus, qd), std::max(sign_qd, 0.0));
    EXPECT_EQ(entry(Fc_minus, qd), std::min(sign_qd, 0.0));
    EXPECT_EQ(friction_entry(Fc, qd, 0.3), std::tanh(qd / 0.3));
  }
}

TEST(FrictionLaws, HaveANameAndParametersOfJointsThatDiffer) {
  std::set<std::string_view> names;
  for (const FrictionRow& law : friction_rows) {
    EXPECT_TRUE(names.insert(law.name).second) << law.name;
    EXPECT_EQ(name(law.law), law.name);
    std::set<ParameterKind> kinds;
    for (const ParameterKind kind : law.parameters) {
      EXPECT_TRUE(kinds.insert(kind).second) << law.name << ", " << symbol(kind);
      EXPECT_TRUE(is_friction(kind) && !about(kind).coupled) << law.name << ", " << symbol(kind);
    }
  }
}

TEST(FrictionLaws, StandOnTheirPage) {
  std::ifstream in(RIVID_DOCS "/experiment.md");
  std::ostringstream page;
  page << in.rdbuf();
  const std::string laws = page.str().substr(page.str().find("### Friction laws"));
  for (const FrictionRow& law : friction_rows) {
    std::string symbols;
    for (const ParameterKind kind : law.parameters) {
      symbols.append(symbols.empty() ? "" : " ").append(symbol(kind));
    }
    const std::string row = laws.substr(laws.find("| `\"" + std::string(law.name) + "\"` |"));
    const std::string line = row.substr(0, row.find('\n'));
    EXPECT_TRUE(line.ends_with("| " + (symbols.empty() ? "–" : symbols) + " |")) << law.name << ": " << line;
  }
}

}  // namespace
}  // namespace rivid
