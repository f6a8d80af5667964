// shift NAME …: a shift of pick and place on Plant, an arm outside the library. Links Eigen alone.

#include <chrono>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <type_traits>
#include <variant>

#include "plant.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/robot_state.hpp"

namespace rivid::benchmarks {
namespace {

struct Settings {
  int arm = 6;
  int cycles = 50;
  double f_m = 1000.0;
  double warm = 1.0;  // factor of friction since the identification
  double load = 0.03;
  double ripple = 0.02;
  double stribeck = 0.15;
  double stiction = 1.0;
  double bad = 0.0;         // share of each kind of bad ticks
  int still = -1;           // joints that stay where they are; -1: 0 … 3
  bool model_load = false;  // whether the model has friction by load
  std::uint64_t seed = 1;
  double hours = 0.5;
  int state = 0;  // whether RobotState takes the ticks
  int say = 0;    // the gripper is told
  double learn = 300.0;
  double drift = 0.2;    // of friction in eight hours
  double change = -1.0;  // friction_change
  double lf = 0.02;
  double push = 20.0;  // seconds from one push to the next; 0: none
  double fixed = 1.1;  // thresholds of the other observer, over the largest residual while it learned
  bool holds = false;  // at rest friction takes what it can of a push
  double speed = 0.3;  // of moves between static poses; 0: none is seen [rad/s]
};

// Hands ticks over, some of them badly.
class Line {
 public:
  Line(RobotState<double>& state, double f_m, double bad, std::uint64_t seed)
      : state_(state), f_m_(f_m), bad_(bad), random_(seed) {}
  void operator()(const Vector& q, const Vector& tau) {
    ++k_;
    const double t = static_cast<double>(k_) / f_m_;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double x = unit(random_);
    if (x < bad_) {                                // lost
    } else if (x < 2.0 * bad_ && q_.size() > 0) {  // repeated
      state_.update(t, q_, tau_);
    } else if (x < 3.0 * bad_) {  // late
      state_.update(t + 0.6 / f_m_, q, tau);
    } else if (x < 4.0 * bad_) {  // glitch
      Vector a = q;
      Vector b = tau;
      const auto j = static_cast<Index>(random_() % static_cast<std::uint64_t>(q.size()));
      (unit(random_) < 0.5 ? a[j] : b[j]) += unit(random_) < 0.5 ? 0.05 : 100.0;
      state_.update(t, a, b);
    } else {
      state_.update(t, q, tau);
    }
    q_ = q;
    tau_ = tau;
  }

