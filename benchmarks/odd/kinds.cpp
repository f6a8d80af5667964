#include <array>
#include <cmath>
#include <numbers>

#include "odd/recipe.hpp"

namespace rivid::odd {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// What holds for irregular and for missing samples: the controller is not what samples.
void sampled_beside_the_controller(Recipe& r) { r.continuous = true; }

// A friction law that rivid has as well, seen by encoders of any kind.
void by_law(Random& x, Recipe& r, double Fl, double Fr) {
  r.quantum = x.log_uniform(1e-6, 1e-4);
  r.Fl = Fl;
  r.Fr = Fr;
}

constexpr std::array all = {
    Kind{"good", "good", [](Random&, Recipe&) {}},

    Kind{"one_by_one", "hard", [](Random&, Recipe& r) { r.motion = Recipe::Motion::one_by_one; }},
    Kind{"short", "hard", [](Random& x, Recipe& r) { r.duration = x.uniform(3.0, 5.0); }},
    Kind{"gantry", "hard",
         [](Random& x, Recipe& r) {
           r.gantry = true;
           r.joints = x.integer(3, 6);
         }},
    Kind{"many_joints", "hard", [](Random& x, Recipe& r) { r.joints = x.integer(8, 9); }},
    Kind{"coarse_encoder", "hard", [](Random& x, Recipe& r) { r.quantum = x.log_uniform(1e-4, 1e-3); }},
    Kind{"fine_noise_encoder", "hard",
         [](Random& x, Recipe& r) {
           r.quantum = 1e-6;
           r.noise = x.log_uniform(3e-5, 3e-4);
         }},
    Kind{"tiny_amplitude", "hard", [](Random& x, Recipe& r) { r.amplitude = x.log_uniform(0.01, 0.08); }},
    Kind{"slow", "hard", [](Random& x, Recipe& r) { r.pace = x.log_uniform(0.05, 0.2); }},
    Kind{"standstill", "hard",
         [](Random& x, Recipe& r) {
           r.motion = Recipe::Motion::moves;
           r.dwell = x.log_uniform(1.5, 6.0);
           r.one_still = x.chance(0.3);
         }},
    Kind{"friction_dominates", "hard", [](Random& x, Recipe& r) { r.friction = x.uniform(4.0, 10.0); }},
    Kind{"low_bandwidth", "hard", [](Random& x, Recipe& r) { r.omega_n = x.log_uniform(2.0, 5.0); }},
    Kind{"low_rate", "hard",
         [](Random& x, Recipe& r) {
           r.rate_hz = x.one_of(std::array{50.0, 80.0, 100.0, 125.0});
           r.omega_n = x.uniform(4.0, 8.0);
         }},
    Kind{"ar_disturbance", "hard",
         [](Random& x, Recipe& r) {
           r.disturbance = x.log_uniform(0.005, 0.03);
           r.disturbance_memory = x.uniform(0.9, 0.98);
         }},
    Kind{"coarse_current", "hard", [](Random& x, Recipe& r) { r.torque_quantum = x.log_uniform(0.01, 0.05); }},
    Kind{"saturation", "hard", [](Random& x, Recipe& r) { r.saturation = x.uniform(0.65, 0.95); }},
    Kind{"delay", "hard",
         [](Random& x, Recipe& r) {
           r.continuous = false;
           r.delay = x.integer(1, 3);
         }},
    Kind{"log_subsampled", "hard",
         [](Random& x, Recipe& r) {
           r.continuous = false;
           r.control_every = x.integer(4, 10);
           r.rate_hz = x.one_of(std::array{100.0, 200.0, 250.0});
         }},

    Kind{"held_forgotten", "log",
         [](Random&, Recipe& r) {
           r.continuous = false;
           r.held_known = false;
         }},
    Kind{"misaligned", "log", [](Random& x, Recipe& r) { r.misaligned = x.integer(2, 10); }},
    Kind{"jitter_stamped", "log",
         [](Random& x, Recipe& r) {
           sampled_beside_the_controller(r);
           r.jitter = x.log_uniform(0.03, 0.3);
         }},
    Kind{"jitter_hidden", "log",
         [](Random& x, Recipe& r) {
           sampled_beside_the_controller(r);
           r.jitter = x.log_uniform(0.03, 0.3);
           r.stamped = false;
         }},
    Kind{"dropped_stamped", "log",
         [](Random& x, Recipe& r) {
           sampled_beside_the_controller(r);
           r.dropped = x.log_uniform(0.005, 0.1);
         }},
    Kind{"dropped_hidden", "log",
         [](Random& x, Recipe& r) {
           sampled_beside_the_controller(r);
           r.dropped = x.log_uniform(0.005, 0.1);
           r.stamped = false;
         }},
    Kind{"clock_1pct", "log", [](Random& x, Recipe& r) { r.clock = 1.0 + 0.01 * x.sign(); }},
    Kind{"torque_filtered", "log", [](Random& x, Recipe& r) { r.torque_filter_hz = x.log_uniform(5.0, 20.0); }},
    Kind{"position_filtered", "log",
         [](Random& x, Recipe& r) { r.position_filter_hz = x.log_uniform(5.0, 20.0); }},
    Kind{"torque_spikes", "log", [](Random& x, Recipe& r) { r.spikes = x.log_uniform(0.002, 0.02); }},

    Kind{"bursty_stamps", "log", [](Random& x, Recipe& r) { r.bursts = x.log_uniform(0.003, 0.03); }},
    Kind{"gain_drift", "log", [](Random& x, Recipe& r) { r.gain_drift = x.uniform(0.05, 0.3) * x.sign(); }},
    Kind{"eccentric_encoder", "log", [](Random& x, Recipe& r) { r.eccentricity = x.log_uniform(1e-4, 3e-3); }},
    Kind{"other_arm", "log", [](Random&, Recipe& r) { r.other_arm = true; }},

    Kind{"stribeck", "physics", [](Random& x, Recipe& r) { r.stribeck = x.uniform(0.3, 1.0); }, true},
    Kind{"asymmetric", "physics", [](Random& x, Recipe& r) { r.asymmetry = x.uniform(0.1, 0.4); }, true},
    Kind{"load_friction", "physics", [](Random& x, Recipe& r) { r.load_friction = x.uniform(0.03, 0.12); }, true},
    Kind{"friction_drift", "physics", [](Random& x, Recipe& r) { r.drift = x.uniform(0.3, 0.6); }, true},
    Kind{"elastic", "physics", [](Random& x, Recipe& r) { r.elastic_hz = x.log_uniform(12.0, 40.0); }},
    Kind{"elastic_at_links", "physics",
         [](Random& x, Recipe& r) {
           r.elastic_hz = x.log_uniform(12.0, 40.0);
           r.at_links = true;
         }},
    Kind{"backlash", "physics",
         [](Random& x, Recipe& r) {
           r.elastic_hz = x.log_uniform(20.0, 40.0);
           r.backlash = x.log_uniform(1e-4, 3e-3);
         }},
    Kind{"spring", "physics", [](Random& x, Recipe& r) { r.spring = x.uniform(0.1, 0.5); }, true},
    Kind{"ripple", "physics", [](Random& x, Recipe& r) { r.ripple = x.log_uniform(0.02, 0.1); }},
    Kind{"payload_mid", "physics", [](Random& x, Recipe& r) { r.payload = x.uniform(0.2, 0.6); }},
    Kind{"payload_for_a_while", "physics",
         [](Random& x, Recipe& r) {
           r.payload = x.uniform(0.2, 0.6);
           r.put_down = true;
         }},

    Kind{"torque_sign", "user", [](Random&, Recipe& r) { r.belief = Recipe::Belief::torque_sign; }},
    Kind{"swapped", "user", [](Random&, Recipe& r) { r.belief = Recipe::Belief::swapped; }},
    Kind{"deg_rad", "user", [](Random&, Recipe& r) { r.belief = Recipe::Belief::deg_rad; }},
    Kind{"mNm", "user", [](Random&, Recipe& r) { r.belief = Recipe::Belief::mNm; }},
    Kind{"gain_20pct", "user",
         [](Random& x, Recipe& r) {
           r.belief = Recipe::Belief::gain;
           r.gain_factor = 1.0 + 0.2 * x.sign();
         }},
    Kind{"geometry_5mm", "user",
         [](Random&, Recipe& r) {
           r.belief = Recipe::Belief::shifted_joint;
           r.shift = 0.005;
         }},
    Kind{"geometry_1deg", "user",
         [](Random&, Recipe& r) {
           r.belief = Recipe::Belief::turned_joint;
           r.turn = degree;
         }},
    Kind{"gravity_tilt", "user",
         [](Random& x, Recipe& r) {
           r.belief = Recipe::Belief::tilted;
           r.turn = x.uniform(2.0, 6.0) * degree;
         }},
    Kind{"gravity_axis", "user", [](Random&, Recipe& r) { r.belief = Recipe::Belief::on_a_wall; }},
    Kind{"gain_and_zero", "user",
         [](Random& x, Recipe& r) {
           r.belief = Recipe::Belief::gain_and_zero;
           r.gain_factor = 1.0 + 0.2 * x.sign();
           r.turn = x.log_uniform(0.02, 0.15) * x.sign();
         }},
    Kind{"coupling", "user",
         [](Random& x, Recipe& r) {
           r.belief = Recipe::Belief::coupled;
           r.coupling = x.uniform(0.2, 1.0) * x.sign();
         }},
    Kind{"zero_offset", "user",
         [](Random& x, Recipe& r) {
           r.belief = Recipe::Belief::zero_offset;
           r.turn = x.log_uniform(0.02, 0.15) * x.sign();
         }},

    Kind{"law_symmetric", "laws", [](Random& x, Recipe& r) { by_law(x, r, 0.0, 0.0); }},
    Kind{"law_load", "laws", [](Random& x, Recipe& r) { by_law(x, r, x.uniform(0.03, 0.12), 0.0); }},
    Kind{"law_root", "laws", [](Random& x, Recipe& r) { by_law(x, r, 0.0, x.uniform(0.3, 1.0)); }},
    Kind{"law_load_root", "laws",
         [](Random& x, Recipe& r) { by_law(x, r, x.uniform(0.03, 0.12), x.uniform(0.3, 1.0)); }},
    Kind{"law_asymmetric", "laws",
         [](Random& x, Recipe& r) {
           by_law(x, r, 0.0, 0.0);
           r.asymmetry = x.uniform(0.1, 0.4);
         },
         true},

    Kind{"no_rotor", "no_rotor", [](Random&, Recipe& r) { r.rotors = false; }},
};

void moves_with_rests(Recipe& r, double rest) {
  r.motion = Recipe::Motion::moves;
  r.dwell = rest;
}

constexpr std::array all_ways = {
    Way{"fourier", [](Random&, Recipe& r) { r.motion = Recipe::Motion::fourier; }},
    Way{"pick_and_place", [](Random& x, Recipe& r) { moves_with_rests(r, x.uniform(0.1, 0.5)); }},
    Way{"waits", [](Random& x, Recipe& r) { moves_with_rests(r, x.uniform(1.5, 4.0)); }},
    Way{"hand",
        [](Random& x, Recipe& r) {
          moves_with_rests(r, 0.0);
          r.pace = x.uniform(0.3, 0.8);
          r.amplitude *= 0.5;
        }},
    Way{"jogging",
        [](Random&, Recipe& r) {
          r.motion = Recipe::Motion::one_by_one;
          r.duration = 4.0 * r.joints + 4.0;
        }},
    Way{"raster", [](Random&, Recipe& r) { r.motion = Recipe::Motion::raster; }},
    Way{"short", [](Random& x, Recipe& r) { r.duration = x.uniform(3.0, 5.0); }},
};

// The fastest loop that a sampled law keeps stable, as bandwidth times period.
constexpr double most_bandwidth_times_period = 0.12;

}  // namespace

