#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/solve/least_squares.hpp"

namespace rivid::detail {

// What all methods make of their estimate: statistics, the fit joint by joint, words about rank.

// Adds the factors of one more log.
void add_factors(RowFactors& into, RowFactors part);

// The factors of the rows of all logs.
[[nodiscard]] RowFactors all_factors(const Robot& robot, const BaseParameters& base,
                                     std::span<const Log> logs, const SignalOptions& signal, int threads,
                                     const Progress& progress);

// Deviation of a residual: (17) with its degrees of freedom, or MATLAB's std with the mean removed.
[[nodiscard]] double deviation(const Residual& r, double freedom, Convention convention);

// The model against the rows, unweighted. Each joint is charged its share of the `estimated` parameters; a validation
// charges none.
[[nodiscard]] Fit judged(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
                         Convention convention);

// 1 / σ of each joint's rows, (20).
//
// throws InputError in the name of `who` where a joint's torque is zero throughout
[[nodiscard]] std::vector<double> joint_weights(const char* who, const Robot& robot, const RowFactors& data);

// out.parameters from out.chi, out.C_chi and out.covariance.
void describe_parameters(const Robot& robot, Identification& out);

// Status and reasons of an estimate that does not determine some sets of parameters, "… is not excited by `what`".
void explain_rank(Index rank, const std::vector<std::vector<Index>>& undetermined, const std::string& what,
                  Identification& out);

}  // namespace rivid::detail
