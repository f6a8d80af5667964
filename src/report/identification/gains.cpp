#include <cmath>
#include <string>
#include <vector>

#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

Section gains_section(const Identification& result) {
  struct Line {
    const GainEstimate& gain;
    std::string unit;

    // A gain that the scale hangs on has a deviation of rounding alone.
    [[nodiscard]] bool exact() const { return gain.sigma < 1e-4 * std::abs(gain.value); }
  };
  using L = Line;
  const GainReport& gains = *result.gains;
  Section out{"gains", "Drive gains", "Drive gains"};
  out.blocks.push_back({Sentence{gains.scale}});
  if (!gains.identified) {
    return out;
  }
  std::vector<Line> lines;
  std::string used;
  for (std::size_t j = 0; j < gains.joints.size(); ++j) {
    const GainEstimate& gain = gains.joints[j];
    lines.push_back({gain, result.fit.joints[j].unit + "/A"});
    used += (used.empty() ? "" : ", ") + number(gain.identifiable ? gain.value : gain.nominal, 5);
  }
  out.blocks.push_back({table_of(
      lines,
      {{{"joint"}, [](const L& l) { return l.gain.joint; }},
       {{"nominal", format::significant(5)}, [](const L& l) { return l.gain.nominal; }},
       {{"estimate", format::deviation},
        [](const L& l) {
          return l.exact() ? Cell(number(l.gain.value, 5)) : Cell(l.gain.value, l.gain.sigma);
        }},
       {{"unit"}, [](const L& l) { return l.unit; }},
       {{"sigma", format::deviation},
        [](const L& l) { return l.exact() ? Cell(no_value) : Cell(l.gain.sigma, l.gain.sigma); }},
       {{"95 % interval"},
        [](const L& l) {
          return l.exact() ? "counts as exact"
                           : number(l.gain.interval_95[0], 5) + " … " + number(l.gain.interval_95[1], 5);
        }},
       {{""},
        [](const L& l) { return l.gain.identifiable ? "" : "not identifiable, the nominal gain is used"; }}},
      [](const L& l) { return l.gain.identifiable ? Mark::none : Mark::unseen; })});
  out.blocks.push_back(
      {Sentence{"Used, on the joint side: " + used + ". The unit holds for control signals in A"}});
  return out;
}

}  // namespace rivid::detail
