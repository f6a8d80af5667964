#include "rivid/simulate/measurement.hpp"

#include <cmath>
#include <limits>

#include "accept.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

// Compiled without contraction to fused operations (src/CMakeLists.txt): they would round in another way
// where the machine has them.
namespace rivid {

namespace {

constexpr int word = 32;  // [bits]

// Σ c_i x^i
template <std::size_t N>
double polynomial(const std::array<double, N>& c, double x) {
  double out = 0.0;
  for (std::size_t i = N; i-- > 0;) {
    out = out * x + c[i];
  }
  return out;
}

// ln x for x > 0: x = m 2^e with m in [√½, √2), ln m = 2 artanh((m − 1)/(m + 1)).
double logarithm(double x) {
  // to all digits: std::log() is another one on other machines
  constexpr double ln_2 = 0.69314718055994530942;
  constexpr double root_half = 0.70710678118654752440;  // to all digits
  constexpr int terms = 13;                             // the next one is below 1e-18 of the sum
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < root_half) {
    m *= 2.0;
    --e;
  }
  const double s = (m - 1.0) / (m + 1.0);
  double sum = 0.0;
  for (int k = terms; k-- > 0;) {
    sum = sum * s * s + 1.0 / (2 * k + 1);
  }
  return e * ln_2 + 2.0 * s * sum;
}

// Streams of one seed; the numbers are part of what a seed means.
enum Purpose : std::uint64_t { position_noise = 0, disturbance_torque = 1, torque_noise = 2 };

// More is a mistake of units, and would not fit into the memory.
constexpr double most_periods = 1e8;

std::optional<std::string> wrong_deviation(const char* what, const Vector& sigma, Index n) {
  if (sigma.size() != 0 && sigma.size() != n) {
    return std::string(what) + " has " + counted(sigma.size(), "entry") + ", must have one for each of " +
           counted(n, "joint");
  }
  for (Index j = 0; j < sigma.size(); ++j) {
    if (!std::isfinite(sigma[j]) || sigma[j] < 0.0) {
      return std::string(what) + " of joint " + std::to_string(j + 1) + " is " + number(sigma[j]) +
             ", a standard deviation must be zero or positive";
    }
  }
  return std::nullopt;
}

bool any(const Vector& values) { return values.size() > 0 && values.cwiseAbs().maxCoeff() > 0.0; }

void round_to(const Vector& quantum, Matrix& q) {
  for (Index j = 0; j < quantum.size(); ++j) {
    if (quantum[j] > 0.0) {
      q.col(j) = quantum[j] * (q.col(j) / quantum[j]).array().round();
    }
  }
}

// Rows before the first one that is not finite.
Index finite_rows(const Log& log) {
  for (Index k = 0; k < log.samples(); ++k) {
    for (const Matrix* const m : {&log.q, &log.tau, &log.v_tau, &log.q_r, &log.qd_r}) {
      if (!m->row(k).allFinite()) {
        return k;
      }
    }
  }
  return log.samples();
}

}  // namespace

double normal_quantile(double p) {
  if (!(p > 0.0 && p < 1.0)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    constexpr std::array a = {3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                              1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                              3.3430575583588128105e+4, 2.5090809287301226727e+3};
    constexpr std::array b = {1.0,
                              4.2313330701600911252e+1,
                              6.8718700749205790830e+2,
                              5.3941960214247511077e+3,
                              2.1213794301586595867e+4,
                              3.9307895800092710610e+4,
                              2.8729085735721942674e+4,
                              5.2264952788528545610e+3};
    const double r = 0.180625 - q * q;
    return q * polynomial(a, r) / polynomial(b, r);
  }
  const double r = std::sqrt(-logarithm(q < 0.0 ? p : 1.0 - p));
  double tail = 0.0;
  if (r <= 5.0) {
    constexpr std::array c = {1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                              3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                              2.27238449892691845833e-2, 7.74545014278341407640e-4};
    constexpr std::array d = {1.0,
                              2.05319162663775882187e0,
                              1.67638483018380384940e0,
                              6.89767334985100004550e-1,
                              1.48103976427480074590e-1,
                              1.51986665636164571966e-2,
                              5.47593808499534494600e-4,
                              1.05075007164441684324e-9};
    tail = polynomial(c, r - 1.6) / polynomial(d, r - 1.6);
  } else {
    constexpr std::array e = {6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                              2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                              2.71155556874348757815e-5, 2.01033439929228813265e-7};
    constexpr std::array f = {1.0,
                              5.99832206555887937690e-1,
                              1.36929880922735805310e-1,
                              1.48753612908506148525e-2,
                              7.86869131145613259100e-4,
                              1.84631831751005468180e-5,
                              1.42151175831644588870e-7,
                              2.04426310338993978564e-15};
    tail = polynomial(e, r - 5.0) / polynomial(f, r - 5.0);
  }
  return q < 0.0 ? -tail : tail;
}

