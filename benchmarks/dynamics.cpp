// Direct dynamics, q̈ = M⁻¹ (τ − N): one sample at a time and packs of samples by each instruction set,
// against the articulated-body algorithm of Pinocchio (where it was found), and KDL's mass matrix and direct
// dynamics.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <random>
#include <string>
#include <vector>

#include "bodies.hpp"
#include "rivid/model/kdl.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "robots.hpp"

namespace {

using namespace rivid;
using namespace rivid::benchmarks;

constexpr Index samples = 512;

struct Inputs {
  Matrix q, qd, tau;  // (n × samples)
};

Inputs random_inputs(Index joints) {
  const Motion series = random_series(42, joints, samples, 20.0);
  return {series.q, series.qd, series.qdd};
}

// Seconds of several runs, each taken after one of the others, so that all meet the same disturbances: their
// medians.
template <std::size_t N>
std::array<double, N> medians(const std::array<std::function<void()>, N>& runs) {
  constexpr int repeats = 101;
  std::array<std::vector<double>, N> seconds;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < N; ++i) {
      const auto start = std::chrono::steady_clock::now();
      runs[i]();
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      seconds[i].push_back(taken.count());
    }
  }
  std::array<double, N> out;
  for (std::size_t i = 0; i < N; ++i) {
    std::ranges::nth_element(seconds[i], seconds[i].begin() + repeats / 2);
    out[i] = seconds[i][repeats / 2];
  }
  return out;
}

class Kdl {
 public:
  Kdl(const Robot& robot, const Inputs& in)
      : in_(in),
        chain_(kdl_chain(robot)),
        gravity_(robot.chain.gravity.x(), robot.chain.gravity.y(), robot.chain.gravity.z()),
        mass_(chain_, gravity_),
        direct_(chain_, gravity_),
        q_(static_cast<unsigned>(robot.size())),
        qd_(q_),
        tau_(q_),
        qdd_(q_),
        M_(static_cast<int>(q_.rows())),
        no_forces_(chain_.getNrOfSegments()) {}

  void mass_matrix() {
    for (Index k = 0; k < samples; ++k) {
      load(k);
      mass_.JntToMass(q_, M_);
      benchmark::DoNotOptimize(M_.data.data());
    }
  }

  void direct_dynamics() {
    for (Index k = 0; k < samples; ++k) {
      load(k);
      direct_.CartToJnt(q_, qd_, tau_, no_forces_, qdd_);
      benchmark::DoNotOptimize(qdd_.data.data());
    }
  }

 private:
  void load(Index k) {
    for (unsigned j = 0; j < q_.rows(); ++j) {
      q_(j) = in_.q(j, k);
      qd_(j) = in_.qd(j, k);
      tau_(j) = in_.tau(j, k);
    }
  }

  const Inputs& in_;
  KDL::Chain chain_;
  KDL::Vector gravity_;
  KDL::ChainDynParam mass_;
  KDL::ChainFdSolver_RNE direct_;
  KDL::JntArray q_, qd_, tau_, qdd_;
  KDL::JntSpaceInertiaMatrix M_;
  KDL::Wrenches no_forces_;
};

enum class How { one_sample, baseline, avx2, avx512 };

void dynamics(benchmark::State& state, const Robot& robot, How how) {
  const DynamicModel model(robot, robot.chi_st());
  const Inputs in = random_inputs(robot.size());
  const auto n = static_cast<std::size_t>(robot.size());
  Dynamics<double> one(model);
  Matrix qdd(robot.size(), samples);
  const Simd simd = how == How::avx512 ? Simd::avx512 : how == How::avx2 ? Simd::avx2 : Simd::baseline;
  if (!supported(simd)) {
    state.SkipWithError("this machine has not that instruction set");
    return;
  }
  DynamicsBatch batch(model, simd);
  // Batches find a joint's samples beside each other.
  const Matrix q = in.q.transpose();
  const Matrix qd = in.qd.transpose();
  const Matrix tau = in.tau.transpose();
  Matrix by_joint(samples, robot.size());
  const auto ours = [&] {
    if (how != How::one_sample) {
      benchmark::DoNotOptimize(batch.accelerations(q, qd, tau, by_joint));
      benchmark::ClobberMemory();
      return;
    }
    for (Index k = 0; k < samples; ++k) {
      if (one.set_state({in.q.col(k).data(), n}, {in.qd.col(k).data(), n})) {
        qdd.col(k) = in.tau.col(k) - Vector::Map(one.N().data(), robot.size());
        one.solve({qdd.col(k).data(), n});
      }
    }
    benchmark::ClobberMemory();
  };
  Kdl kdl(robot, in);
  [[maybe_unused]] double disagreement = 0.0;
#if defined(RIVID_WITH_PINOCCHIO)
  PinocchioAba pinocchio = pinocchio_of(robot, model);
  const std::function<void()> theirs = [&] {
    for (Index k = 0; k < samples; ++k) {
      benchmark::DoNotOptimize(pinocchio(in.q.col(k).data(), in.qd.col(k).data(), in.tau.col(k).data()));
    }
  };
  ours();
  if (how != How::one_sample) {
    qdd = by_joint.transpose();
  }
  for (Index k = 0; k < samples; ++k) {
    const double* const found = pinocchio(in.q.col(k).data(), in.qd.col(k).data(), in.tau.col(k).data());
    const Vector difference = Vector::Map(found, robot.size()) - qdd.col(k);
    disagreement =
        std::max(disagreement, difference.cwiseAbs().maxCoeff() / qdd.col(k).cwiseAbs().maxCoeff());
  }
#else
  const std::function<void()> theirs = [] {};
#endif
  const auto times = medians<4>({ours, theirs, [&] { kdl.mass_matrix(); }, [&] { kdl.direct_dynamics(); }});
  for (auto _ : state) {
    ours();
  }
  state.counters["ns"] = 1e9 * times[0] / samples;
  state.counters["kdl_mass_ratio"] = times[2] / times[0];
  state.counters["kdl_ratio"] = times[3] / times[0];
#if defined(RIVID_WITH_PINOCCHIO)
  state.counters["aba_ns"] = 1e9 * times[1] / samples;
  state.counters["aba_ratio"] = times[1] / times[0];
  state.counters["disagreement"] = disagreement;
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
    const auto add = [&](const char* how_name, How how) {
      benchmark::RegisterBenchmark(
          (std::string(r.name) + "/" + how_name).c_str(),
          [robot = r.robot, how](benchmark::State& state) { dynamics(state, *robot, how); });
    };
    add("one_sample", How::one_sample);
    add("baseline", How::baseline);
    add("avx2", How::avx2);
    add("avx512", How::avx512);
  }
  return 0;
}();

}  // namespace
