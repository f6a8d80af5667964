#pragma once

#include <array>
#include <cstddef>

/// Numbers that [RIV] prints for its SCARA, section 4.
namespace rivid::study {

inline constexpr double paper_length = 0.5;  ///< L of the first link [m]
inline constexpr std::size_t b = 8;
inline constexpr std::array<const char*, b> names = {"ZZ1R", "Fv1",  "Fc1", "ZZ2",
                                                     "LMX2", "LMY2", "Fv2", "Fc2"};
inline constexpr std::array<const char*, b> units = {"kg·m²", "N·m·s/rad", "N·m",       "kg·m²",
                                                     "kg·m²", "kg·m²",     "N·m·s/rad", "N·m"};
/// Where rivid has MX2 and MY2, the paper has L MX2 and L MY2.
inline constexpr std::array<double, b> in_paper = {1, 1, 1, 1, paper_length, paper_length, 1, 1};
inline constexpr std::array<double, b> truth = {3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137};

/// A table of the paper: estimate and 2 σ as printed, and its relative error ‖Y − Wχ̂‖ / ‖Y‖, zero where it has none.
struct PaperTable {
  std::array<double, b> chi;
  std::array<double, b> two_sigma;
  double relative_error;
};
inline constexpr PaperTable table_1 = {.chi = {3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137},
                                       .two_sigma = {0.034, 0.031, 0.1, 0.0006, 0.0014, 0.0007, 0.006, 0.006},
                                       .relative_error = 0.024};
inline constexpr PaperTable table_2 = {
    .chi = {3.45, 0.04, 0.82, 0.061, 0.124, 0.007, 0.013, 0.137},
    .two_sigma = {0.036, 0.032, 0.05, 0.0006, 0.0013, 0.0005, 0.0084, 0.008},
    .relative_error = 0.021};
inline constexpr PaperTable table_3 = {
    .chi = table_2.chi, .two_sigma = table_2.two_sigma, .relative_error = 0.0};
inline constexpr std::array<std::array<double, b>, 4> table_4 = {
    {{1, 0, 0, 1, 0, 0, 0, 0},
     {3.46, 0.04, 0.82, 0.06, 0.122, 0.05, 0.005, 0.130},
     {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132},
     {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132}}};
inline constexpr PaperTable table_5 = {.chi = {1.5, 0.095, 0.55, 0.14, 0.63, 0.1, 0.001, 0.19},
                                       .two_sigma = {0.05, 0.15, 0.26, 0.018, 0.035, 0.023, 0.143, 0.244},
                                       .relative_error = 0.8};
inline constexpr PaperTable table_6 = {
    .chi = {3.45, 0.05, 0.81, 0.061, 0.124, 0.008, 0.023, 0.13},
    .two_sigma = {0.007, 0.023, 0.004, 0.0004, 0.0015, 0.0009, 0.0022, 0.0038},
    .relative_error = 0.08};
inline constexpr PaperTable table_7 = {
    .chi = {3.44, 0.02, 0.86, 0.060, 0.124, 0.007, 0.01, 0.13},
    .two_sigma = {0.014, 0.012, 0.016, 0.0001, 0.0002, 0.0003, 0.003, 0.0008},
    .relative_error = 0.0};

}  // namespace rivid::study