std::span<const Kind> kinds() { return all; }

std::span<const Way> ways() { return all_ways; }

Recipe drawn_recipe(const Kind& kind, const Way* way, Random& random, bool sound) {
  Recipe out;
  out.joints = random.integer(2, 7);
  out.motion = random.chance(0.6) ? Recipe::Motion::fourier : Recipe::Motion::moves;
  out.amplitude = random.uniform(0.5, 1.2);
  out.pace = random.uniform(0.8, 1.5);
  out.dwell = random.uniform(0.1, 0.5);
  out.duration = random.uniform(8.0, 14.0);
  out.continuous = random.chance(0.4);
  out.integral = random.chance(0.5);
  out.omega_n = random.log_uniform(8.0, 40.0);
  out.rate_hz = random.one_of(std::array{200.0, 250.0, 500.0, 500.0, 1000.0});
  out.quantum = random.log_uniform(1e-6, 2e-5);
  out.noise = random.uniform(0.0, 1.0) * out.quantum;
  out.torque_noise = random.log_uniform(0.001, 0.02);
  out.has_reference = random.chance(0.8);
  Recipe odd = out;
  kind.change(random, odd);
  if (!sound) {
    out = odd;
  }
  if (way != nullptr) {
    way->change(random, out);
  }
  // Few descriptions have the masses that the arm has.
  using enum Recipe::Bodies;
  out.bodies = random.one_of(std::array{right, off, off, off, alike, none});
  const double control_hz = out.rate_hz * out.control_every;
  const int periods = 1 + out.delay;
  out.omega_n = std::min(out.omega_n, most_bandwidth_times_period * control_hz / periods);
  return out;
}

}  // namespace rivid::odd
