#include <nlopt.h>

#include <exception>
#include <memory>

#include "excite/design_parts.hpp"
#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

// Limits that are kept to rounding count as kept.
constexpr double kept = 1e-9;

// Each step ends in a maximisation of its own, of which NLopt asks for 1e-14 and which takes most of the
// time. With 1e-8 the search gets stuck.
constexpr double dual_tolerance = 1e-10;

// NLopt asks for the objective and for the limits one after the other, at the same variables.
class Search {
 public:
  Search(const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& f, const Vector& z,
         const MmaOptions& options, nlopt_opt solver)
      : f_(f), options_(options), solver_(solver), best_{.z = z, .objective = 0.0, .evaluations = 0} {
    evaluate(z.data());
    best_.objective = value_.objective;
    feasible_ = value_.limits.size() == 0 || value_.limits.maxCoeff() <= kept;
  }

  [[nodiscard]] Index limits() const { return value_.limits.size(); }

  static double objective(unsigned /*n*/, const double* z, double* gradient, void* self) {
    auto& search = *static_cast<Search*>(self);
    search.evaluate(z);
    if (gradient != nullptr) {
      Vector::Map(gradient, search.gradient_.size()) = search.gradient_;
    }
    return search.value_.objective;
  }

  static void constraints(unsigned m, double* values, unsigned n, const double* z, double* gradient,
                          void* self) {
    auto& search = *static_cast<Search*>(self);
    search.evaluate(z);
    Vector::Map(values, m) = search.value_.limits;
    if (gradient != nullptr) {
      Matrix::Map(gradient, n, m) = search.jacobian_;  // row by row, one row a limit
    }
  }

  [[nodiscard]] MmaResult result() const {
    if (fault_) {
      std::rethrow_exception(fault_);
    }
    return best_;
  }

 private:
  void evaluate(const double* z) {
    const Index n = best_.z.size();
    if (at_.size() == n && Vector::Map(z, n) == at_) {
      return;
    }
    at_ = Vector::Map(z, n);
    // An exception must not pass through C.
    try {
      value_ = f_(at_, gradient_, jacobian_);
    } catch (...) {
      fault_ = std::current_exception();
      nlopt_force_stop(solver_);
      return;
    }
    ++best_.evaluations;
    const bool feasible = value_.limits.size() == 0 || value_.limits.maxCoeff() <= kept;
    if (feasible && (!feasible_ || value_.objective < best_.objective)) {
      best_.z = at_;
      best_.objective = value_.objective;
      feasible_ = true;
    }
    if (options_.stopped && options_.stopped()) {
      nlopt_force_stop(solver_);
    }
  }

  const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& f_;
  const MmaOptions& options_;
  nlopt_opt solver_;
  MmaResult best_;
  bool feasible_ = false;
  Vector at_;
  MmaValue value_;
  Vector gradient_;
  Matrix jacobian_;
  std::exception_ptr fault_;
};

}  // namespace

MmaResult minimised(const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& f, Vector z,
                    const MmaOptions& options) {
  const auto n = static_cast<unsigned>(z.size());
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> solver(nlopt_create(NLOPT_LD_MMA, n),
                                                                 nlopt_destroy);
  Search search(f, z, options, solver.get());
  nlopt_set_lower_bounds1(solver.get(), -options.bound);
  nlopt_set_upper_bounds1(solver.get(), options.bound);
  nlopt_set_min_objective(solver.get(), Search::objective, &search);
  if (search.limits() > 0) {
    nlopt_add_inequality_mconstraint(solver.get(), static_cast<unsigned>(search.limits()),
                                     Search::constraints, &search, nullptr);
  }
  nlopt_set_ftol_abs(solver.get(), options.tolerance);
  nlopt_set_maxeval(solver.get(), options.evaluations);
  nlopt_set_param(solver.get(), "dual_ftol_rel", dual_tolerance);
  double objective = 0.0;
  z = z.cwiseMax(-options.bound).cwiseMin(options.bound);
  // How it ended says nothing that the best point does not.
  (void)nlopt_optimize(solver.get(), z.data(), &objective);
  return search.result();
}

}  // namespace rivid::detail
