#include "odd/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rivid::odd {

namespace {

constexpr double base_frequency_hz = 0.1;  // of a series at a pace of one
constexpr double metres_per_radian = 0.25;

}  // namespace

RandomMotion::RandomMotion(const Recipe& recipe, const Arm& arm, Random& random)
    : duration_(recipe.duration), kind_(recipe.motion), centre_(arm.size()), amplitude_(arm.size()) {
  for (Index j = 0; j < arm.size(); ++j) {
    const double unit = arm.joints[static_cast<std::size_t>(j)].prismatic ? metres_per_radian : 1.0;
    centre_[j] = unit * random.uniform(-1.0, 1.0);
    amplitude_[j] = unit * recipe.amplitude * random.uniform(0.7, 1.3);
  }
  if (recipe.one_still) {
    amplitude_[random.integer(0, static_cast<int>(arm.size()) - 1)] = 0.0;
  }
  if (recipe.motion == Recipe::Motion::fourier) {
    draw_series(recipe, random);
  } else {
    draw_moves(recipe, random);
  }
}

void RandomMotion::draw_series(const Recipe& recipe, Random& random) {
  omega_ = 2.0 * std::numbers::pi * base_frequency_hz * recipe.pace;
  sine_.resize(harmonics, centre_.size());
  cosine_.resize(harmonics, centre_.size());
  for (Index j = 0; j < centre_.size(); ++j) {
    for (Index k = 0; k < harmonics; ++k) {
      sine_(k, j) = random.normal();
      cosine_(k, j) = random.normal();
    }
  }
  // Scaled to the asked amplitude over one period.
  const Numbers asked = amplitude_;
  amplitude_.setOnes();
  Numbers largest = Numbers::Zero(centre_.size());
  constexpr int instants = 400;
  for (int i = 0; i < instants; ++i) {
    const double t = 2.0 * std::numbers::pi / omega_ * i / instants;
    largest = largest.cwiseMax((at(t).q - centre_).cwiseAbs());
  }
  amplitude_ = asked.cwiseQuotient(largest);
}

void RandomMotion::draw_moves(const Recipe& recipe, Random& random) {
  Numbers here = centre_;
  double t = 0.1;
  while (t < duration_) {
    Move move{.start = t, .length = random.uniform(0.8, 1.8) / recipe.pace, .from = here, .to = here};
    for (Index j = 0; j < centre_.size(); ++j) {
      const auto count = static_cast<Index>(moves_.size());
      const bool in_turn = kind_ == Recipe::Motion::one_by_one ? j == count % centre_.size()
                           : kind_ == Recipe::Motion::raster   ? (j == 0) == (count % 2 == 0)
                                                               : true;
      const double to = random.uniform(-1.0, 1.0);
      if (in_turn && kind_ == Recipe::Motion::raster) {
        constexpr double step = 0.3;
        move.to[j] = j == 0 ? centre_[j] + amplitude_[j] * (count % 4 == 0 ? 1.0 : -1.0)
                            : std::clamp(here[j] + step * amplitude_[j] * to, centre_[j] - amplitude_[j],
                                         centre_[j] + amplitude_[j]);
      } else if (in_turn) {
        move.to[j] = centre_[j] + amplitude_[j] * to;
      }
    }
    here = move.to;
    t += move.length * (1.0 + recipe.dwell * random.uniform(0.5, 1.5));
    moves_.push_back(std::move(move));
  }
}

ReferencePoint RandomMotion::at(double t) const {
  const Index n = centre_.size();
  ReferencePoint out{.q = centre_, .qd = Numbers::Zero(n), .qdd = Numbers::Zero(n)};
  if (moves_.empty()) {
    for (Index k = 0; k < harmonics; ++k) {
      const double w = omega_ * static_cast<double>(k + 1);
      const double s = std::sin(w * t);
      const double c = std::cos(w * t);
      for (Index j = 0; j < n; ++j) {
        out.q[j] += amplitude_[j] * (sine_(k, j) * s + cosine_(k, j) * c);
        out.qd[j] += amplitude_[j] * w * (sine_(k, j) * c - cosine_(k, j) * s);
        out.qdd[j] -= amplitude_[j] * w * w * (sine_(k, j) * s + cosine_(k, j) * c);
      }
    }
    return out;
  }
  const auto next = std::ranges::upper_bound(moves_, t, {}, &Move::start);
  if (next == moves_.begin()) {
    out.q = moves_.front().from;
    return out;
  }
  const Move& move = *std::prev(next);
  const double x = std::min(1.0, (t - move.start) / move.length);
  const Numbers way = move.to - move.from;
  out.q = move.from + way * (x * x * x * (10.0 + x * (-15.0 + 6.0 * x)));
  if (x < 1.0) {
    out.qd = way * (30.0 * x * x * (1.0 - x) * (1.0 - x) / move.length);
    out.qdd = way * (60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (move.length * move.length));
  }
  return out;
}

}  // namespace rivid::odd
