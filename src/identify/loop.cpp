#include "identify/loop.hpp"

#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/differentiate.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/references.hpp"
#include "simulate/loop.hpp"

namespace rivid::detail {

namespace {

// Stretch of the log that its first position and velocity are told from [s], and the samples it takes at least.
constexpr double start_stretch = 0.05;
constexpr Index fewest_samples = 7;

// Position and velocity at the first sample: parabolas through the first positions, which noise moves little.
void measured_start(const Log& log, Vector& q, Vector& qd) {
  const auto wanted = std::max(fewest_samples, static_cast<Index>(start_stretch * log.f_m));
  const Index m = std::min(wanted, log.samples());
  Matrix powers(m, 3);
  for (Index k = 0; k < m; ++k) {
    const double t = static_cast<double>(k) / log.f_m;
    powers.row(k) << 1.0, t, t * t;
  }
  const Matrix coefficients = least_squares_solution(powers, log.q.topRows(m));
  q = coefficients.row(0);
  qd = coefficients.row(1);
}

Matrix filtered(const Log& log, double cutoff_hz, const SignalOptions& signal) {
  return cutoff_hz > 0.0 ? zero_phase(log.q, log.f_m, cutoff_hz, signal.order, signal.convention) : log.q;
}

// The clock of the simulation: from zero, by the rate of the log. Its own stamps may be those of an epoch.
Vector instants(const Log& log) {
  return Vector::NullaryExpr(log.samples(), [&](Index k) { return static_cast<double>(k) / log.f_m; });
}

std::unique_ptr<Reference> reference_of(const Log& log, const SignalOptions& signal, const Iv& method) {
  if (method.follows == Iv::Follows::measured) {
    const double cutoff_hz = method.reference_cutoff_hz > 0.0 ? method.reference_cutoff_hz : signal.cutoff_hz;
    return std::make_unique<LoggedReference>(instants(log), filtered(log, cutoff_hz, signal));
  }
  if (log.q_r.size() == 0) {
    throw InputError(
        log.source +
        ": no reference columns, which the simulated loop must follow; name them, or let the filtered "
        "measured positions stand in for them");
  }
  return std::make_unique<LoggedReference>(instants(log), log.q_r);
}

}  // namespace

AuxiliaryLoop::AuxiliaryLoop(const Robot& robot, const Log& log, const SignalOptions& signal,
                             const Iv& method)
    : robot_(robot), log_(log), reference_(reference_of(log, signal, method)), options_(method.simulation) {
  const Index n = robot.size();
  options_.f_m = log.f_m;
  options_.samples = log.samples();
  options_.sampling = method.sampling;
  if (options_.integrator == Integrator::automatic && options_.sampling.period == 0.0) {
    // Every sample and every reversal of six joints makes a multistep method look back or begin anew.
    options_.integrator = Integrator::dormand_prince;
  }
  options_.q_0.resize(0);
  options_.qd_0.resize(0);
  if (!method.start_on_reference) {
    measured_start(log, options_.q_0, options_.qd_0);
  }
  measured_ = differentiate(filtered(log, signal.cutoff_hz, signal), log.f_m);
  Vector q(n);
  Vector qd(n);
  Vector qdd(n);
  for (Matrix* m : {&reference_motion_.q, &reference_motion_.qd, &reference_motion_.qdd}) {
    m->resize(log.samples(), n);
  }
  for (Index k = 0; k < log.samples(); ++k) {
    reference_->at(static_cast<double>(k) / log.f_m, q, qd, qdd);
    reference_motion_.q.row(k) = q;
    reference_motion_.qd.row(k) = qd;
    reference_motion_.qdd.row(k) = qdd;
  }
}

Simulation AuxiliaryLoop::simulate(const DynamicModel& model, const ControlLaw& law, Index most_steps) const {
  SimulationOptions options = options_;
  options.max_steps = std::min(options.max_steps, most_steps);
  return rivid::simulate(robot_, model, law, *reference_, options);
}

Matrix AuxiliaryLoop::rebuilt_control(const ControlLaw& law) const {
  const Index n = robot_.size();
  Matrix out(log_.samples(), n);
  const bool every_sample = std::abs(options_.sampling.period * log_.f_m - 1.0) < 1e-6 &&
                            !options_.sampling.velocity_filter.empty();
  if (every_sample) {
    Sampling sampling = options_.sampling;
    sampling.position_noise.resize(0, 0);
    sampling.quantum.resize(0);
    SampledController controller(law, *reference_, sampling, n);
    for (Index k = 0; k < log_.samples(); ++k) {
      out.row(k) = controller.tick(static_cast<double>(k) / log_.f_m, log_.q.row(k).transpose(),
                                   measured_.qd.row(k).transpose());
    }
    return out;
  }
  Vector x = Vector::Zero(law.states());
  Vector xd = Vector::Zero(law.states());
  Vector v(n);
  for (Index k = 0; k < log_.samples(); ++k) {
    const Vector q = measured_.q.row(k);
    const Vector qd = measured_.qd.row(k);
    const Vector q_r = reference_motion_.q.row(k);
    const Vector qd_r = reference_motion_.qd.row(k);
    const Vector qdd_r = reference_motion_.qdd.row(k);
    law.control({static_cast<double>(k) / log_.f_m, q, qd, q_r, qd_r, qdd_r}, x, v, xd);
    x += xd / log_.f_m;
    out.row(k) = v;
  }
  return out;
}

}  // namespace rivid::detail
