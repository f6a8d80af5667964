// The base regressor of a sample: packs of samples by each instruction set and one sample at a time, against
// Pinocchio's computeJointTorqueRegressor (where it was found), KDL's inverse dynamics, and the time that the
// counted arithmetic would take at the measured peak rate of the machine.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "peak.hpp"
#include "rivid/model/kdl.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "robots.hpp"
#include "turns.hpp"

#if defined(RIVID_WITH_PINOCCHIO)
#include "pinocchio_robot.hpp"
#endif

namespace {

using namespace rivid;
using namespace rivid::benchmarks;

constexpr Index samples = 1024;

// A Scalar that counts what an FMA unit would have to do: a product is free when a sum takes it up.
struct Counted {
  inline static long fused = 0;
  inline static long apart = 0;
  bool product = false;

  Counted() = default;
  Counted(double) {}
  friend Counted operator*(const Counted&, const Counted&) {
    ++fused;
    ++apart;
    Counted out;
    out.product = true;
    return out;
  }
  static Counted sum(const Counted& a, const Counted& b) {
    fused += a.product || b.product ? 0 : 1;
    ++apart;
    return {};
  }
  friend Counted operator+(const Counted& a, const Counted& b) { return sum(a, b); }
  friend Counted operator-(const Counted& a, const Counted& b) { return sum(a, b); }
  friend Counted operator-(const Counted& a) { return a; }
  // Friction that is smooth at reversals, which no robot here has.
  friend Counted operator/(const Counted& a, const Counted&) { return a; }
  friend Counted tanh(const Counted& a) { return a; }
  friend Counted sqrt(const Counted& a) { return a; }
  friend Counted exp(const Counted& a) { return a; }
  friend bool operator>(const Counted&, const Counted&) { return false; }
  friend bool operator<(const Counted&, const Counted&) { return false; }
  friend Counted select(bool, const Counted&, const Counted&) { return {}; }
  // Sums and products of BasicPack::sin_cos(); its bit operations run beside them.
  struct Mask {
    friend Mask operator|(const Mask& a, const Mask&) { return a; }
    friend bool any(const Mask&) { return false; }
  };
  friend Mask too_far(const Counted&) { return {}; }
  friend void sin_cos_far(const Counted&, Counted&, Counted&) {}
  friend void sin_cos_near(const Counted&, Counted&, Counted&) {
    fused += 20;
    apart += 37;
  }
};

}  // namespace

// The steps of the packs are counted.
template <>
inline constexpr bool rivid::detail::has_quick_steps<Counted> = true;

namespace {

struct Count {
  long fused = 0;
  long apart = 0;
};

// The first link, whose zeros the compiler sees and this count does not, is left out: the bound is a lower
// one.
Count counted(const RegressorBatch& batch) {
  const auto count_of = [&](std::size_t joints) {
    rivid::detail::RegressorPlan plan = batch.plan();
    plan.joints = joints;
    Counted::fused = 0;
    Counted::apart = 0;
    Counted sink;
    const std::vector<Counted*> columns(100000, &sink);
    std::vector<rivid::detail::Screw<Counted>> screws(plan.joints);
    std::vector<rivid::detail::CosSin<Counted>> angles(plan.joints);
    rivid::detail::fill_rows<Counted>(plan, {&sink, &sink, &sink, 0, 0, 0}, 1, columns.data(),
                                      {screws.data(), angles.data(), nullptr, nullptr});
    return Count{Counted::fused, Counted::apart};
  };
  const Count all = count_of(batch.joints());
  const Count first = count_of(1);
  return {all.fused - first.fused, all.apart - first.apart};
}

class Kdl {
 public:
  Kdl(const Robot& robot, const Motion& motion)
      : motion_(motion),
        chain_(kdl_chain(robot)),
        solver_(chain_, KDL::Vector(0.0, 0.0, -9.81)),
        q_(static_cast<unsigned>(robot.size())),
        qd_(q_),
        qdd_(q_),
        tau_(q_),
        no_forces_(chain_.getNrOfSegments()) {}

  void operator()() {
    for (Index k = 0; k < samples; ++k) {
      for (unsigned j = 0; j < q_.rows(); ++j) {
        q_(j) = motion_.q(k, j);
        qd_(j) = motion_.qd(k, j);
        qdd_(j) = motion_.qdd(k, j);
      }
      solver_.CartToJnt(q_, qd_, qdd_, no_forces_, tau_);
      benchmark::DoNotOptimize(tau_.data.data());
    }
  }

