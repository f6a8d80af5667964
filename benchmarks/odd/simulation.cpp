#include "odd/simulation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rivid::odd {

namespace {

// By which a level of friction has to be exceeded, so that roundings do not free what just came to rest.
constexpr double release_margin = 1e-10;
// Events are located to this [s].
constexpr double event_time = 1e-11;
constexpr int most_refinements = 60;
// After so many events within one step the rest of it is taken as it is.
constexpr int most_events = 40;

}  // namespace

Simulation::Simulation(const Plant& plant, double step) : plant_(plant), step_(step) {}

Numbers Simulation::motors(const Numbers& of_freedoms) const { return of_freedoms.tail(plant_.joints()); }

void Simulation::start(double t, const Numbers& q, const Numbers& qd) {
  const Index n = plant_.joints();
  t_ = t;
  x_.resize(plant_.freedoms());
  v_.resize(plant_.freedoms());
  x_.tail(n) = q;
  v_.tail(n) = qd;
  x_.head(n) = q;
  v_.head(n) = qd;
  const Machine& machine = plant_.machine();
  if (machine.elastic()) {
    const Numbers load = plant_.dynamics(t).torques(q, Numbers::Zero(n), Numbers::Zero(n));
    x_.head(n) -= load.cwiseQuotient(machine.stiffness);
  }
  mode_ = Numbers::Ones(plant_.freedoms());
  for (Index j = 0; j < n; ++j) {
    const double speed = v_[plant_.motor(j)];
    mode_[plant_.motor(j)] = speed > 0.0 ? 1.0 : speed < 0.0 ? -1.0 : 0.0;
  }
}

void Simulation::prepare(double t, const State& state) {
  const Numbers tau = (*torque_)(t, motors(state.x), motors(state.v));
  plant_.equation(t, state.x, state.v, tau, *disturbance_, mode_, equation_);
}

void Simulation::solve() {
  const Index size = plant_.freedoms();
  std::array<Index, most_freedoms> moving{};
  Index count = 0;
  f_.resize(size);
  by_load_.setZero(size);
  for (Index i = 0; i < size; ++i) {
    if (mode_[i] != 0.0) {
      moving[static_cast<std::size_t>(count++)] = i;
      f_[i] = mode_[i] > 0.0 ? equation_.F_plus[i] : -equation_.F_minus[i];
      // Of τ − F = (1 ± Fl) (M x'' + N), with + where the motor drives.
      const double rest = equation_.b[i] + equation_.N[i] - f_[i];
      const double factor = rest * mode_[i] > 0.0 ? 1.0 + equation_.Fl[i] : 1.0 - equation_.Fl[i];
      by_load_[i] = equation_.Fl[i] * std::abs(rest) / factor;
      f_[i] += mode_[i] * by_load_[i];
    }
  }
  SquareMatrix M(count, count);
  Numbers b(count);
  for (Index r = 0; r < count; ++r) {
    const Index i = moving[static_cast<std::size_t>(r)];
    b[r] = equation_.b[i] - f_[i];
    for (Index c = 0; c <= r; ++c) {
      M(r, c) = equation_.M(i, moving[static_cast<std::size_t>(c)]);
    }
  }
  const Eigen::LLT<SquareMatrix> factor(M);
  factor.solveInPlace(b);
  a_.setZero(size);
  for (Index r = 0; r < count; ++r) {
    a_[moving[static_cast<std::size_t>(r)]] = b[r];
  }
  for (Index i = 0; i < size; ++i) {
    if (mode_[i] == 0.0) {
      f_[i] = equation_.b[i] - equation_.M.row(i).dot(a_);
      by_load_[i] = equation_.Fl[i] * std::abs(equation_.b[i] + equation_.N[i] - f_[i]);
    }
  }
}

// By how much friction could grow before a motor at rest moves in either direction.
double Simulation::room(Index i) const {
  const double plus = equation_.F_plus[i] + by_load_[i];
  const double minus = equation_.F_minus[i] + by_load_[i];
  const double margin = release_margin * (plus + minus);
  return std::min(plus + margin - f_[i], minus + margin + f_[i]);
}

Simulation::State Simulation::step_from(const State& state, double h) {
  const auto slope = [&](double t, const State& at) {
    prepare(t, at);
    solve();
    return a_;
  };
  const auto moved = [&](const Numbers& v, const Numbers& a, double part) {
    return State{state.x + part * v, state.v + part * a};
  };
  const Numbers a1 = slope(t_, state);
  const State s2 = moved(state.v, a1, 0.5 * h);
  const Numbers a2 = slope(t_ + 0.5 * h, s2);
  const State s3 = moved(s2.v, a2, 0.5 * h);
  const Numbers a3 = slope(t_ + 0.5 * h, s3);
  const State s4 = moved(s3.v, a3, h);
  const Numbers a4 = slope(t_ + h, s4);
  return {state.x + h / 6.0 * (state.v + 2.0 * s2.v + 2.0 * s3.v + s4.v),
          state.v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)};
}

