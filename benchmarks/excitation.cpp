// What an evaluation of an excitation's design costs: the criterion and all limits, and with them the exact
// gradient and the Jacobian of the limits, which includes that of the torques.
//
//   benchmark_excitation ROBOT.urdf [TURNS]
//
// prints processor time of one thread as JSON; benchmarks/excitation_pinocchio.py compares it.

#include <cstdlib>
#include <iostream>
#include <random>

#include "excite/problem.hpp"
#include "rivid/model/urdf.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;

constexpr double duration = 15.0;
constexpr int harmonics = 5;
constexpr Index samples = 200;
constexpr int evaluations = 20;  // between two looks at the clock

detail::Task task_of(const Robot& robot) {
  const BaseParameters base = base_parameters(robot);
  MotionLimits limits;
  limits.acceleration = Vector::Constant(robot.size(), 10.0);
  return {.robot = robot,
          .base = base,
          .chi = base.from_standard(robot.chi_st()),
          .weights = Vector::Ones(robot.size()),
          .known = Matrix::Zero(base.size(), base.size()),
          .objective = detail::Information{},
          .bounds = motion_bounds(robot, limits),
          .space = {.self_collision = false}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: benchmark_excitation ROBOT.urdf [TURNS]\n";
    return 2;
  }
  const detail::Task task = task_of(read_urdf(argv[1]));
  const detail::FourierCurve curve(duration, harmonics, task.bounds, {});
  detail::Problem problem(task, curve, samples, 300.0);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 0.3);
  const Vector z = Vector::NullaryExpr(problem.variables(), [&] { return normal(random); });
  Vector gradient;
  Matrix jacobian;
  if (!problem(z, &gradient, &jacobian).defined) {
    std::cerr << "benchmark_excitation: the motion does not determine all parameters\n";
    return 1;
  }
  const auto times = benchmarks::turns<2>(argc > 2 ? std::atoi(argv[2]) : 50,
                                          {[&] {
                                             for (int k = 0; k < evaluations; ++k) {
                                               (void)problem(z);
                                             }
                                           },
                                           [&] {
                                             for (int k = 0; k < evaluations; ++k) {
                                               (void)problem(z, &gradient, &jacobian);
                                             }
                                           }},
                                          benchmarks::Clock::processor);
  const auto milliseconds = [](const std::vector<double>& seconds) {
    return 1e3 / evaluations * benchmarks::median(seconds);
  };
  std::cout << "{\"parameters\": " << task.base.size() << ", \"variables\": " << problem.variables()
            << ", \"limits\": " << problem.limits() << ", \"samples\": " << samples
            << ", \"criterion_ms\": " << milliseconds(times[0])
            << ", \"gradient_ms\": " << milliseconds(times[1]) << "}\n";
  return 0;
}