 private:
  const Motion& motion_;
  KDL::Chain chain_;
  KDL::ChainIdSolver_RNE solver_;
  KDL::JntArray q_, qd_, qdd_, tau_;
  KDL::Wrenches no_forces_;
};

#if defined(RIVID_WITH_PINOCCHIO)
// Largest difference to Pinocchio's regressor, relative to the largest entry.
double disagreement(PinocchioRegressor& pinocchio, const RegressorBatch& batch,
                    const std::vector<StandardParameter>& parameters, const Motion& motion) {
  const Index n = motion.joints();
  RegressorBlock block(batch, samples);
  batch.fill(motion, 0, samples, block);
  double largest = 0.0;
  double difference = 0.0;
  for (Index k = 0; k < samples; ++k) {
    const Vector q = motion.q.row(k);
    const Vector qd = motion.qd.row(k);
    const Vector qdd = motion.qdd.row(k);
    const Eigen::Map<const Matrix> W(pinocchio(q.data(), qd.data(), qdd.data()), n, 10 * n);
    largest = std::max(largest, W.cwiseAbs().maxCoeff());
    for (Index i = 0; i < n; ++i) {
      const std::vector<Index>& own = batch.of_joint(static_cast<std::size_t>(i));
      for (std::size_t c = 0; c < own.size(); ++c) {
        const StandardParameter& p = parameters[static_cast<std::size_t>(own[c])];
        if (p.kind < ParameterKind::Ia) {
          const Index column = benchmarks::pinocchio_column(p);
          difference = std::max(difference, std::abs(W(i, column) - block.W(static_cast<std::size_t>(i))(
                                                                        k, static_cast<Index>(c))));
        }
      }
    }
  }
  return difference / largest;
}
#endif

enum class How { one_sample, baseline, avx2, avx512 };

void regressor(benchmark::State& state, const Robot& robot, How how, Index rows_wanted) {
  const Motion motion = random_series(20260731, samples, robot.size(), 5.0);
  const BaseParameters base = base_parameters(robot);
  const std::vector<StandardParameter> parameters = base.columns();
  const Simd simd = how == How::avx512 ? Simd::avx512 : how == How::avx2 ? Simd::avx2 : Simd::baseline;
  if (!supported(simd)) {
    state.SkipWithError("this machine has not that instruction set");
    return;
  }
  const RegressorBatch batch(robot, parameters, {.simd = simd});
  RegressorBlock block = rows_wanted > 0 ? RegressorBlock(batch, rows_wanted) : RegressorBlock(batch);
  const Index block_rows = block.capacity();
  const RegressorColumns columns(robot, parameters);
  RegressorWorkspace<double> workspace(columns);
  const auto n = static_cast<std::size_t>(robot.size());
  // One sample at a time finds its state in a row of memory; so does the reference.
  const Matrix q = motion.q.transpose();
  const Matrix qd = motion.qd.transpose();
  const Matrix qdd = motion.qdd.transpose();
  std::vector<Vector> rows;
  for (std::size_t i = 0; i < n; ++i) {
    rows.emplace_back(static_cast<Index>(columns.of_joint(i).size()));
  }
  const auto ours = [&] {
    if (how != How::one_sample) {
      for (Index first = 0; first < samples; first += block_rows) {
        batch.fill(motion, first, std::min(block_rows, samples - first), block);
        benchmark::ClobberMemory();
      }
      return;
    }
    for (Index k = 0; k < samples; ++k) {
      columns.rows(State<double>{{q.col(k).data(), n}, {qd.col(k).data(), n}, {qdd.col(k).data(), n}},
                   workspace, [&](std::size_t i, Index column, double value) { rows[i][column] = value; });
      benchmark::ClobberMemory();
    }
  };
  Kdl kdl(robot, motion);
#if defined(RIVID_WITH_PINOCCHIO)
  PinocchioRegressor pinocchio = benchmarks::pinocchio_of(robot);
#endif
  const std::function<void()> theirs = [&] {
#if defined(RIVID_WITH_PINOCCHIO)
    for (Index k = 0; k < samples; ++k) {
      benchmark::DoNotOptimize(pinocchio(q.col(k).data(), qd.col(k).data(), qdd.col(k).data()));
    }
#endif
  };
  const benchmarks::Peak peak = benchmarks::peak(simd);
  std::array<double, 4> times{};
  std::ranges::transform(benchmarks::turns<4>(60, {ours, theirs, std::ref(kdl), peak.run}), times.begin(),
                         [](const std::vector<double>& sorted) { return sorted.front(); });
  const double sample = 1e9 * times[0] / samples;
  for (auto _ : state) {
    ours();
  }
  state.counters["ns"] = sample;
  state.counters["kdl_rne_ratio"] = times[2] / times[0];
#if defined(RIVID_WITH_PINOCCHIO)
  state.counters["pinocchio_ns"] = 1e9 * times[1] / samples;
  state.counters["pinocchio_ratio"] = times[1] / times[0];
  if (how != How::one_sample) {
    state.counters["disagreement"] = disagreement(pinocchio, batch, parameters, motion);
  }
#endif
  if (how != How::one_sample) {
    const Count count = counted(batch);
    const auto operations = static_cast<double>(simd == Simd::baseline ? count.apart : count.fused);
    const double bound = 1e9 * operations / peak.lanes * times[3] / peak.operations;
    state.counters["operations"] = operations;
    state.counters["bound_ns"] = bound;
    state.counters["of_bound"] = bound / sample;
  }
}

const Robot the_scara = benchmarks::scara();
const Robot the_tx40 = benchmarks::tx40();
const Robot the_panda = benchmarks::panda();
const Robot the_oblique = benchmarks::oblique();
const Robot the_snake = benchmarks::snake();

const int registered = [] {
  struct Named {
    const char* name;
    const Robot* robot;
  };
  for (const Named& r :
       {Named{"scara_2", &the_scara}, Named{"tx40_6", &the_tx40}, Named{"panda_7", &the_panda},
        Named{"oblique_7", &the_oblique}, Named{"snake_30", &the_snake}}) {
    const auto add = [&](const std::string& how_name, How how, Index rows) {
      benchmark::RegisterBenchmark(
          (std::string(r.name) + "/" + how_name).c_str(),
          [robot = r.robot, how, rows](benchmark::State& state) { regressor(state, *robot, how, rows); });
    };
    add("one_sample", How::one_sample, 0);
    add("baseline", How::baseline, 0);
    add("avx2", How::avx2, 0);
    add("avx512", How::avx512, 0);
    add("avx512_block_of_16", How::avx512, 16);
  }
  return 0;
}();

}  // namespace