double Simulation::margin(double h, State& end) {
  end = step_from({x_, v_}, h);
  double least = std::numeric_limits<double>::infinity();
  bool stuck = false;
  for (Index j = 0; j < plant_.joints(); ++j) {
    const Index i = plant_.motor(j);
    if (mode_[i] == 0.0) {
      stuck = true;
    } else if (equation_.F_plus[i] > 0.0 || equation_.F_minus[i] > 0.0) {
      least = std::min(least, mode_[i] * end.v[i]);
    }
  }
  if (stuck) {
    prepare(t_ + h, end);
    solve();
    for (Index j = 0; j < plant_.joints(); ++j) {
      const Index i = plant_.motor(j);
      if (mode_[i] == 0.0) {
        least = std::min(least, room(i));
      }
    }
  }
  return least;
}

// Regula falsi with the Illinois rule; it ends just behind the event.
double Simulation::until_event(double h, State& end) {
  double hi = h;
  double at_hi = margin(hi, end);
  if (!(at_hi < 0.0)) {
    return h;
  }
  double lo = 0.0;
  double at_lo = 0.0;
  State trial;
  // What was just set free starts with a margin of zero: halve until it is on its way.
  for (int k = 0; k < most_refinements && !(at_lo > 0.0) && hi > event_time; ++k) {
    const double middle = 0.5 * hi;
    const double value = margin(middle, trial);
    if (value < 0.0) {
      hi = middle;
      at_hi = value;
      end = trial;
    } else {
      lo = middle;
      at_lo = value;
    }
  }
  int side = 0;
  for (int k = 0; k < most_refinements && hi - lo > event_time; ++k) {
    double middle = (lo * at_hi - hi * at_lo) / (at_hi - at_lo);
    // Towards the far side of the event, where the search ends.
    middle = std::clamp(middle + 0.25 * event_time, lo + 0.25 * event_time, hi - 0.25 * event_time);
    const double value = margin(middle, trial);
    if (value < 0.0) {
      hi = middle;
      at_hi = value;
      end = trial;
      at_lo *= side < 0 ? 0.5 : 1.0;
      side = -1;
    } else {
      lo = middle;
      at_lo = value;
      at_hi *= side > 0 ? 0.5 : 1.0;
      side = 1;
    }
  }
  return hi;
}

void Simulation::release() {
  const auto at_rest = [&](Index i) { return v_[i] == 0.0; };
  prepare(t_, {x_, v_});
  // Principal pivoting by least index [Murty 1974]: one change at a time, which ends because M is positive
  // definite.
  for (int round = 0; round < 200; ++round) {
    solve();
    bool changed = false;
    for (Index j = 0; j < plant_.joints() && !changed; ++j) {
      const Index i = plant_.motor(j);
      if (mode_[i] == 0.0 && room(i) < 0.0) {
        mode_[i] = f_[i] > 0.0 ? 1.0 : -1.0;
        changed = true;
      } else if (mode_[i] != 0.0 && at_rest(i) && mode_[i] * a_[i] < 0.0) {
        mode_[i] = 0.0;
        changed = true;
      }
    }
    if (!changed) {
      return;
    }
  }
}

void Simulation::advance(double end, const Torque& torque, const Numbers& disturbance) {
  torque_ = &torque;
  disturbance_ = &disturbance;
  release();
  int events = 0;
  State at_end;
  while (t_ < end) {
    const double left = end - t_;
    const double h = left / std::max(1.0, std::ceil(left / step_ - 1e-9));
    double done = h;
    if (events < most_events) {
      done = until_event(h, at_end);
    } else {
      at_end = step_from({x_, v_}, h);
    }
    x_ = at_end.x;
    v_ = at_end.v;
    t_ = done == left ? end : t_ + done;
    if (done == h) {
      events = 0;
    }
    bool stopped = false;
    for (Index j = 0; j < plant_.joints(); ++j) {
      const Index i = plant_.motor(j);
      const bool braked = equation_.F_plus[i] > 0.0 || equation_.F_minus[i] > 0.0;
      if (braked && mode_[i] * v_[i] < 0.0) {
        v_[i] = 0.0;
        mode_[i] = 0.0;
        stopped = true;
      }
    }
    if (stopped || done < h) {
      ++events;
      ++events_;
      release();
    }
  }
}

}  // namespace rivid::odd
