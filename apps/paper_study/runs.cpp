#include "paper_study/runs.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "paper_study/report.hpp"

namespace rivid::study {

double value(const Identification& found, std::size_t i) {
  return in_paper[i] * found.chi[static_cast<Index>(i)];
}

double sigma(const Identification& found, std::size_t i) { return in_paper[i] * found.parameters[i].sigma; }

double off(const Identification& found, std::size_t i) { return std::abs(value(found, i) / truth[i] - 1.0); }

const IvHistory& history(const Identification& found) {
  if (!found.iv) {
    throw std::logic_error("history: " + found.title + " does not iterate");
  }
  return *found.iv;
}

std::size_t iterations(const Identification& found) { return history(found).iterations.size() - 1; }

bool identified(const Identification& found) { return found.status == Status::identified; }

double mean(const Runs& runs, const std::function<double(const Identification&)>& of) {
  double sum = 0.0;
  for (const Identification& run : runs) {
    sum += of(run);
  }
  return sum / static_cast<double>(runs.size());
}

double rms_off(const Runs& runs, std::size_t i) {
  return std::sqrt(mean(runs, [i](const Identification& run) { return std::pow(off(run, i), 2); }));
}

Runs only_identified(const Runs& runs) {
  Runs out;
  std::ranges::copy_if(runs, std::back_inserter(out), identified);
  return out;
}

namespace {

std::string with_sigma(double chi, double sigma_chi) { return number(chi, 4) + " ± " + number(sigma_chi, 2); }

double scatter(const Runs& runs, std::size_t i) {
  const double average = mean(runs, [i](const Identification& run) { return value(run, i); });
  const double squares =
      mean(runs, [&](const Identification& run) { return std::pow(value(run, i) - average, 2); });
  const auto count = static_cast<double>(runs.size());
  return std::sqrt(squares * count / std::max(count - 1.0, 1.0));
}

}  // namespace

std::string beside(const std::string& title, const PaperTable& paper, const Runs& all) {
  const Runs runs = only_identified(all);
  std::string out =
      "\n" + title + ": " + std::to_string(runs.size()) + " of " + std::to_string(all.size()) + " identified";
  if (runs.empty()) {
    return out + '\n';
  }
  if (runs[0].iv) {
    const auto [least, most] = std::ranges::minmax(runs, {}, iterations);
    out += ", in " + std::to_string(iterations(least));
    if (iterations(most) > iterations(least)) {
      out += " to " + std::to_string(iterations(most));
    }
    out += " iterations";
  }
  out += "\n\n";
  std::vector<std::vector<std::string>> rows = {
      {"parameter", "unit", "truth", "paper ± σ", "rivid ± σ", "scatter"}};
  for (std::size_t i = 0; i < b; ++i) {
    const double average = mean(runs, [i](const Identification& run) { return value(run, i); });
    const double deviation = mean(runs, [i](const Identification& run) { return sigma(run, i); });
    rows.push_back({names[i], units[i], number(truth[i], 4),
                    with_sigma(paper.chi[i], 0.5 * paper.two_sigma[i]), with_sigma(average, deviation),
                    number(scatter(runs, i), 2)});
  }
  out += table({11, 11, 8, 20, 24}, rows);
  out += "  ‖Y − Wχ‖ / ‖Y‖: " +
         percent(mean(runs, [](const Identification& run) { return run.fit.relative_error; }));
  if (runs[0].iv) {
    out += ", ‖Y − Vχ‖ / ‖Y‖: " + percent(mean(runs, [](const Identification& run) {
             return history(run).iterations.back().relative_error;
           }));
  }
  if (paper.relative_error > 0.0) {
    out += "; paper: " + percent(paper.relative_error);
  }
  return out + '\n';
}

std::string outcomes(const std::string& title, const Runs& runs) {
  std::string out = "\n" + title + '\n';
  std::vector<Status> seen;
  for (const Identification& run : runs) {
    if (std::ranges::count(seen, run.status) > 0) {
      continue;
    }
    seen.push_back(run.status);
    out += "  " + std::string(name(run.status)) + ": " +
           std::to_string(std::ranges::count(runs, run.status, &Identification::status)) + " of " +
           std::to_string(runs.size());
    if (identified(run)) {
      const Runs good = only_identified(runs);
      const auto [least, most] =
          std::ranges::minmax(good, {}, [](const Identification& found) { return value(found, 0); });
      out += ", ZZ1R from " + number(value(least, 0), 4) + " to " + number(value(most, 0), 4) + " kg·m²";
    }
    out += '\n';
    for (const std::string& reason : run.reasons) {
      out += "    " + reason + '\n';
    }
  }
  return out;
}

std::string motion_errors(const std::string& title, const Runs& all) {
  const Runs runs = only_identified(all);
  if (runs.empty()) {
    return "";
  }
  const auto errors = [&](MotionError IvIteration::* from, Index j) {
    std::string out;
    for (const auto quantity : {&MotionError::q, &MotionError::qd, &MotionError::qdd}) {
      const double error = mean(runs, [&](const Identification& run) {
        return (history(run).iterations.back().*from.*quantity)[j];
      });
      out += (out.empty() ? "" : ", ") + number(100.0 * error, 3);
    }
    return out + " %";
  };
  std::vector<std::vector<std::string>> rows = {{"", "against measured", "against reference"}};
  // Section 4.3 has one number for both joints, and 4.5 says "close to" the same.
  rows.push_back({"paper", "0.5, 5, 10 %", "1.5, 15, 30 %"});
  for (Index j = 0; j < 2; ++j) {
    rows.push_back({"joint " + std::to_string(j + 1), errors(&IvIteration::to_measured, j),
                    errors(&IvIteration::to_reference, j)});
  }
  return "\n" + title + ", relative errors of q, q̇, q̈ of the simulated motion\n\n" + table({9, 24}, rows);
}

}  // namespace rivid::study
