#pragma once

#include <array>
#include <memory>
#include <vector>

// The articulated-body algorithm and the recursive Newton-Euler of Pinocchio behind plain numbers: its
// headers take minutes to compile, and no matrix is handed over.
class PinocchioAba {
 public:
  struct Link {
    bool revolute = true;
    std::array<double, 9> R{};  // column-major, frame j in frame j−1
    std::array<double, 3> p{};
    std::array<double, 10> dynamic_parameters{};  // M MX MY MZ XX XY YY XZ YZ ZZ in frame j
    double Ia = 0.0;
  };

  PinocchioAba(const std::vector<Link>& links, const std::array<double, 3>& gravity);
  ~PinocchioAba();
  PinocchioAba(const PinocchioAba&) = delete;
  PinocchioAba& operator=(const PinocchioAba&) = delete;
  PinocchioAba(PinocchioAba&&) = delete;
  PinocchioAba& operator=(PinocchioAba&&) = delete;

  // Joint accelerations, (n).
  const double* operator()(const double* q, const double* qd, const double* tau);

  // Joint torques, (n).
  const double* torques(const double* q, const double* qd, const double* qdd);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