std::array<std::uint32_t, 4> CounterNoise::bits(std::uint64_t i) const {
  constexpr std::uint64_t m_0 = 0xD2511F53;  // multiplier of Philox-4x32 [Salmon 2011]
  constexpr std::uint64_t m_1 = 0xCD9E8D57;  // the second multiplier
  constexpr std::uint32_t w_0 = 0x9E3779B9;  // step of the key: 2^32 times the fraction of the golden ratio
  constexpr std::uint32_t w_1 = 0xBB67AE85;  // the same, 2^32 (√3 − 1)
  constexpr int rounds = 10;                 // as [Salmon 2011] recommends
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> word); };
  std::array<std::uint32_t, 4> c = {low(i), high(i), low(stream_), high(stream_)};
  std::uint32_t k_0 = low(seed_);
  std::uint32_t k_1 = high(seed_);
  for (int round = 0; round < rounds; ++round) {
    const std::uint64_t p_0 = m_0 * c[0];
    const std::uint64_t p_1 = m_1 * c[2];
    c = {high(p_1) ^ c[1] ^ k_0, low(p_1), high(p_0) ^ c[3] ^ k_1, low(p_0)};
    k_0 += w_0;
    k_1 += w_1;
  }
  return c;
}

double CounterNoise::uniform(std::uint64_t i) const {
  // The middles of 2^52 equal parts, which doubles hold exactly.
  constexpr int dropped = 12;
  constexpr double part = 0x1p-52;
  const std::array<std::uint32_t, 4> b = bits(i);
  const std::uint64_t x = (static_cast<std::uint64_t>(b[0]) << word) | b[1];
  return (static_cast<double>(x >> dropped) + 0.5) * part;
}

double CounterNoise::normal(std::uint64_t i) const { return normal_quantile(uniform(i)); }

Matrix white_noise(std::uint64_t seed, std::uint64_t purpose, Index rows,
                   const Eigen::Ref<const Vector>& sigma) {
  Matrix out(rows, sigma.size());
  for (Index j = 0; j < sigma.size(); ++j) {
    const CounterNoise noise(seed, (purpose << word) | static_cast<std::uint64_t>(j));
    for (Index k = 0; k < rows; ++k) {
      out(k, j) = sigma[j] * noise.normal(static_cast<std::uint64_t>(k));
    }
  }
  return out;
}

std::optional<std::string> NoiseOptions::complaint(Index n) const {
  for (const auto& fault :
       {wrong_deviation("position_noise", position, n), wrong_deviation("torque_noise", torque, n),
        wrong_deviation("disturbance", disturbance, n)}) {
    if (fault) {
      return fault;
    }
  }
  return std::nullopt;
}

SimulationOptions with_noise(SimulationOptions options, const NoiseOptions& noise, Index n) {
  detail::accept("with_noise", noise.complaint(n));
  Sampling& sampling = options.sampling;
  const bool sampled = sampling.period > 0.0;
  const double period = sampled ? sampling.period : 1.0 / options.f_m;
  const auto drawn = [&](Purpose purpose, const Vector& sigma) {
    if (options.samples < 1) {
      throw InputError("with_noise: samples is " + std::to_string(options.samples) +
                       ", must be that of the motion which noise is drawn for");
    }
    const double periods = std::ceil(static_cast<double>(options.samples) / (options.f_m * period)) + 1.0;
    if (!(periods <= most_periods)) {
      throw InputError("with_noise: the motion has " + number(periods) + " control periods of " +
                       number(period) + " s; noise is drawn for " + number(most_periods) + " at most");
    }
    return white_noise(noise.seed, purpose, static_cast<Index>(periods), sigma);
  };
  if (!noise.feedback) {
    sampling.quantum = {};
  } else if (any(noise.position) || any(sampling.quantum)) {
    if (!sampled) {
      throw InputError(
          "with_noise: errors of the measurement go through a sampled law only; sample it, or switch the "
          "feedback off and they are in the log alone");
    }
    constexpr double clock_error = 1e-9;  // relative: any value above the rounding of the ratio
    const double ratio = 1.0 / (sampling.period * options.f_m);
    if (std::abs(ratio - std::round(ratio)) > clock_error * ratio) {
      throw InputError("with_noise: the controller measures at " + number(1.0 / sampling.period) +
                       " Hz and the log is taken at " + number(options.f_m) +
                       " Hz; the first must be a multiple of the second, so that every row is measured");
    }
    if (any(noise.position)) {
      sampling.position_noise = drawn(position_noise, noise.position);
    }
  }
  if (any(noise.disturbance)) {
    options.disturbance = drawn(disturbance_torque, noise.disturbance);
  }
  return options;
}

Log measured_log(const Simulation& simulation, const SimulationOptions& options, const NoiseOptions& noise) {
  const Index n = simulation.motion.q.cols();
  detail::accept("measured_log", noise.complaint(n));
  if (const Index quanta = options.sampling.quantum.size(); quanta != 0 && quanta != n) {
    throw InputError("measured_log: sampling.quantum has " + counted(quanta, "value") +
                     ", must have one for each of " + counted(n, "joint"));
  }
  Log out;
  out.t = simulation.t;
  out.f_m = options.f_m;
  out.q = simulation.q_measured;
  out.tau = simulation.tau;
  out.v_tau = simulation.v_tau;
  out.q_r = simulation.q_r;
  out.qd_r = simulation.qd_r;
  const Index rows = out.samples();
  if (!noise.feedback) {
    out.q = simulation.motion.q;
    if (any(noise.position)) {
      out.q += white_noise(noise.seed, position_noise, rows, noise.position);
    }
    round_to(options.sampling.quantum, out.q);
  }
  if (any(noise.torque)) {
    out.tau += white_noise(noise.seed, torque_noise, rows, noise.torque);
  }
  const Index kept = finite_rows(out);
  out.t.conservativeResize(kept);
  for (Matrix* m : {&out.q, &out.tau, &out.v_tau, &out.q_r, &out.qd_r}) {
    m->conservativeResize(kept, Eigen::NoChange);
  }
  return out;
}

}  // namespace rivid
