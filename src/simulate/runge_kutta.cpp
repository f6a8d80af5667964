#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "simulate/integrator.hpp"
#include "simulate/runge_kutta_pairs.hpp"

namespace rivid::detail {

namespace {

// A step that fails for its error shrinks by this at most, and the next one grows by that at most.
constexpr double most_shrinking = 0.2;
constexpr double most_growing = 5.0;
constexpr double safety = 0.9;  // of the step that the error asks for: the usual value
// Part of the step to which the instant of an event is located.
constexpr double event_tolerance = 1e-12;
// Time by which an event lies behind the last one at least [s].
constexpr double least_progress = 1e-9;
// Relative to the distance to go: a step that leaves less than this takes it along.
constexpr double leftover = 1.0 + 1e-6;

// Errors for which the next step may grow by most_growing with certainty, (safety / most_growing)^order.
template <typename Pair>
constexpr double error_of_full_growth = [] {
  double out = 1.0 - 1e-6;
  for (int k = 0; k < static_cast<int>(Pair::order); ++k) {
    out *= safety / most_growing;
  }
  return out;
}();

template <typename Pair>
class RungeKutta final : public LoopIntegrator {
 public:
  RungeKutta(LoopOde& ode, const IntegratorOptions& options)
      : ode_(ode),
        options_(options),
        k_(ode.size(), Pair::stages),
        y_(ode.size()),
        next_(ode.size()),
        error_(ode.size()),
        at_(ode.size()),
        rate_(ode.size()),
        margins_(ode.events()) {}

  void restart(double t, const double* y) override {
    t_ = t;
    y_ = Eigen::Map<const Vector>(y, y_.size());
    fresh_ = true;
    shortened_ = 0.0;
  }

  Step step(double t_stop) override {
    if (fresh_) {
      if (!ode_.rate(t_, y_.data(), k_.col(0).data())) {
        return {t_, Halt::not_positive_definite};
      }
      fresh_ = false;
    } else {
      t_ = t_ + h_;
      y_.swap(next_);
      k_.col(0).swap(k_.col(Pair::stages - 1));
    }
    const double left = t_stop - t_;
    double h = limited(suggested_ > 0 ? suggested_ : first_step(left));
    for (;;) {
      const bool last = ends_at_stop(h, left);
      h_ = length(h, left);
      // Where y no longer changes with t nothing can be gained by a shorter step.
      if (!(h_ > 1e-14 * std::max(std::abs(t_), h_floor))) {
        return {t_, definite_ ? Halt::failed : Halt::not_positive_definite};
      }
      definite_ = try_step();
      if (!definite_) {
        h = 0.25 * h_;
        continue;
      }
      const double error = error_norm();
      const double factor = growth(error);
      if (error > 1.0 || !std::isfinite(error)) {
        h = std::isfinite(error) ? h_ * factor : 0.1 * h_;
        continue;
      }
      suggest(h, factor, last);
      break;
    }
    prepare_dense();
    return find_event();
  }

  [[nodiscard]] double proposal(double left) const override {
    return std::is_same_v<Pair, BogackiShampine> && suggested_ > 0 ? length(wanted(), left) : 0.0;
  }

  bool judge(double left, double error) override {
    const double h = wanted();
    h_ = length(h, left);
    const double factor = growth(error);
    if (error > 1.0) {
      shortened_ = h_ * factor;
      return false;
    }
    suggest(h, factor, ends_at_stop(h, left));
    shortened_ = 0.0;
    return true;
  }

  void state(double t, double* y) override {
    // The end itself to the last bit, at which the dynamics are known already.
    Eigen::Map<Vector>(y, y_.size()) = t == t_ + h_ ? next_ : dense((t - t_) / h_);
  }

 private:
  static constexpr double h_floor = 1e-3;  // [s] stands for times near zero: no step is below 1e-17 s

  [[nodiscard]] double limited(double h) const {
    const double longest = options_.longest_step(ode_.sticking());
    return longest > 0 ? std::min(h, longest) : h;
  }

  [[nodiscard]] static bool ends_at_stop(double h, double left) { return h * leftover >= left; }
  [[nodiscard]] static double length(double h, double left) {
    return ends_at_stop(h, left) ? left : std::min(h, 0.5 * left);
  }
  // For proposal().
  [[nodiscard]] double wanted() const { return shortened_ > 0 ? shortened_ : limited(suggested_); }

  // By what the next step may differ from one with this error.
  [[nodiscard]] static double growth(double error) {
    // So small that the power, which takes long, would be cut off.
    if (error < error_of_full_growth<Pair>) {
      return most_growing;
    }
    return std::clamp(safety * std::pow(error, -1.0 / Pair::order), most_shrinking, most_growing);
  }

  void suggest(double h, double factor, bool last) {
    // A step that was cut short at t_stop says less about the next than what had been suggested before.
    suggested_ = last ? std::max(h, h_ * factor) : h_ * factor;
  }

  // Small against the time in which the state changes, after Hairer, Nørsett & Wanner II.4.
  [[nodiscard]] double first_step(double left) const {
    const double scale = options_.atol + options_.rtol * y_.cwiseAbs().maxCoeff();
    const double speed = k_.col(0).cwiseAbs().maxCoeff();
    const double h =
        speed > 0 ? 0.01 * std::max(y_.cwiseAbs().maxCoeff(), std::pow(scale, 0.8)) / speed : left;
    return std::min(left, std::max(h, 1e-9));
  }

