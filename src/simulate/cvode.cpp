#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <sundials/sundials_context.hpp>
#include <vector>

#include "rivid/error.hpp"
#include "simulate/integrator.hpp"

namespace rivid::detail {

namespace {

// Everything of SUNDIALS here has a function that frees it by its address.
template <typename T, auto free>
struct Owned {
  T* held = nullptr;
  Owned() = default;
  explicit Owned(T* p) : held(p) {
    if (held == nullptr) {
      throw NumericsError("simulate: CVODE could not be set up, out of memory");
    }
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() {
    if (held != nullptr) {
      free(held);
    }
  }
  operator T*() const { return held; }  // NOLINT(google-explicit-constructor): it stands for the pointer
};

void free_cvode(void* memory) { CVodeFree(&memory); }

class Cvode final : public LoopIntegrator {
 public:
  Cvode(LoopOde& ode, const IntegratorOptions& options, bool bdf)
      : ode_(ode),
        options_(options),
        y_(N_VNew_Serial(static_cast<sunindextype>(ode.size()), context_)),
        at_(N_VMake_Serial(static_cast<sunindextype>(ode.size()), nullptr, context_)),
        memory_(CVodeCreate(bdf ? CV_BDF : CV_ADAMS, context_)),
        rate_(ode.size()),
        margins_(ode.events()),
        roots_(static_cast<std::size_t>(ode.events())),
        bdf_(bdf) {}

  void restart(double t, const double* y) override {
    std::copy_n(y, ode_.size(), N_VGetArrayPointer(y_));
    t_ = t;
    if (!made_) {
      make();
      made_ = true;
    } else {
      check(CVodeReInit(memory_, t, y_), "CVodeReInit");
    }
    check(CVodeSetMaxStep(memory_, options_.longest_step(ode_.sticking())), "CVodeSetMaxStep");
    definite_ = true;
  }

  Step step(double t_stop) override {
    check(CVodeSetStopTime(memory_, t_stop), "CVodeSetStopTime");
    double t = t_;
    const int flag = CVode(memory_, t_stop, y_, &t, CV_ONE_STEP);
    if (flag == CV_ROOT_RETURN) {
      t_ = t;
      CVodeGetRootInfo(memory_, roots_.data());
      const auto found = std::find_if(roots_.begin(), roots_.end(), [](int r) { return r != 0; });
      return {t, Halt::event, static_cast<Index>(found - roots_.begin())};
    }
    if (flag < 0) {
      return {t_, definite_ ? Halt::failed : Halt::not_positive_definite};
    }
    t_ = t;
    return missed(t);
  }

  void state(double t, double* y) override {
    // Times beyond the last step by rounding are those of its ends.
    double last = 0.0;
    double now = 0.0;
    CVodeGetLastStep(memory_, &last);
    CVodeGetCurrentTime(memory_, &now);
    if (last == 0.0) {
      std::copy_n(N_VGetArrayPointer(y_), ode_.size(), y);
      return;
    }
    N_VSetArrayPointer(y, at_);
    check(CVodeGetDky(memory_, std::clamp(t, now - last, now), 0, at_), "CVodeGetDky");
  }

 private:
  static int rate(double t, N_Vector y, N_Vector yd, void* self) {
    auto* me = static_cast<Cvode*>(self);
    me->definite_ = me->ode_.rate(t, N_VGetArrayPointer(y), N_VGetArrayPointer(yd));
    return me->definite_ ? 0 : 1;  // CVODE then tries a shorter step
  }

  static int margins(double t, N_Vector y, double* g, void* self) {
    auto* me = static_cast<Cvode*>(self);
    if (me->ode_.sticking() && !me->ode_.rate(t, N_VGetArrayPointer(y), me->rate_.data())) {
      me->definite_ = false;
      return 1;
    }
    me->ode_.margins(N_VGetArrayPointer(y), g);
    return 0;
  }

  static void check(int flag, const char* what) {
    if (flag < 0) {
      throw NumericsError(std::string("simulate: ") + what + " of CVODE failed with " + std::to_string(flag));
    }
  }

  void make() {
#if SUNDIALS_VERSION_MAJOR < 7
    // Its messages go nowhere: every outcome is judged by its flag.
    CVodeSetErrHandlerFn(memory_, [](int, const char*, const char*, char*, void*){}, nullptr);
#else
    SUNContext_ClearErrHandlers(context_);
#endif
    check(CVodeInit(memory_, &Cvode::rate, t_, y_), "CVodeInit");
    check(CVodeSStolerances(memory_, options_.rtol, options_.atol), "CVodeSStolerances");
    check(CVodeSetUserData(memory_, this), "CVodeSetUserData");
    if (bdf_) {
      const auto n = static_cast<sunindextype>(ode_.size());
      matrix_.held = SUNDenseMatrix(n, n, context_);
      linear_.held = SUNLinSol_Dense(y_, matrix_, context_);
      check(CVodeSetLinearSolver(memory_, linear_, matrix_), "CVodeSetLinearSolver");
    } else {
      iteration_.held = SUNNonlinSol_FixedPoint(y_, 0, context_);
      check(CVodeSetNonlinearSolver(memory_, iteration_), "CVodeSetNonlinearSolver");
    }
    if (ode_.events() > 0) {
      check(CVodeRootInit(memory_, static_cast<int>(ode_.events()), &Cvode::margins), "CVodeRootInit");
      std::fill(roots_.begin(), roots_.end(), -1);  // only a margin that falls below zero ends a mode
      check(CVodeSetRootDirection(memory_, roots_.data()), "CVodeSetRootDirection");
      CVodeSetNoInactiveRootWarn(memory_);
    }
  }

  // A margin that was zero or a rounding below it when the step began is no root to CVODE.
  Step missed(double t) {
    if (ode_.events() == 0) {
      return {t, Halt::none};
    }
    if (margins(t, y_, margins_.data(), this) != 0) {
      return {t, Halt::not_positive_definite};
    }
    Index worst = -1;
    const double least = margins_.minCoeff(&worst);
    if (least < -tolerated) {
      return {t, Halt::event, worst};
    }
    return {t, Halt::none};
  }

  // by which a margin may be below zero: any small value, roots are found to rounding
  static constexpr double tolerated = 1e-9;

  LoopOde& ode_;
  IntegratorOptions options_;
  sundials::Context context_;
  Owned<_generic_N_Vector, N_VDestroy> y_;
  Owned<_generic_N_Vector, N_VDestroy> at_;  // on memory of the caller's
  Owned<_generic_SUNMatrix, SUNMatDestroy> matrix_;
  Owned<_generic_SUNLinearSolver, SUNLinSolFree> linear_;
  Owned<_generic_SUNNonlinearSolver, SUNNonlinSolFree> iteration_;
  Owned<void, free_cvode> memory_;
  Vector rate_;
  Vector margins_;
  std::vector<int> roots_;
  bool bdf_;
  bool made_ = false;
  bool definite_ = true;
  double t_ = 0.0;
};

}  // namespace

std::unique_ptr<LoopIntegrator> cvode_integrator(LoopOde& ode, const IntegratorOptions& options, bool bdf) {
  return std::make_unique<Cvode>(ode, options, bdf);
}

}  // namespace rivid::detail
