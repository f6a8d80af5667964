#include "identify/dissipative.hpp"

#include <algorithm>

namespace rivid::detail {

namespace {

Direction opposite(Direction direction) {
  switch (direction) {
    case Direction::positive:
      return Direction::negative;
    case Direction::negative:
      return Direction::positive;
    case Direction::both:
      break;
  }
  return Direction::both;
}

}  // namespace

void make_dissipative(const BaseParameters& base, const Vector& mean_speed, const Vector& mean_square,
                      Vector& chi_st) {
  const auto find = [&](Basis basis, Direction direction, int joint) {
    const auto at = std::ranges::find_if(base.standard, [&](const StandardParameter& p) {
      const KindRow& row = about(p.kind);
      return p.joint == joint && row.basis == basis && row.direction == direction && !row.coupled;
    });
    return at == base.standard.end() ? nullptr : &chi_st[at - base.standard.begin()];
  };
  for (int joint = 0; joint < static_cast<int>(mean_speed.size()); ++joint) {
    for (const Direction direction : {Direction::both, Direction::positive, Direction::negative}) {
      double* const v = find(Basis::speed, direction, joint);
      double* const c = find(Basis::sign, direction, joint);
      if (v == nullptr || c == nullptr) {
        continue;
      }
      if (*v < 0.0) {
        *c += *v * mean_speed[joint];
        *v = 0.0;
      }
      // Asymmetric friction may be shifted by an offset: its mean tells whether it brakes.
      const double* const other = find(Basis::sign, opposite(direction), joint);
      if (*c < 0.0 && (other == nullptr || *c + *other < 0.0)) {
        *v += mean_square[joint] > 0.0 ? *c * mean_speed[joint] / mean_square[joint] : 0.0;
        *c = 0.0;
      }
      *v = std::max(*v, 0.0);
    }
  }
}

}  // namespace rivid::detail