 private:
  RobotState<double>& state_;
  double f_m_, bad_;
  std::mt19937_64 random_;
  Index k_ = 0;
  Vector q_, tau_;
};

Inertial part(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double mass = 0.3 * std::pow(5.0 / 0.3, unit(random));
  const Eigen::Vector3d com(0.1 * unit(random) - 0.05, 0.1 * unit(random) - 0.05, 0.05 + 0.1 * unit(random));
  const double a = 0.05;
  return inertial_from_com(mass, com,
                           Eigen::Matrix3d((mass / 3.0 * 2 * a * a * Eigen::Vector3d::Ones()).asDiagonal()));
}

struct Shares {
  int in = 0, all = 0;
  void take(bool yes) {
    in += yes ? 1 : 0;
    ++all;
  }
  [[nodiscard]] double percent() const { return 100.0 * in / std::max(all, 1); }
};

// Mean share of changes that an observer misses which knows their direction, with a false alarm in ten hours.
struct Ideal {
  double quantile;  // of one window in ten hours
  double lost = 0.0;
  int all = 0;
  // deviations  by which the change shows
  void take(double deviations) {
    lost += 0.5 * std::erfc((deviations - quantile) / std::numbers::sqrt2);
    ++all;
  }
  [[nodiscard]] double percent() const { return 100.0 * lost / std::max(all, 1); }
};

// Covariance of the payload.
Matrix covariance(PayloadEstimator<double> estimator) {
  estimator.finish();
  return std::get<11>(estimator.state()) * estimator.misfit();
}

// Deviations by which rows show a change.
double shown(const Matrix& C, const Vector& change) { return std::sqrt(change.dot(C.ldlt().solve(change))); }

void run(const Settings& s) {
  Plant plant(s.arm == 6 ? tx40() : panda(), 5);
  plant.friction.load = s.load;
  plant.friction.ripple = s.ripple;
  plant.friction.stribeck = s.stribeck;
  plant.friction.stiction = s.stiction;
  const OnlineModel model =
      identified_plant(plant, s.model_load ? Friction::load : Friction::symmetric, 3, s.f_m);
  std::cerr << "sigma_rho " << model.sigma_rho.transpose() << '\n';
  const Index n = model.robot.size();
  PayloadEstimatorOptions options;
  options.rows.f_m = s.f_m;
  options.rows.torque_held = false;
  options.load_friction = s.lf;
  if (s.change >= 0.0) {
    options.friction_change = s.change;
  }
  PayloadEstimator<double> alone(model, options);
  PayloadEstimator<double> told(model, options);  // forecasts what the rows since a change say
  RobotStateOptions all;
  if (s.change < 0.0) {
    options.friction_change = 0.2;
  }
  all.payload = options;
  all.payload.longest_touch = 1.0;
  all.learn = 20.0;
  RobotState<double> state(model, DynamicModel(model.robot, model.base, model.chi), all);
  const PayloadEstimator<double>& estimator = s.state ? state.estimator() : alone;
  Line line(state, s.f_m, s.bad, s.seed + 99);
  Index seen = 0;
  std::mt19937_64 random(s.seed);
  Shares missed, mass2, mass, com, good_off, missed_release;
  Shares unnamed;  // changes that estimates of before and after, told when, do not show: χ² of 4 in ten hours
  std::vector<double> delays;
  Ideal soon{4.3}, soon_told{4.3}, later_told{3.9}, later{3.9};  // windows of 0.3 s, and of 2 s
  int false_changes = 0, good_count = 0;
  double width = 0.0, error2 = 0.0;
  PlantTorques torques(plant, Inertial::Zero(), s.seed + 9);
  PickAndPlace motion(n, s.seed + 10);
  const double dt = 1.0 / s.f_m;
  Inertial body = Inertial::Zero();
  for (int cycle = 0; cycle < s.cycles; ++cycle) {
    for (int half = 0; half < 2; ++half) {
      const bool loaded = half == 1;
      const Inertial body_before = body;
      const double mass_before = body[9];
      PlantTorques unchanged = torques;
      const Matrix before = covariance(estimator);
      body = loaded ? part(random) : Inertial(Inertial::Zero());
      torques.set_body(body);
      told.payload_changed();
      if (s.say && (cycle > 0 || half > 0)) {
        s.state ? state.gripper(!loaded) : alone.gripper(!loaded);
        seen = state.payload_changes();
      }
      if (half == 0) {
        std::vector<int> order(static_cast<std::size_t>(n));
        std::iota(order.begin(), order.end(), 0);
        std::shuffle(order.begin(), order.end(), random);
        std::fill(motion.still.begin(), motion.still.end(), false);
        const int still = s.still >= 0 ? s.still : static_cast<int>(random() % 4);
        for (int i = 0; i < still; ++i) {
          motion.still[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])] = true;
        }
      }
      const Inertial estimate_before = estimator.inertial();
      double moved = 0.0, found = -1.0;
      double squares = 0.0, shown_soon = -1.0;  // of the change in rows to one who knows the arm
      bool checked2 = false;
      bool stop = false;
      const double length = loaded ? 8.0 : 6.0;
      for (double t = 0.0; !stop; t += dt) {
        const bool rest_begins = motion.step(dt);
        stop = t > length && (rest_begins || (cycle % 2 == 1 && t > length + 1.0));
        const Vector driven = torques(motion.q, motion.qd, motion.qdd, s.warm);
        const Vector added = driven - unchanged(motion.q, motion.qd, motion.qdd, s.warm);
        const Vector tau = torques.measured(driven);
        const Vector q = torques.encoder(motion.q);
        const bool fast = (motion.qd.cwiseAbs().array() > 0.02).any();
        moved += fast ? dt : 0.0;
        told.update(q, tau);
        for (Index j = 0; j < n && moved <= 0.3; ++j) {
          const double over =
              std::abs(motion.qd[j]) > 0.02 ? added[j] / told.row_sigma(j, motion.qd[j]) : 0.0;
          squares += over * over * dt / 0.025;
        }
        if (moved > 0.3 && shown_soon < 0.0) {
          shown_soon = shown(covariance(told), body - body_before);
        }
        bool changed = false;
        if (s.state) {
          line(q, tau);
          changed = state.payload_changes() != seen;
          seen = state.payload_changes();
        } else {
          changed = alone.update(q, tau);
        }
        if (changed) {
          if (found < 0.0 && (cycle > 0 || half > 0)) {
            found = moved;
          } else {
            ++false_changes;
            std::cerr << "false change cycle " << cycle << " half " << half << " moved " << moved << " body "
                      << body[9] << '\n';
          }
        }
        const auto& p = estimator.payload();
        const double sigma = p.mass_sigma;
        if (p.good) {
          ++good_count;
          good_off.take(std::abs(p.mass - body[9]) > 3.0 * sigma + 1e-9 && moved > 0.5);
        }
        if (!checked2 && moved >= 2.0 && (cycle > 0 || half > 0)) {
          checked2 = true;
          const double delta = std::abs(body[9] - mass_before);
          if (const double forecast = told.payload().mass_sigma; delta > 3.0 * forecast) {
            (loaded ? missed : missed_release).take(found < 0.0);
            soon.take(std::sqrt(squares));
            soon_told.take(shown_soon);
            later_told.take(shown(covariance(told), body - body_before));
            later.take(shown(before + covariance(told), body - body_before));
            unnamed.take(shown((before + covariance(told)).bottomRightCorner(4, 4),
                               (told.inertial() - estimate_before).tail(4)) < 5.0);
            if (found >= 0.0) {
              delays.push_back(found);
            } else {
              std::cerr << "missed cycle " << cycle << " half " << half << " delta " << delta << " sigma "
                        << sigma << " estimate " << p.mass << '\n';
            }
          }
          if (loaded) {
            mass2.take(std::abs(p.mass - body[9]) <= 1.96 * sigma);
            width += 1.96 * sigma;
            error2 += std::abs(p.mass - body[9]);
          }
        }
      }
      const auto& p = estimator.payload();
      if (loaded) {
        mass.take(std::abs(p.mass - body[9]) <= 1.96 * p.mass_sigma);
        if (std::abs(p.mass - body[9]) > 4.0 * p.mass_sigma) {
          std::cerr << "far off: cycle " << cycle << " true " << body[9] << " est " << p.mass << " sigma "
                    << p.mass_sigma << (p.good ? " GOOD" : "") << '\n';
        }
        if (p.held) {
          for (Index i = 0; i < 3; ++i) {
            com.take(std::abs(p.com[i] - body[6 + i] / body[9]) <= 1.96 * p.com_sigma[i]);
          }
        }
      }
    }
  }
  std::sort(delays.begin(), delays.end());
  const auto at = [&](double x) {
    return delays.empty() ? -1.0
                          : delays[static_cast<std::size_t>(x * static_cast<double>(delays.size() - 1))];
  };
  std::cout << "arm " << s.arm << " f " << s.f_m << " load " << s.load
            << (s.model_load ? " modelled" : " not modelled") << " warm " << s.warm << " still " << s.still
            << " bad " << s.bad << ": missed " << missed.in << "/" << missed.all << " releases "
            << missed_release.in << "/" << missed_release.all << " false " << false_changes
            << " delay 50/95/99/max " << at(0.5) << " " << at(0.95) << " " << at(0.99) << " " << at(1.0)
            << " ideal: late [%] " << soon.percent() << " as the arm is known " << soon_told.percent()
            << " missed [%] " << later_told.percent() << " as the payload before is known " << later.percent()
            << " as the time alone is known " << unnamed.percent() << " cover mass at 2 s " << mass2.percent()
            << " at end " << mass.percent() << " com " << com.percent() << " half width 2 s "
            << width / std::max(mass2.all, 1) << " error " << error2 / std::max(mass2.all, 1)
            << " good>3sigma ticks " << good_off.in << "/" << good_off.all << std::endl;
}

