// One call of a controller's inverse dynamics, τ = M q̈ + N, against KDL's recursive Newton-Euler and (where
// it was found) Pinocchio's.

#include "rivid/simulate/inverse_dynamics.hpp"

#include <benchmark/benchmark.h>

#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <string>

#include "bodies.hpp"
#include "rivid/model/kdl.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "robots.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;
using namespace rivid::benchmarks;

constexpr Index samples = 512;
constexpr int repeats = 101;

class Kdl {
 public:
  explicit Kdl(const Robot& robot)
      : chain_(kdl_chain(robot)),
        solver_(chain_,
                KDL::Vector(robot.chain.gravity.x(), robot.chain.gravity.y(), robot.chain.gravity.z())),
        q_(static_cast<unsigned>(robot.size())),
        qd_(q_),
        qdd_(q_),
        tau_(q_),
        no_forces_(chain_.getNrOfSegments()) {}

  const double* operator()(const Motion& in, Index k) {
    for (unsigned j = 0; j < q_.rows(); ++j) {
      q_(j) = in.q(j, k);
      qd_(j) = in.qd(j, k);
      qdd_(j) = in.qdd(j, k);
    }
    solver_.CartToJnt(q_, qd_, qdd_, no_forces_, tau_);
    return tau_.data.data();
  }

 private:
  KDL::Chain chain_;
  KDL::ChainIdSolver_RNE solver_;
  KDL::JntArray q_, qd_, qdd_, tau_;
  KDL::Wrenches no_forces_;
};

void inverse_dynamics(benchmark::State& state, const Robot& robot) {
  const DynamicModel model(robot, robot.chi_st());
  const Motion in = random_series(43, robot.size(), samples, 5.0);
  InverseDynamics one(model);
  Kdl kdl(robot);
  Matrix tau(robot.size(), samples);
  Matrix mass(robot.size(), robot.size());
  const auto ours = [&] {
    for (Index k = 0; k < samples; ++k) {
      one.torque(in.q.col(k), in.qd.col(k), in.qdd.col(k), tau.col(k));
    }
    benchmark::ClobberMemory();
  };
  const auto gravity = [&] {
    for (Index k = 0; k < samples; ++k) {
      one.gravity(in.q.col(k), tau.col(k));
    }
    benchmark::ClobberMemory();
  };
  const auto mass_matrix = [&] {
    for (Index k = 0; k < samples; ++k) {
      one.M(in.q.col(k), mass);
      benchmark::ClobberMemory();
    }
  };
  const auto of_kdl = [&] {
    for (Index k = 0; k < samples; ++k) {
      benchmark::DoNotOptimize(kdl(in, k));
    }
  };
#if defined(RIVID_WITH_PINOCCHIO)
  PinocchioAba pinocchio = pinocchio_of(robot, model);
  const std::function<void()> of_pinocchio = [&] {
    for (Index k = 0; k < samples; ++k) {
      benchmark::DoNotOptimize(
          pinocchio.torques(in.q.col(k).data(), in.qd.col(k).data(), in.qdd.col(k).data()));
    }
  };
#else
  const std::function<void()> of_pinocchio = [] {};
#endif
  const auto times = turns<5>(repeats, {ours, of_kdl, of_pinocchio, gravity, mass_matrix}, Clock::processor);
  for (auto _ : state) {
    ours();
  }
  const auto ns = [&](std::size_t i) { return 1e9 * median(times[i]) / samples; };
  state.counters["ns"] = ns(0);
  state.counters["gravity_ns"] = ns(3);
  state.counters["M_ns"] = ns(4);
  state.counters["kdl_ratio"] = ns(1) / ns(0);
  double disagreement = 0.0;
  for (Index k = 0; k < samples; ++k) {
    const Vector found = tau.col(k);
    const auto compare = [&](const double* theirs) {
      disagreement =
          std::max(disagreement, (Vector::Map(theirs, robot.size()) - found).cwiseAbs().maxCoeff() /
                                     found.cwiseAbs().maxCoeff());
    };
    compare(kdl(in, k));
#if defined(RIVID_WITH_PINOCCHIO)
    compare(pinocchio.torques(in.q.col(k).data(), in.qd.col(k).data(), in.qdd.col(k).data()));
#endif
  }
  state.counters["disagreement"] = disagreement;
#if defined(RIVID_WITH_PINOCCHIO)
  state.counters["pinocchio_ratio"] = ns(2) / ns(0);
#endif
}

const Robot the_tx40 = with_bodies(tx40());
const Robot the_panda = with_bodies(panda());
const Robot the_oblique = with_bodies(oblique());
const Robot the_snake = with_bodies(snake());

const int registered = [] {
  struct Named {
    const char* name;
    const Robot* robot;
  };
  for (const Named& r : {Named{"tx40_6", &the_tx40}, Named{"panda_7", &the_panda},
                         Named{"oblique_7", &the_oblique}, Named{"snake_30", &the_snake}}) {
    benchmark::RegisterBenchmark(
        r.name, [robot = r.robot](benchmark::State& state) { inverse_dynamics(state, *robot); });
  }
  return 0;
}();

}  // namespace
