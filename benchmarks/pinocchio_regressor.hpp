#pragma once

#include <array>
#include <memory>
#include <vector>

// The regressor of Pinocchio behind plain numbers: its headers take minutes to compile, and no matrix is
// handed over.
class PinocchioRegressor {
 public:
  struct Link {
    bool revolute = true;
    std::array<double, 9> R{};  // column-major, frame j in frame j−1
    std::array<double, 3> p{};
  };

  PinocchioRegressor(const std::vector<Link>& links, const std::array<double, 3>& gravity);
  ~PinocchioRegressor();
  PinocchioRegressor(const PinocchioRegressor&) = delete;
  PinocchioRegressor& operator=(const PinocchioRegressor&) = delete;
  PinocchioRegressor(PinocchioRegressor&&) = delete;
  PinocchioRegressor& operator=(PinocchioRegressor&&) = delete;

  // (n × 10 n), column-major; ten columns a link: M MX MY MZ XX XY YY XZ YZ ZZ.
  const double* operator()(const double* q, const double* qd, const double* qdd);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
