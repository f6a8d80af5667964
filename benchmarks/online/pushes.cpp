// ContactObserver on simulated pushes, against thresholds that are the same for all motion, and against what
// noise alone would leave: all at the same false alarms an hour.

#include <algorithm>
#include <array>
#include <functional>
#include <iomanip>
#include <iostream>

#include "rivid/online/contact_observer.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

constexpr double learned = 600.0;    // s
constexpr double quiet_hours = 2.0;  // of motion without contacts that false alarms are counted in
constexpr double push_time = 0.5;    // s
constexpr double between = 2.0;      // s from the begin of one push to that of the next
constexpr Index settling = 500;      // ticks at the begin of each piece of motion that do not count

// A stream of noisy ticks of an arm in motion, made piece by piece.
class Stream {
 public:
  Stream(const Arm& arm, std::uint64_t seed) : arm_(arm), random_(seed), seed_(seed) {
    chi_st_ = with_friction_error(arm.robot, arm.chi_st, friction_error, random_);
  }

  [[nodiscard]] const Vector& chi_st() const { return chi_st_; }

  // Calls tick(i, q, qd, τ) for so many seconds, i counted from the begin of a piece; τ lacks the torque that
  // external(k, q) says.
  template <typename External, typename Tick>
  void run(double seconds, const External& external, const Tick& tick) {
    constexpr double piece = 60.0;
    const Index n = arm_.robot.size();
    std::normal_distribution<double> normal;
    Index k = 0;
    for (double done = 0.0; done < seconds; done += piece) {
      const Vector t = test::ticks(std::min(piece, seconds - done), f_m);
      const Motion motion = test::Wandering(n, ++seed_ + 7000, 0.6, 0.9).at(t);
      const Matrix tau = torques_of(arm_.robot, chi_st_, motion).transpose();
      const Matrix q = motion.q.transpose();
      Vector measured(n);
      Vector before = q.col(0);
      Vector torque(n);
      Vector velocity = motion.qd.row(0).transpose();
      for (Index i = 0; i < q.cols(); ++i, ++k) {
        for (Index j = 0; j < n; ++j) {
          measured[j] = q(j, i) + encoder_noise * normal(random_);
          torque[j] =
              0.5 * (tau(j, i) + tau(j, std::max<Index>(i - 1, 0))) + arm_.torque_noise[j] * normal(random_);
        }
        // As a drive filters it.
        velocity += 0.2 * ((measured - before) * f_m - velocity);
        before = measured;
        torque -= external(k, q.col(i));
        tick(i, measured, velocity, torque);
      }
    }
  }

 private:
  const Arm& arm_;
  std::mt19937_64 random_;
  std::uint64_t seed_;
  Vector chi_st_;
};

struct Push {
  Index link = 0;
  double size = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

constexpr std::array sizes = {5.0, 10.0, 20.0, 30.0, 50.0};
// False alarms an hour at which the detectors are compared.
constexpr std::array rates = {1.0, 10.0, 100.0, 1000.0};

constexpr std::array names = {"observer", "fixed", "no model error"};
enum Detector : std::size_t { by_class, fixed, exact, detectors };
using Scores = std::array<double, detectors>;  // an alarm where above a threshold

// The three detectors of one arm. They see the same ticks.
class Detectors {
 public:
  Detectors(const Arm& arm, const Vector& truth)
      : observer_(DynamicModel(arm.robot, arm.model.base, arm.model.chi), {.f_m = f_m}),
        exact_(DynamicModel(arm.robot, truth), {.f_m = f_m}),
        scale_(Vector::Zero(arm.robot.size())),
        peak_(scale_) {}

  void learn(Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    begin(i);
    // The filter of the velocities begins with each piece as well, which a drive's never does.
    using Mode = ContactObserver<double>::Mode;
    const Mode mode = i > settling ? Mode::learn : Mode::observe;
    observer_.update(q, qd, tau, mode);
    exact_.update(q, qd, tau, mode);
    // Fixed thresholds are in proportion to the mean of the seconds' peaks of each joint.
    if (i > settling) {
      peak_ = peak_.cwiseMax(observer_.residual().cwiseAbs());
    }
    if (++ticks_ % static_cast<Index>(f_m) == 0) {
      scale_ += peak_;
      peak_.setZero();
    }
  }
  [[nodiscard]] Scores scores(Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    begin(i);
    observer_.update(q, qd, tau);
    exact_.update(q, qd, tau);
    if (i <= settling) {
      return {};
    }
    const double seconds = static_cast<double>(ticks_) / f_m;
    return {observer_.relative().cwiseAbs().maxCoeff(),
            seconds * observer_.residual().cwiseQuotient(scale_).cwiseAbs().maxCoeff(),
            exact_.relative().cwiseAbs().maxCoeff()};
  }
  [[nodiscard]] const ContactObserver<double>& observer() const { return observer_; }

