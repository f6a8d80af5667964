#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>
#include <vector>

// A number type that remembers how it was made: a kernel that is a template on its Scalar writes C when it
// works on it.
namespace rivid::detail {

class Recording;

/// A constant, or the value of a node of a recording.
struct Recorded {
  double value = 0.0;
  int node = -1;  // −1: a constant
  Recording* in = nullptr;

  Recorded() = default;
  Recorded(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): kernels count on it
};

/// What a comparison gives: nothing is decided before the C runs.
struct RecordedChoice {
  Recorded condition;
};

[[nodiscard]] Recorded operator+(const Recorded& a, const Recorded& b);
[[nodiscard]] Recorded operator-(const Recorded& a, const Recorded& b);
[[nodiscard]] Recorded operator*(const Recorded& a, const Recorded& b);
[[nodiscard]] Recorded operator/(const Recorded& a, const Recorded& b);
[[nodiscard]] Recorded operator-(const Recorded& a);
inline Recorded& operator+=(Recorded& a, const Recorded& b) { return a = a + b; }
[[nodiscard]] RecordedChoice operator>(const Recorded& a, const Recorded& b);
[[nodiscard]] inline RecordedChoice operator<(const Recorded& a, const Recorded& b) { return b > a; }
[[nodiscard]] Recorded select(const RecordedChoice& choice, const Recorded& a, const Recorded& b);
[[nodiscard]] Recorded sin(const Recorded& x);
[[nodiscard]] Recorded cos(const Recorded& x);
[[nodiscard]] Recorded tanh(const Recorded& x);
[[nodiscard]] Recorded exp(const Recorded& x);
[[nodiscard]] Recorded sqrt(const Recorded& x);
[[nodiscard]] Recorded abs(const Recorded& x);

/// Operations as a graph without a node twice, with constants folded, and the C that does them.
class Recording {
 public:
  Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// What C has by this expression. It is read before any output is written.
  [[nodiscard]] Recorded input(const std::string& expression);
  /// The entries of an array from the first on.
  [[nodiscard]] Eigen::VectorX<Recorded> inputs(const std::string& array, Eigen::Index count);

  void output(const std::string& target, const Recorded& value) {
    outputs_.push_back({target + " = ", value});
  }
  void outputs(const std::string& array, const Eigen::VectorX<Recorded>& values);
  void returned(const Recorded& value) { outputs_.push_back({"return ", value}); }

  /// Statements: what the outputs need, then these.
  [[nodiscard]] std::string statements(std::string_view indent = "  ") const;
  /// One expression, of few operations.
  [[nodiscard]] std::string expression(const Recorded& value) const;

  /// For the operations. `form` has # in place of its operands.
  [[nodiscard]] static Recorded made(std::string_view form, std::vector<Recorded> operands);

 private:
  struct Node {
    std::string form;
    std::vector<Recorded> operands;
  };
  struct Output {
    std::string target;
    Recorded value;
  };
  struct Printed;

  std::vector<Node> nodes_;
  std::map<std::string, int> known_;
  std::vector<Output> outputs_;
};

}  // namespace rivid::detail

template <>
struct Eigen::NumTraits<rivid::detail::Recorded> : Eigen::GenericNumTraits<rivid::detail::Recorded> {
  using Real = rivid::detail::Recorded;
  using NonInteger = rivid::detail::Recorded;
  using Literal = rivid::detail::Recorded;
  using Nested = rivid::detail::Recorded;
};
