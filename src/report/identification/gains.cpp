#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

Section gains_section(const GainReport& gains) {
  using G = GainEstimate;
  Section out{"gains", "Drive gains", "Drive gains"};
  out.blocks.push_back({Sentence{gains.scale}});
  if (!gains.identified) {
    return out;
  }
  std::string line;
  for (const G& gain : gains.joints) {
    line += (line.empty() ? "" : ", ") + number(gain.identifiable ? gain.value : gain.nominal, 5);
  }
  out.blocks.push_back({table_of(
      gains.joints,
      {{{"joint"}, [](const G& g) { return g.joint; }},
       {{"nominal", format::significant(5)}, [](const G& g) { return g.nominal; }},
       {{"estimate", format::deviation}, [](const G& g) { return Cell(g.value, g.sigma); }},
       {{"sigma", format::deviation}, [](const G& g) { return Cell(g.sigma, g.sigma); }},
       {{"95 % interval"},
        [](const G& g) { return number(g.interval_95[0], 5) + " … " + number(g.interval_95[1], 5); }},
       {{""}, [](const G& g) { return g.identifiable ? "" : "not identifiable, the nominal gain is used"; }}},
      [](const G& g) { return g.identifiable ? Mark::none : Mark::unseen; })});
  out.blocks.push_back({Sentence{"gains on the joint side that are used: " + line}});
  return out;
}

}  // namespace rivid::detail
