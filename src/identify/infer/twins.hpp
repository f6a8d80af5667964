#pragma once

#include <vector>

#include "identify/infer/infer.hpp"

// Joint::same_as: links and joints that are alike.
namespace rivid::detail {

struct Twins {
  struct Pair {
    int joint = 0;  // counted from 0
    int twin = 0;
    Matrix A;  // A χ = 0 is what this pair and those behind its link say, (m × b), rows orthonormal
  };
  std::vector<Pair> pairs;
  Matrix free;  // χ = free θ is what all pairs leave, (b × b − m), columns orthonormal
};

// throws InputError where a twin is none of the robot's joints, differs in kind or stands elsewhere
[[nodiscard]] Twins twins_of(const Robot& robot, const BaseParameters& base);

// Inference::tie of an estimate, applied to all of `out` that is a vector or covariance of the parameters, and
// what the data say of the ties: notes and warnings. Least squares of the rows with the ties, for independent
// errors, as essential() does it.
void tie_twins(const EstimationProblem& problem, const Estimate& estimate, Inference& out);

// The same estimate with ties that hold to a part of its deviations that does not count.
[[nodiscard]] Estimate tied(Estimate estimate, const Matrix& tie);

}  // namespace rivid::detail