struct Event {
  bool collision;
  Index link;
  double begin, length;
  Eigen::Vector3d force;
  bool moving = false;  // when it began
  bool seen_state = false, seen_fixed = false, right_link = false, right_first = false;
  double shown = 0.0;  // Σ (torque that it adds to a drive's / noise of that)²
  double delay_state = -1.0;

  // Part of such events that an observer sees which knows the arm, the friction of each tick and all of the
  // push but whether it happens, with a false alarm an hour.
  [[nodiscard]] double ideal() const {
    constexpr double quantile = 3.6;  // of one in the half seconds of an hour
    return 0.5 * std::erfc((quantile - std::sqrt(shown)) / std::numbers::sqrt2);
  }
};

void contacts(const Settings& s) {
  Plant plant(s.arm == 6 ? tx40() : panda(), 5);
  plant.friction.load = s.load;
  plant.friction.ripple = s.ripple;
  plant.friction.stribeck = s.stribeck;
  plant.friction.stiction = s.stiction;
  plant.friction.holds = s.holds;
  const OnlineModel model =
      identified_plant(plant, s.model_load ? Friction::load : Friction::symmetric, 3, s.f_m);
  const Index n = model.robot.size();
  RobotStateOptions all;
  all.payload.rows.f_m = s.f_m;
  all.payload.rows.torque_held = false;
  all.payload.load_friction = s.lf;
  all.payload.longest_touch = 1.0;
  all.learn = s.learn;
  const DynamicModel dynamics(model.robot, model.base, model.chi);
  RobotState<double> state(model, dynamics, all);
  ContactObserver<double> fixed(dynamics, {.f_m = s.f_m});
  Vector limit = Vector::Zero(n);
  PlantTorques torques(plant, Inertial::Zero(), s.seed + 9);
  PlantTorques calm = torques;  // the same without pushes
  PickAndPlace motion(n, s.seed + 10);
  Line line(state, s.f_m, s.bad, s.seed + 99);
  std::mt19937_64 random(s.seed);
  std::normal_distribution<double> normal;
  std::vector<Event> events;
  const double dt = 1.0 / s.f_m;
  double next = s.push > 0.0 ? s.learn + 10.0 : 1e9;
  Index at = 0;
  int false_state = 0, false_fixed = 0, false_collisions = 0, changes = 0;
  bool was = false, was_fixed = false, was_collision = false;
  double last_event = -10.0, fixed_until = -1.0, alarm_state = 0.0, alarm_fixed = 0.0;
  Vector before, velocity = Vector::Zero(n);
  for (double t = 0.0; t < 3600.0 * s.hours; t += dt, ++at) {
    motion.step(dt);
    const double warm = s.warm * (1.0 - s.drift * t / (8.0 * 3600.0));
    if (t >= next) {
      next += s.push;
      const bool collision = random() % 2 == 0;
      const Index link = 2 + static_cast<Index>(random() % 4);
      const Eigen::Vector3d direction =
          Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      events.push_back({collision, link, t, collision ? 0.02 : 0.5, (collision ? 100.0 : 20.0) * direction,
                        motion.moving()});
    }
    const bool on = !events.empty() && t < events.back().begin + events.back().length;
    torques.external.setZero();
    if (on) {
      torques.external = torques_of_force(plant.robot, motion.q, events.back().link, events.back().force);
      last_event = t;
    }
    const Vector driven = torques(motion.q, motion.qd, motion.qdd, warm);
    const Vector alone = calm(motion.q, motion.qd, motion.qdd, warm);
    if (on && (!events.back().collision || t < events.back().begin + 0.015)) {
      events.back().shown += (driven - alone).cwiseQuotient(plant.torque_noise).squaredNorm();
    }
    const Vector tau = torques.measured(driven);
    const Vector q = torques.encoder(motion.q);
    line(q, tau);
    if (before.size() > 0) {
      velocity += (1.0 - std::exp(-dt / 0.003)) * ((q - before) / dt - velocity);
    }
    before = q;
    fixed.update(q, velocity, tau);
    if (t < s.learn) {
      if (t > 1.0) {
        limit = limit.cwiseMax(fixed.residual().cwiseAbs());
      }
      continue;
    }
    const bool fixed_on = (fixed.residual().cwiseAbs().array() > s.fixed * limit.array()).any();
    fixed_until = fixed_on ? t + 0.1 : fixed_until;
    const bool fixed_now = t < fixed_until;
    const bool after = t < last_event + 1.0;
    const bool now = state.contact();
    if (on || (!events.empty() && t < events.back().begin + events.back().length + 0.005)) {
      Event& e = events.back();
      const bool hit = e.collision ? state.collision() || now : now || state.collision();
      if (hit && !e.seen_state) {
        e.seen_state = true;
        e.delay_state = t - e.begin;
        e.right_first = state.observer().link() == e.link;
      }
      if (on && now) {
        e.right_link = state.observer().link() == e.link;
      }
      e.seen_fixed = e.seen_fixed || fixed_on;
    }
    if (!after) {
      alarm_state += now ? dt : 0.0;
      alarm_fixed += fixed_now ? dt : 0.0;
      false_state += now && !was ? 1 : 0;
      false_collisions += state.collision() && !was_collision && !now ? 1 : 0;
      false_fixed += fixed_now && !was_fixed ? 1 : 0;
    }
    was = now;
    was_collision = state.collision();
    was_fixed = fixed_now;
  }
  changes = static_cast<int>(state.payload_changes());
  for (const bool collision : {false, true}) {
    Shares ours, theirs, link, first, quick, moving, resting;
    std::vector<Shares> by_link(6);
    double ideal = 0.0, ideal_at_rest = 0.0;
    for (const Event& e : events) {
      if (e.collision == collision) {
        ours.take(e.seen_state);
        (e.moving ? moving : resting).take(e.seen_state);
        ideal += e.ideal();
        ideal_at_rest += e.moving ? 0.0 : e.ideal();
        theirs.take(e.seen_fixed);
        quick.take(e.seen_state && e.delay_state <= 0.0151);
        by_link[static_cast<std::size_t>(e.link)].take(e.seen_state);
        if (e.seen_state) {
          link.take(e.right_link);
          first.take(e.right_first);
        }
      }
    }
    std::cout << (collision ? "collisions " : "pushes ") << ours.all << ": seen " << ours.percent()
              << " % (in 15 ms " << quick.percent() << "), fixed " << theirs.percent() << " %, link at end "
              << link.percent() << " first " << first.percent() << ", moving " << moving.percent()
              << " resting " << resting.percent() << ", ideal observer "
              << 100.0 * ideal / std::max(ours.all, 1) << ", resting "
              << 100.0 * ideal_at_rest / std::max(resting.all, 1) << ", by link 3-6:";
    for (std::size_t j = 2; j < 6; ++j) {
      std::cout << ' ' << by_link[j].percent();
    }
    std::cout << '\n';
  }
  std::cout << "hours " << s.hours - s.learn / 3600.0 << ": false contacts " << false_state
            << " + collisions " << false_collisions << " (" << alarm_state << " s), fixed " << false_fixed
            << " (" << alarm_fixed << " s), payload changes " << changes << ", payload "
            << state.payload().mass << " sigma " << state.payload().mass_sigma << " drift/identified of Fc:";
  for (const auto& c : state.estimator().friction()) {
    if (c.parameter.kind == ParameterKind::Fc) {
      std::cout << ' ' << c.value / c.identified;
    }
  }
  std::cout << "\nlevels:";
  for (Index j = 0; j < n; ++j) {
    std::cout << ' ' << state.observer().level(j);
  }
  const auto& c = state.counts();
  std::cout << " counts " << c.taken << ' ' << c.lost << ' ' << c.gaps << ' ' << c.repeated << ' ' << c.late
            << ' ' << c.glitches << std::endl;
}

