#include "simulate/integrator.hpp"

namespace rivid::detail {

namespace {

class RungeKutta4 final : public LoopIntegrator {
 public:
  explicit RungeKutta4(LoopOde& ode)
      : ode_(ode), y_(ode.size()), next_(ode.size()), at_(ode.size()), first_(ode.size()), k_(ode.size()) {}

  void restart(double t, const double* y) override {
    t_ = t;
    next_ = Eigen::Map<const Vector>(y, next_.size());
  }

  Step step(double t_stop) override {
    h_ = t_stop - t_;
    y_ = next_;
    constexpr double node[4] = {0.0, 0.5, 0.5, 1.0};
    constexpr double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    at_ = y_;
    for (int s = 0; s < 4; ++s) {
      if (s > 0) {
        at_ = y_ + (node[s] * h_) * k_;
      }
      if (!ode_.rate(t_ + node[s] * h_, at_.data(), k_.data())) {
        return {t_, Halt::not_positive_definite};
      }
      if (s == 0) {
        first_ = k_;
      }
      next_ += (weight[s] * h_) * k_;
    }
    t_ = t_stop;
    return {t_stop, Halt::none};
  }

  // The cubic through both ends' values and the first slope would need the last one; the step is that of the samples,
  // so a parabola serves.
  void state(double t, double* y) override {
    const double theta = (t - (t_ - h_)) / h_;
    Eigen::Map<Vector>(y, y_.size()) = y_ + theta * h_ * first_ + theta * theta * (next_ - y_ - h_ * first_);
  }

 private:
  LoopOde& ode_;
  Vector y_, next_, at_, first_, k_;
  double t_ = 0.0;
  double h_ = 0.0;
};

}  // namespace

std::unique_ptr<LoopIntegrator> rk4_integrator(LoopOde& ode) { return std::make_unique<RungeKutta4>(ode); }

}  // namespace rivid::detail
