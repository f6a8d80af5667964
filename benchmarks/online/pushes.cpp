// ContactObserver on simulated pushes, against thresholds that are the same for all motion.

#include <algorithm>
#include <array>
#include <iomanip>
#include <iostream>

#include "rivid/online/contact_observer.hpp"
#include "simulated.hpp"
#include "studies.hpp"

namespace rivid::benchmarks {

namespace {

constexpr double learned = 600.0;       // s
constexpr double quiet = 3600.0;        // s of motion without contacts that false alarms are counted in
constexpr double push_time = 0.5;       // s
constexpr double between = 2.0;         // s from the begin of one push to that of the next
constexpr double rate_of_pushes = 1.0;  // false alarms an hour that thresholds are made for

// A stream of noisy ticks of an arm in motion, made piece by piece.
class Stream {
 public:
  Stream(const Arm& arm, std::uint64_t seed) : arm_(arm), random_(seed), seed_(seed) {
    chi_st_ = with_friction_error(arm.robot, arm.chi_st, friction_error, random_);
  }

  // Calls tick(q, qd, τ, pose) for so many seconds; τ lacks the torque that external(k, q) says.
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

// Geometry by the chain itself: torques of a force on the origin of the frame behind a link.
Vector torques_of_force(const Robot& robot, const Vector& q, Index link, const Eigen::Vector3d& force) {
  std::vector<Eigen::Vector3d> axes;
  std::vector<Eigen::Vector3d> origins;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (Index j = 0; j <= link; ++j) {
    const Chain::Link& l = robot.chain.links[static_cast<std::size_t>(j)];
    p += R * l.p;
    R = R * l.R * Eigen::AngleAxisd(q[j], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    axes.emplace_back(R.col(2));
    origins.push_back(p);
  }
  const Eigen::Vector3d at = p + R * Eigen::Vector3d(0.05, 0.05, 0.1);
  Vector out = Vector::Zero(q.size());
  for (Index j = 0; j <= link; ++j) {
    out[j] = axes[static_cast<std::size_t>(j)].cross(at - origins[static_cast<std::size_t>(j)]).dot(force);
  }
  return out;
}

struct Push {
  Index link = 0;
  double size = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

// What one detector makes of a push.
struct Score {
  int seen = 0;
  int pushes = 0;
  int right_link = 0;
  std::vector<double> delays;
};

constexpr std::array sizes = {5.0, 10.0, 20.0, 50.0};

double median_of(std::vector<double> x) {
  std::ranges::sort(x);
  return x.empty() ? std::numeric_limits<double>::quiet_NaN() : x[x.size() / 2];
}

// Alarms in a series of whether a detector is on: those within a second are one.
struct Alarms {
  int count = 0;
  Index last = -100000;
  void take(Index k, bool on) {
    if (on && static_cast<double>(k - last) > f_m) {
      ++count;
    }
    last = on ? k : last;
  }
};

void pushes_of(const Arm& arm, int pushes) {
  using Mode = ContactObserver<double>::Mode;
  const Index n = arm.robot.size();
  ContactObserver<double> observer(DynamicModel(arm.robot, arm.model.base, arm.model.chi),
                                   {.f_m = f_m, .alarms_per_hour = rate_of_pushes});
  Stream stream(arm, 31);
  // Pieces of the motion do not follow one another.
  const auto start = [&](Index i) {
    if (i == 0) {
      observer.reset();
    }
  };
  const auto none = [&](Index /*k*/, const auto& /*q*/) { return Vector(Vector::Zero(n)); };
  stream.run(learned, none, [&](Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    start(i);
    observer.update(q, qd, tau, Mode::learn);
  });
  // False alarms, and the highest residuals of each joint, which fixed thresholds have to lie above for as many.
  Alarms alarms;
  std::vector<Matrix> highest;  // of each second, a column
  Vector peak = Vector::Zero(n);
  Index k = 0;
  stream.run(quiet, none, [&](Index i, const Vector& q, const Vector& qd, const Vector& tau) {
    start(i);
    const bool on = observer.update(q, qd, tau) && i > 500;
    alarms.take(k++, on);
    if (i > 500) {
      peak = peak.cwiseMax(observer.residual().cwiseAbs());
    }
    if (k % 1000 == 0) {
      highest.emplace_back(peak);
      peak.setZero();
    }
  });
  // Fixed thresholds, in proportion to each joint's deviation of the seconds' peaks, with as many alarms.
  Vector scale = Vector::Zero(n);
  for (const Matrix& second : highest) {
    scale += second.col(0) / static_cast<double>(highest.size());
  }
  std::vector<double> worst;
  for (const Matrix& second : highest) {
    worst.push_back(second.col(0).cwiseQuotient(scale).maxCoeff());
  }
  std::ranges::sort(worst, std::greater<>());
  const Vector fixed = scale * worst[static_cast<std::size_t>(std::max(alarms.count, 1))];

  std::array<std::vector<Score>, sizes.size()> ours;
  std::array<std::vector<Score>, sizes.size()> theirs;
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    ours[s].resize(static_cast<std::size_t>(n));
    theirs[s].resize(static_cast<std::size_t>(n));
  }
  std::mt19937_64 random(77);
  std::normal_distribution<double> normal;
  std::vector<Push> plan;
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    for (Index link = 0; link < n; ++link) {
      for (int i = 0; i < pushes; ++i) {
        plan.push_back(
            {link, sizes[s], Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized()});
      }
    }
  }
  const auto period = static_cast<Index>(between * f_m);
  const auto length = static_cast<Index>(push_time * f_m);
  bool our_eye = false;
  bool their_eye = false;
  Index at = 0;
  const auto now = [&](Index tick) {
    return plan[std::min(static_cast<std::size_t>(tick / period), plan.size() - 1)];
  };
  stream.run(
      between * static_cast<double>(plan.size()),
      [&](Index tick, const auto& q) {
        const Push push = now(tick);
        const bool on = tick % period >= period - length;
        return on ? torques_of_force(arm.robot, q, push.link, push.size * push.direction)
                  : Vector(Vector::Zero(n));
      },
      [&](Index /*i*/, const Vector& q, const Vector& qd, const Vector& tau) {
        observer.update(q, qd, tau);
        const Push push = now(at);
        const Index since = at % period - (period - length);
        const auto s = static_cast<std::size_t>(std::ranges::find(sizes, push.size) - sizes.begin());
        Score& our = ours[s][static_cast<std::size_t>(push.link)];
        Score& their = theirs[s][static_cast<std::size_t>(push.link)];
        if (since == 0) {
          our_eye = their_eye = false;
          ++our.pushes;
          ++their.pushes;
        }
        const auto see = [&](Score& score, bool& eye, bool on) {
          if (since >= 0 && on && !eye) {
            eye = true;
            ++score.seen;
            score.delays.push_back(static_cast<double>(since) / f_m);
          }
        };
        see(our, our_eye, observer.contact());
        see(their, their_eye, (observer.residual().cwiseAbs().array() > fixed.array()).any());
        if (since == length - 1 && our_eye && observer.link() == push.link) {
          ++our.right_link;
        }
        ++at;
      });
  std::cout << std::setprecision(3) << arm.name << ": " << alarms.count << " false alarms in "
            << quiet / 3600.0 << " h; fixed thresholds " << fixed.transpose() << " N·m for as many\n  levels";
  for (Index j = 0; j < n; ++j) {
    std::cout << ' ' << observer.level(j);
  }
  std::cout << "\n  link  size [N]  seen  fixed  delay [ms]  fixed  link named\n";
  for (Index link = 0; link < n; ++link) {
    for (std::size_t s = 0; s < sizes.size(); ++s) {
      const Score& our = ours[s][static_cast<std::size_t>(link)];
      const Score& their = theirs[s][static_cast<std::size_t>(link)];
      std::cout << "  " << link + 1 << "  " << sizes[s] << "  " << 100.0 * our.seen / std::max(our.pushes, 1)
                << " %  " << 100.0 * their.seen / std::max(their.pushes, 1) << " %  "
                << 1e3 * median_of(our.delays) << "  " << 1e3 * median_of(their.delays) << "  "
                << 100.0 * our.right_link / std::max(our.pushes, 1) << " %\n";
    }
  }
}

}  // namespace

void push_study(const std::string& data, int pushes) {
  for (const Arm& arm : arms(data)) {
    pushes_of(arm, pushes);
  }
}

}  // namespace rivid::benchmarks
