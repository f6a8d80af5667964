#pragma once

// Embedded pairs of explicit Runge-Kutta methods: numbers alone, for the file of the integrators and for the
// kernels that are compiled once an instruction set.
namespace rivid::detail {

// An embedded pair: the higher order is carried on, the last stage is the first of the next step. Between the
// ends of a step the state is a cubic by Hermite, and where `dense_weight` is not zero a term of fourth order
// more.

// Bogacki & Shampine (1989), 3(2).
struct BogackiShampine {
  static constexpr int stages = 4;      // the last one is the first of the next step
  static constexpr double order = 3.0;  // of the result that is carried on
  static constexpr double node[stages] = {0.0, 1.0 / 2, 3.0 / 4, 1.0};
  static constexpr double stage[stages][stages - 1] = {
      {}, {1.0 / 2}, {0.0, 3.0 / 4}, {2.0 / 9, 1.0 / 3, 4.0 / 9}};
  static constexpr double error_weight[stages] = {-5.0 / 72, 1.0 / 12, 1.0 / 9, -1.0 / 8};
  static constexpr double dense_weight[stages] = {};
  static constexpr bool more_dense = false;
};

// Dormand & Prince (1980), RK5(4)7FM, with Shampine's continuous extension as Hairer, Nørsett & Wanner,
// Solving Ordinary Differential Equations I, II.6, give it.
struct DormandPrince {
  static constexpr int stages = 7;      // the last one is the first of the next step
  static constexpr double order = 5.0;  // of the result that is carried on
  static constexpr double node[stages] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
  static constexpr double stage[stages][stages - 1] = {
      {},
      {1.0 / 5},
      {3.0 / 40, 9.0 / 40},
      {44.0 / 45, -56.0 / 15, 32.0 / 9},
      {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
      {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
      {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
  static constexpr double error_weight[stages] = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                                                  -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
  static constexpr double dense_weight[stages] = {-12715105075.0 / 11282082432,  0.0,
                                                  87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                                  701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                                  69997945.0 / 29380423};
  static constexpr bool more_dense = true;
};

}  // namespace rivid::detail