 private:
  // Pieces of the motion do not follow one another.
  void begin(Index i) {
    if (i == 0) {
      observer_.reset();
      exact_.reset();
    }
  }

  ContactObserver<double> observer_;
  ContactObserver<double> exact_;
  Vector scale_;
  Vector peak_;
  Index ticks_ = 0;
};

// Highest scores of each quiet second, in falling order.
class Quiet {
 public:
  void take(const Scores& scores) {
    for (std::size_t d = 0; d < detectors; ++d) {
      peak_[d] = std::max(peak_[d], scores[d]);
    }
    if (++ticks_ % static_cast<Index>(f_m) == 0) {
      for (std::size_t d = 0; d < detectors; ++d) {
        peaks_[d].push_back(peak_[d]);
      }
      peak_ = {};
    }
  }
  void finish() {
    for (std::vector<double>& peaks : peaks_) {
      std::ranges::sort(peaks, std::greater<>());
    }
  }
  // That as many seconds exceed as there are alarms.
  [[nodiscard]] double threshold(std::size_t detector, double alarms_per_hour) const {
    return peaks_[detector][static_cast<std::size_t>(alarms_per_hour * quiet_hours)];
  }
  [[nodiscard]] double alarms_per_hour(std::size_t detector, double threshold) const {
    return static_cast<double>(
               std::ranges::count_if(peaks_[detector], [&](double peak) { return peak > threshold; })) /
           quiet_hours;
  }

 private:
  std::array<std::vector<double>, detectors> peaks_;
  Scores peak_{};
  Index ticks_ = 0;
};

// What the detectors made of one push: the highest scores up to each tick of it.
struct Seen {
  Push push;
  bool right_link = false;  // the one that the observer named at its end
  std::array<std::vector<double>, detectors> highest;