// Half width of the mass's 95 % interval of one who knows the arm, that friction holds a joint by anything up
// to `most`, and what it did: all payloads that leave no more than that to friction, by hit and run.
double ideal_half_width(const Plant& plant, const std::vector<Vector>& poses, const std::vector<Vector>& held,
                        const Vector& most, std::mt19937_64& random) {
  const Index n = plant.robot.size();
  const Vector zero = Vector::Zero(n);
  Matrix columns(n * std::ssize(poses), 4);
  Vector friction(columns.rows());
  const auto weight = [&](const Vector& q, const Inertial& body) {
    Vector tau(n);
    InverseDynamics(DynamicModel(plant.robot, test::loaded(plant.robot, plant.chi_st, body)))
        .rigid_body(q, zero, zero, tau);
    return tau;
  };
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (Index k = 0; k < 4; ++k) {
      columns.block(static_cast<Index>(i) * n, k, n, 1) =
          weight(poses[i], Inertial::Unit(6 + k)) - weight(poses[i], Inertial::Zero());
    }
    friction.segment(static_cast<Index>(i) * n, n) = held[i];
  }
  std::normal_distribution<double> normal;
  std::vector<double> mass;
  double off = 0.0;
  for (int step = 0; step < 20000; ++step) {
    const Eigen::Vector4d way(0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random),
                              normal(random));
    const Vector slope = columns * way;
    double low = -1e9, high = 1e9;
    for (Index i = 0; i < slope.size(); ++i) {
      const double a = (friction[i] - most[i % n]) / slope[i];
      const double b = (friction[i] + most[i % n]) / slope[i];
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    }
    const double by = std::uniform_real_distribution<double>(low, high)(random);
    friction -= by * slope;
    off += by * way[3];
    mass.push_back(off);
  }
  std::sort(mass.begin(), mass.end());
  return 0.5 * (mass[mass.size() * 39 / 40] - mass[mass.size() / 40]);
}

