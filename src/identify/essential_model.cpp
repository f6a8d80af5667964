#include "identify/essential_model.hpp"

#include <vector>

namespace rivid::detail {

void add_essential(const Robot& robot, const std::optional<Essential>& options, std::span<const Log> logs,
                   const RowFactors& data, const Matrix& root, double freedom, Identification& out) {
  if (!options) {
    return;
  }
  if (!out.C_chi.allFinite()) {
    out.notes.push_back("essential parameters were not looked for: the data do not determine all parameters");
    return;
  }
  std::vector<Matrix> q;
  for (const Log& log : logs) {
    q.push_back(log.q);
  }
  EssentialModel model;
  model.options = *options;
  model.parameters = essential(robot, out.base, out.chi, out.C_chi, root, freedom, q, *options);
  model.fit = judged(robot, data, model.parameters.chi, static_cast<Index>(model.parameters.kept.size()),
                     out.estimation.signal.convention);
  out.essential = std::move(model);
}

}  // namespace rivid::detail