  [[nodiscard]] bool seen(std::size_t detector, double threshold) const {
    return highest[detector].back() > threshold;
  }
  [[nodiscard]] double delay(std::size_t detector, double threshold) const {
    const auto& of = highest[detector];
    return static_cast<double>(std::ranges::upper_bound(of, threshold) - of.begin()) / f_m;
  }
};

std::vector<Push> plan_of(Index joints, int each) {
  std::mt19937_64 random(77);
  std::normal_distribution<double> normal;
  std::vector<Push> out;
  for (const double size : sizes) {
    for (Index link = 0; link < joints; ++link) {
      for (int i = 0; i < each; ++i) {
        out.push_back(
            {link, size, Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized()});
      }
    }
  }
  return out;
}

std::vector<Seen> pushed(const Arm& arm, Stream& stream, Detectors& detectors_of, int each) {
  const std::vector<Push> plan = plan_of(arm.robot.size(), each);
  const auto period = static_cast<Index>(between * f_m);
  const auto length = static_cast<Index>(push_time * f_m);
  std::vector<Seen> out;
  Index at = 0;
  stream.run(
      between * static_cast<double>(plan.size()),
      [&](Index tick, const auto& q) {
        const Push& push = plan[static_cast<std::size_t>(tick / period)];
        const bool on = tick % period >= period - length;
        return on ? torques_of_force(arm.robot, q, push.link, push.size * push.direction)
                  : Vector(Vector::Zero(q.size()));
      },
      [&](Index i, const Vector& q, const Vector& qd, const Vector& tau) {
        const Scores scores = detectors_of.scores(i, q, qd, tau);
        const Index since = at % period - (period - length);
        if (since == 0) {
          out.push_back({plan[static_cast<std::size_t>(at / period)], false, {}});
        }
        for (std::size_t d = 0; since >= 0 && d < detectors; ++d) {
          std::vector<double>& highest = out.back().highest[d];
          highest.push_back(std::max(scores[d], highest.empty() ? 0.0 : highest.back()));
        }
        if (since == length - 1) {
          out.back().right_link = detectors_of.observer().link() == out.back().push.link;
        }
        ++at;
      });
  return out;
}

// Part of the pushes that pass and are seen, in per cent.
template <typename Which>
double part_seen(const std::vector<Seen>& all, std::size_t detector, double threshold, const Which& which) {
  double seen = 0.0;
  double count = 0.0;
  for (const Seen& one : all) {
    if (which(one.push)) {
      count += 1.0;
      seen += one.seen(detector, threshold) ? 1.0 : 0.0;
    }
  }
  return 100.0 * seen / std::max(count, 1.0);
}

template <typename Which>
double median_delay(const std::vector<Seen>& all, std::size_t detector, double threshold,
                    const Which& which) {
  std::vector<double> delays;
  for (const Seen& one : all) {
    if (which(one.push) && one.seen(detector, threshold)) {
      delays.push_back(one.delay(detector, threshold));
    }
  }
  std::ranges::sort(delays);
  return delays.empty() ? std::numeric_limits<double>::quiet_NaN() : delays[delays.size() / 2];
}

void print_roc(const Quiet& quiet, const std::vector<Seen>& all) {
  std::cout << "  part of the pushes on all links that is seen [%], by false alarms an hour\n"
            << "  size [N]  detector       ";
  for (const double rate : rates) {
    std::cout << "  " << rate << " / h";
  }
  std::cout << "  median delay at 1 / h [ms]\n";
  for (const double size : sizes) {
    const auto of_size = [&](const Push& push) { return push.size == size; };
    for (std::size_t d = 0; d < detectors; ++d) {
      std::cout << "  " << std::setw(8) << size << "  " << std::setw(14) << std::left << names[d]
                << std::right;
      for (const double rate : rates) {
        std::cout << "  " << std::setw(6) << part_seen(all, d, quiet.threshold(d, rate), of_size);
      }
      std::cout << "  " << 1e3 * median_delay(all, d, quiet.threshold(d, 1.0), of_size) << '\n';
    }
  }
}

void print_links(const Quiet& quiet, const std::vector<Seen>& all, Index joints) {
  std::cout << "  by link, at one false alarm an hour: part of the pushes that is seen [%]\n"
            << "  link  detector       ";
  for (const double size : sizes) {
    std::cout << "  " << size << " N";
  }
  std::cout << "  median delay at 50 N [ms]  link named at 50 N [%]\n";
  for (Index link = 0; link < joints; ++link) {
    const auto hard = [&](const Push& push) { return push.link == link && push.size == sizes.back(); };
    double named = 0.0;
    double count = 0.0;
    for (const Seen& one : all) {
      count += hard(one.push) ? 1.0 : 0.0;
      named += hard(one.push) && one.right_link ? 1.0 : 0.0;
    }
    for (std::size_t d = 0; d < detectors; ++d) {
      const double threshold = quiet.threshold(d, 1.0);
      std::cout << "  " << std::setw(4) << link + 1 << "  " << std::setw(14) << std::left << names[d]
                << std::right;
      for (const double size : sizes) {
        std::cout << "  " << part_seen(all, d, threshold, [&](const Push& push) {
          return push.link == link && push.size == size;
        });
      }
      std::cout << "  " << 1e3 * median_delay(all, d, threshold, hard);
      if (d == by_class) {
        std::cout << "  " << 100.0 * named / count;
      }
      std::cout << '\n';
    }
  }
}

void pushes_of(const Arm& arm, int each) {
  const Index n = arm.robot.size();
  Stream stream(arm, 31);
  Detectors detectors_of(arm, stream.chi_st());
  const auto none = [&](Index /*k*/, const auto& /*q*/) { return Vector(Vector::Zero(n)); };
  stream.run(learned, none, [&](Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    detectors_of.learn(i, q, qd, tau);
  });
  Quiet quiet;
  stream.run(3600.0 * quiet_hours, none, [&](Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    quiet.take(detectors_of.scores(i, q, qd, tau));
  });
  quiet.finish();
  const std::vector<Seen> all = pushed(arm, stream, detectors_of, each);
  std::cout << std::setprecision(3) << arm.name << ": " << quiet.alarms_per_hour(by_class, 1.0)
            << " false alarms an hour in " << quiet_hours << " h at the observer's own thresholds, "
            << quiet.alarms_per_hour(exact, 1.0) << " without model errors; one an hour at "
            << quiet.threshold(by_class, 1.0) << " times these\n  levels";
  for (Index j = 0; j < n; ++j) {
    std::cout << ' ' << detectors_of.observer().level(j);
  }
  std::cout << '\n';
  print_roc(quiet, all);
  print_links(quiet, all, n);
}

}  // namespace

void push_study(const std::string& data, int each, const std::string& only) {
  for (const Arm& arm : arms(data, only)) {
    pushes_of(arm, each);
  }
}

}  // namespace rivid::benchmarks
