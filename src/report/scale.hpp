#pragma once

#include <array>
#include <string>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// The values of an axis along the pixels from … to.
class Scale {
 public:
  enum class Ends { data, ticks };

  Scale(std::array<double, 2> values, bool logarithmic, Ends ends);

  void lay(double from, double to) {
    from_ = from;
    to_ = to;
  }
  [[nodiscard]] const std::vector<double>& ticks() const { return ticks_; }
  // The pixel of a value; those beyond the ends lie on them.
  [[nodiscard]] double at(double value) const;
  // Ends, of their logarithms where the scale is one.
  [[nodiscard]] std::string words() const;

 private:
  void show_decades(double low, double high);

  bool logarithmic_;
  double low_ = 0.0;
  double high_ = 1.0;
  double from_ = 0.0;
  double to_ = 1.0;
  std::vector<double> ticks_;
};

// The least and the largest of some values that are finite.
//
// @param positive  whether others do not count
[[nodiscard]] std::array<double, 2> range_of(const std::vector<const Vector*>& values,
                                             const std::vector<double>& shown, bool positive);

}  // namespace rivid::detail