// Four poses with rests of a second, slow moves between.
void poses(const Settings& s) {
  Shares cover, com, three, near;
  double error = 0.0, width = 0.0, com_error = 0.0, ideal = 0.0;
  for (int run = 0; run < s.cycles; ++run) {
    Plant plant(tx40(), 5);
    plant.friction.load = s.load;
    plant.friction.stiction = s.stiction;
    const OnlineModel model =
        identified_plant(plant, s.model_load ? Friction::load : Friction::symmetric, 3, s.f_m);
    PayloadEstimatorOptions options;
    options.rows.f_m = s.f_m;
    options.rows.torque_held = false;
    PayloadEstimator<double> estimator(model, options);
    PlantTorques torques(plant, Inertial::Zero(), s.seed + 9 + static_cast<std::uint64_t>(run));
    std::mt19937_64 random(s.seed + static_cast<std::uint64_t>(run));
    std::uniform_real_distribution<double> symmetric(-1.2, 1.2);
    const Inertial body = inertial_from_com(2.0, {0.03, -0.02, 0.08},
                                            Eigen::Matrix3d(Eigen::Vector3d::Constant(0.005).asDiagonal()));
    const Vector zero = Vector::Zero(6);
    std::vector<Vector> places, held;
    Vector q = zero;
    for (int pose = 0; pose < 14; ++pose) {
      if (pose == 10) {
        torques.set_body(body);
        estimator.payload_changed();
      }
      const Vector from = q;
      for (double& x : q) {
        x = symmetric(random);
      }
      const auto tick = [&](const Vector& at, const Vector& qd, const Vector& qdd) {
        const Vector tau = torques(at, qd, qdd, s.warm);
        estimator.update(torques.encoder(at), torques.measured(tau));
        return tau;
      };
      const Vector way = q - from;
      const double duration = s.speed > 0.0 ? 1.875 * way.cwiseAbs().maxCoeff() / s.speed : 0.0;
      for (double t = 0.0; t < duration; t += 1.0 / s.f_m) {
        const double x = t / duration;
        tick(from + x * x * x * (10.0 - 15.0 * x + 6.0 * x * x) * way,
             30.0 * x * x * (1.0 - 2.0 * x + x * x) / duration * way,
             (60.0 * x - 180.0 * x * x + 120.0 * x * x * x) / (duration * duration) * way);
      }
      torques(q, Vector::Ones(6), zero, 1.0);  // it has moved: friction holds otherwise
      Vector tau;
      for (Index k = 0; k < static_cast<Index>(s.f_m); ++k) {
        tau = tick(q, zero, zero);
      }
      if (pose >= 10) {
        Vector weight(6);
        InverseDynamics(DynamicModel(plant.robot, test::loaded(plant.robot, plant.chi_st, body)))
            .rigid_body(q, zero, zero, weight);
        places.push_back(q);
        held.emplace_back(tau - weight);
      }
    }
    estimator.finish();
    const auto& p = estimator.payload();
    cover.take(std::abs(p.mass - 2.0) <= 1.96 * p.mass_sigma);
    three.take(std::abs(p.mass - 2.0) <= 0.06);
    error += std::abs(p.mass - 2.0) / s.cycles;
    width += 1.96 * p.mass_sigma / s.cycles;
    ideal +=
        ideal_half_width(plant, places, held, s.warm * s.stiction * plant.friction.Fc, random) / s.cycles;
    for (Index i = 0; i < 3 && p.held; ++i) {
      const double off = std::abs(p.com[i] - body[6 + i] / 2.0);
      com.take(off <= 1.96 * p.com_sigma[i]);
      near.take(off <= 0.005);
      com_error += off;
    }
  }
  std::cout << "four poses, stiction " << s.stiction << " speed " << s.speed << ": mass covered "
            << cover.percent() << " within 3 % " << three.percent() << " mean error " << error
            << " half width " << width << " (at rest alone, friction's limits known: " << ideal
            << "), com covered " << com.percent() << " within 5 mm " << near.percent() << " mean error "
            << com_error / std::max(com.all, 1) << std::endl;
}

