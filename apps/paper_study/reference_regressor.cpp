#include <algorithm>

#include "paper_study/runs.hpp"
#include "paper_study/study.hpp"

namespace rivid::study {

void reference_regressor(const Scara& scara, std::uint64_t seeds, Report& report) {
  Runs runs;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Log log = scara.log(S2, seed);
    log.q = log.q_r;
    runs.push_back(identify(scara.robot, log, {.method = Ols{}, .signal = filtered()}));
  }
  report.print(beside("Section 4.3, IDIM-OLS, filtered, W from the reference trajectory (paper: Table 1)",
                      table_1, runs));
  report.expect(std::ranges::all_of(runs, [](const Identification& run) { return off(run, 0) > 0.5; }),
                "W from the reference trajectory misses ZZ1R by more than half");
}

}  // namespace rivid::study
