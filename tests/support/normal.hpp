#pragma once

#include <cmath>
#include <random>

namespace rivid::test {

/// Normal numbers that are the same with every standard library, by the polar method of Marsaglia: those of
/// std::normal_distribution are not, so that a seed would be another draw.
class Normal {
 public:
  explicit Normal(double mean = 0.0, double sigma = 1.0) : mean_(mean), sigma_(sigma) {}

  template <typename Generator>
  double operator()(Generator& random) {
    if (has_other_) {
      has_other_ = false;
      return mean_ + sigma_ * other_;
    }
    const auto uniform = [&] { return 2.0 * std::generate_canonical<double, 53>(random) - 1.0; };
    double x = 0.0;
    double y = 0.0;
    double square = 0.0;
    do {
      x = uniform();
      y = uniform();
      square = x * x + y * y;
    } while (square > 1.0 || square == 0.0);
    const double factor = std::sqrt(-2.0 * std::log(square) / square);
    other_ = x * factor;
    has_other_ = true;
    return mean_ + sigma_ * (y * factor);
  }

 private:
  double mean_, sigma_;
  double other_ = 0.0;
  bool has_other_ = false;
};

}  // namespace rivid::test