  bool try_step() {
    for (int s = 1; s < Pair::stages; ++s) {
      next_ = y_;
      for (int r = 0; r < s; ++r) {
        if (Pair::stage[s][r] != 0.0) {
          next_ += (h_ * Pair::stage[s][r]) * k_.col(r);
        }
      }
      if (!ode_.rate(t_ + Pair::node[s] * h_, next_.data(), k_.col(s).data())) {
        return false;
      }
    }
    return true;
  }

  double error_norm() {
    error_.setZero();
    for (int s = 0; s < Pair::stages; ++s) {
      error_ += (h_ * Pair::error_weight[s]) * k_.col(s);
    }
    double worst = 1e-10;
    for (Index i = 0; i < y_.size(); ++i) {
      const double scale = options_.atol + options_.rtol * std::max(std::abs(y_[i]), std::abs(next_[i]));
      worst = std::max(worst, std::abs(error_[i]) / scale);
      if (!std::isfinite(error_[i])) {
        return std::numeric_limits<double>::infinity();
      }
    }
    return worst;
  }

  void prepare_dense() {
    error_.setZero();
    if constexpr (!Pair::more_dense) {
      return;
    }
    for (int s = 0; s < Pair::stages; ++s) {
      error_ += (h_ * Pair::dense_weight[s]) * k_.col(s);
    }
  }

  // y at t + theta h: the term of fourth order is in error_ by now.
  const Vector& dense(double theta) {
    const double rest = 1.0 - theta;
    for (Index i = 0; i < y_.size(); ++i) {
      const double change = next_[i] - y_[i];
      const double bend = h_ * k_(i, 0) - change;
      const double twist = change - h_ * k_(i, Pair::stages - 1) - bend;
      at_[i] = y_[i] + theta * (change + rest * (bend + theta * (twist + rest * error_[i])));
    }
    return at_;
  }

  double margin_at(double theta, Index element) {
    dense(theta);
    if (ode_.stick_slip().mode(element) == FrictionMode::stick) {
      // A state without accelerations can not be met here: the Pair::stages around it had them.
      [[maybe_unused]] const bool definite = ode_.rate(t_ + theta * h_, at_.data(), rate_.data());
    }
    return ode_.stick_slip().margin(element,
                                    {at_.data() + ode_.joints(), static_cast<std::size_t>(ode_.joints())});
  }

  // Whether an element's mode ended within the step, and which one first. A look at the middle finds speeds
  // that dip below zero and come back.
  Step find_event() {
    double end = 1.0;
    Index ended = -1;
    if (ode_.events() > 0) {
      ode_.margins(next_.data(),
                   margins_.data());  // λ is that of the last stage, which is the end of the step
      for (Index e = 0; e < margins_.size(); ++e) {
        const bool slips = ode_.stick_slip().mode(e) != FrictionMode::stick;
        double below = margins_[e] < 0 ? 1.0 : 0.0;
        if (below == 0.0 && slips && margin_at(0.5, e) < 0) {
          below = 0.5;
        }
        if (below > 0) {
          const double theta = locate(e, below);
          if (theta < end || ended < 0) {
            end = theta;
            ended = e;
          }
        }
      }
    }
    if (ended < 0) {
      return {t_ + h_, Halt::none};
    }
    return {t_ + end * h_, Halt::event, ended};
  }

  // First zero of a margin up to `above`, where it is negative: Illinois' form of the false position. The
  // margin of an element that has just been let go begins at zero, so the search begins a little later; if it
  // turned back at once, that little time passes all the same, for else its torques could never show
  // otherwise.
  double locate(Index element, double above) {
    double a = std::min(above, least_progress / h_);
    double b = above;
    double at_a = margin_at(a, element);
    if (at_a <= 0) {
      return a;
    }
    double at_b = margin_at(b, element);
    while (b - a > event_tolerance) {
      double theta = (a * at_b - b * at_a) / (at_b - at_a);
      if (!(theta > a) || !(theta < b)) {
        theta = 0.5 * (a + b);
      }
      const double value = margin_at(theta, element);
      if (value > 0) {
        a = theta;
        at_a = value;
        at_b *= 0.5;
      } else if (value < 0) {
        b = theta;
        at_b = value;
        at_a *= 0.5;
      } else {
        return theta;
      }
    }
    return b;
  }

  LoopOde& ode_;
  IntegratorOptions options_;
  Matrix k_;  // rates of the Pair::stages
  Vector y_, next_, error_, at_, rate_, margins_;
  double t_ = 0.0;
  double h_ = 0.0;
  double suggested_ = 0.0;
  double shortened_ = 0.0;  // after a judge() that did not let the step stand
  bool fresh_ = true;
  bool definite_ = true;
};

// The classical method.
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

  // The cubic through both ends' values and the first slope would need the last one; the step is that of the
  // samples, so a parabola serves.
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

std::unique_ptr<LoopIntegrator> bogacki_shampine_integrator(LoopOde& ode, const IntegratorOptions& options) {
  return std::make_unique<RungeKutta<BogackiShampine>>(ode, options);
}

std::unique_ptr<LoopIntegrator> dormand_prince_integrator(LoopOde& ode, const IntegratorOptions& options) {
  return std::make_unique<RungeKutta<DormandPrince>>(ode, options);
}

std::unique_ptr<LoopIntegrator> rk4_integrator(LoopOde& ode) { return std::make_unique<RungeKutta4>(ode); }

}  // namespace rivid::detail