void ticks(const Settings& s) {
  Plant plant(s.arm == 6 ? tx40() : panda(), 5);
  const OnlineModel model = identified_plant(plant, Friction::symmetric, 3, s.f_m);
  RobotStateOptions all;
  all.payload.rows.f_m = s.f_m;
  all.payload.rows.torque_held = false;
  RobotState<double> state(model, DynamicModel(model.robot, model.base, model.chi), all);
  PlantTorques torques(plant, Inertial::Zero(), 3);
  PickAndPlace motion(model.robot.size(), 4);
  std::vector<Vector> q, tau;
  for (Index k = 0; k < 20000; ++k) {
    motion.step(1.0 / s.f_m);
    q.push_back(torques.encoder(motion.q));
    tau.push_back(torques.measured(torques(motion.q, motion.qd, motion.qdd, 1.0)));
  }
  std::vector<double> us(q.size() / 2, 1e9);
  for (std::size_t k = 0; k < q.size() / 2; ++k) {
    state.update(static_cast<double>(k) / s.f_m, q[k], tau[k]);
  }
  std::vector<std::byte> bytes(state_size(state));
  static_cast<void>(save_state(state, bytes));
  for (int i = 0; i < s.cycles; ++i) {
    static_cast<void>(restore_state(state, bytes));
    for (std::size_t k = q.size() / 2; k < q.size(); ++k) {
      const auto begin = std::chrono::steady_clock::now();
      state.update(static_cast<double>(k) / s.f_m, q[k], tau[k]);
      us[k - q.size() / 2] = std::min(
          us[k - q.size() / 2],
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  std::sort(us.begin(), us.end());
  std::cout << "tick of RobotState: median " << us[us.size() / 2] << " us, 99 % " << us[us.size() * 99 / 100]
            << ", worst " << us.back() << std::endl;
}

// Settings by their words: all are numbers.
std::map<std::string, std::variant<int*, double*, bool*, std::uint64_t*>> words_of(Settings& s) {
  return {{"arm", &s.arm},           {"cycles", &s.cycles}, {"f", &s.f_m},       {"warm", &s.warm},
          {"load", &s.load},         {"ripple", &s.ripple}, {"bad", &s.bad},     {"stribeck", &s.stribeck},
          {"stiction", &s.stiction}, {"still", &s.still},   {"hours", &s.hours}, {"modelled", &s.model_load},
          {"state", &s.state},       {"say", &s.say},       {"learn", &s.learn}, {"drift", &s.drift},
          {"change", &s.change},     {"push", &s.push},     {"lf", &s.lf},       {"seed", &s.seed},
          {"holds", &s.holds},       {"speed", &s.speed},   {"fixed", &s.fixed}};
}

}  // namespace
}  // namespace rivid::benchmarks

int main(int argc, char** argv) {
  using namespace rivid::benchmarks;
  const std::map<std::string, void (*)(const Settings&)> studies = {
      {"pick", run}, {"contacts", contacts}, {"poses", poses}, {"ticks", ticks}};
  Settings settings;
  const auto words = words_of(settings);
  const auto study = argc > 1 ? studies.find(argv[1]) : studies.end();
  bool known = study != studies.end() && argc % 2 == 0;
  for (int i = 2; known && i < argc; i += 2) {
    const auto word = words.find(argv[i]);
    known = word != words.end();
    if (known) {
      std::visit(
          [&](auto* to) { *to = static_cast<std::remove_pointer_t<decltype(to)>>(std::atof(argv[i + 1])); },
          word->second);
    }
  }
  if (!known) {
    std::cerr << "usage: benchmark_online_shift STUDY [SETTING NUMBER ...]\nstudies:";
    for (const auto& [name, run_it] : studies) {
      std::cerr << " " << name;
    }
    std::cerr << "\nsettings:";
    for (const auto& [name, to] : words) {
      std::cerr << " " << name;
    }
    std::cerr << "\n";
    return 2;
  }
  study->second(settings);
  return 0;
}
