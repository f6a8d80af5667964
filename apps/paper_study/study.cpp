#include "paper_study/study.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <span>

#include "rivid/output.hpp"
#include "rivid/text.hpp"

namespace rivid::study {

void Report::print(const std::string& text) {
  std::cout << text << std::flush;
  text_ += text;
}

void Report::figure(const std::string& heading, std::vector<detail::Chart> charts) {
  std::vector<detail::Plot> plots;
  const bool wide = charts.front().size == detail::Chart::Size::wide;
  for (detail::Chart& chart : charts) {
    chart.id = "chart-" + std::to_string(++charts_);
    chart.label = chart.title + ", " + chart.y_label + " over " + chart.x_label;
    plots.emplace_back(std::move(chart));
  }
  figures_.push_back(
      {.heading = heading, .blocks = {detail::plots_block(wide ? "" : "panels", std::move(plots))}});
}

void Report::expect(bool holds, const std::string& claim) {
  if (!holds) {
    broken_.push_back(claim);
  }
}

void Report::finish() {
  detail::List claims{"reasons"};
  for (const std::string& claim : broken_) {
    print("\ndoes not hold: " + claim + '\n');
    claims.items.push_back({.text = claim});
  }
  write_file(folder_ / "tables.txt", text_);
  detail::Document page;
  page.title = "Case study of [RIV]";
  page.heading = "SCARA of [RIV], section 4, in simulation";
  page.subtitle = "the tables are in tables.txt";
  page.headline = all_hold() ? "All that it claims holds" : "These claims do not hold";
  page.verdict = all_hold() ? detail::Mark::good : detail::Mark::bad;
  page.opening = {{std::move(claims)}};
  page.sections = std::move(figures_);
  write_file(folder_ / "figures.html", detail::html_of(page));
  std::cout << "\nwrote to " << folder_.string() << ": tables.txt, figures.html\n";
}

std::string aligned(const Table& rows) {
  detail::Table table;
  for (const std::string& title : rows.front()) {
    table.columns.push_back({title});
  }
  for (const auto& row : std::span(rows).subspan(1)) {
    table.rows.push_back({{row.begin(), row.end()}});
  }
  detail::Document out;
  out.opening = {{std::move(table)}};
  return detail::text_of(out).substr(1);  // behind the line of the verdict, which is empty
}

std::string percent(double part) { return number(100.0 * part, 3) + " %"; }

Runs over(std::uint64_t seeds, const std::function<Identification(std::uint64_t)>& identified) {
  Runs out;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    out.push_back(identified(seed));
  }
  return out;
}

Runs only_identified(const Runs& runs) {
  Runs out;
  std::ranges::copy_if(runs, std::back_inserter(out), identified);
  return out;
}

std::string how_many(const Runs& all) {
  return std::to_string(std::ranges::count_if(all, identified)) + " of " + std::to_string(all.size()) +
         " identified";
}

bool identified(const Identification& found) { return found.status == Status::identified; }

double value(const Identification& found, std::size_t i) {
  return in_paper[i] * found.chi[static_cast<Index>(i)];
}

double sigma(const Identification& found, std::size_t i) { return in_paper[i] * found.parameters[i].sigma; }

double off(const Identification& found, std::size_t i) { return std::abs(value(found, i) / truth(i) - 1.0); }

double error_of_instruments(const Identification& found) {
  return found.iv.value().iterations.back().relative_error;
}

double mean(const Runs& runs, const std::function<double(const Identification&)>& of) {
  double sum = 0.0;
  for (const Identification& run : runs) {
    sum += of(run);
  }
  return sum / static_cast<double>(runs.size());
}

double mean_ratio(const Runs& runs, std::size_t i) {
  return mean(runs, [i](const Identification& run) { return value(run, i); }) / truth(i);
}

double scatter(const Runs& runs, std::size_t i) {
  const double average = truth(i) * mean_ratio(runs, i);
  const double squares =
      mean(runs, [&](const Identification& run) { return std::pow(value(run, i) - average, 2); });
  const auto count = static_cast<double>(runs.size());
  return std::sqrt(squares * count / std::max(count - 1.0, 1.0));
}

bool all(const Runs& runs, const std::function<bool(const Identification&)>& holds) {
  return std::ranges::all_of(runs, holds);
}

namespace {

std::string with_sigma(double chi, double sigma_chi) { return number(chi, 4) + " ± " + number(sigma_chi, 2); }

std::string iterations(const Runs& runs) {
  const auto count = [](const Identification& run) { return run.iv->iterations.size() - 1; };
  const auto [least, most] = std::ranges::minmax(runs, {}, count);
  return "in " + std::to_string(count(least)) +
         (count(most) > count(least) ? " to " + std::to_string(count(most)) : "") + " iterations";
}

// How the runs of a procedure ended, and how well they fit.
std::string outcome(const Procedure& procedure) {
  std::string out = "  " + procedure.name + ": " + how_many(procedure.runs);
  const Runs runs = only_identified(procedure.runs);
  if (runs.empty()) {
    return out + '\n';
  }
  const bool iv = runs[0].iv.has_value();
  out += (iv ? ", " + iterations(runs) : "") + "; ‖Y − Wχ‖ / ‖Y‖ " +
         percent(mean(runs, [](const Identification& run) { return run.fit.relative_error; }));
  return out + (iv ? ", ‖Y − Vχ‖ / ‖Y‖ " + percent(mean(runs, error_of_instruments)) : "") + '\n';
}

}  // namespace

std::string beside(const std::string& title, const PaperTable& paper,
                   const std::vector<Procedure>& procedures) {
  Table rows = {{"parameter", "unit", "truth", "paper ± σ"}};
  for (const Procedure& procedure : procedures) {
    rows[0].insert(rows[0].end(), {procedure.name + " ± σ", "scatter"});
  }
  for (std::size_t i = 0; i < b; ++i) {
    auto& row = rows.emplace_back(std::vector<std::string>{
        names[i], units[i], number(truth(i), 4), with_sigma(paper.chi[i], 0.5 * paper.two_sigma[i])});
    for (const Procedure& procedure : procedures) {
      const Runs runs = only_identified(procedure.runs);
      if (runs.empty()) {
        row.insert(row.end(), 2, "–");
        continue;
      }
      const double deviation = mean(runs, [i](const Identification& run) { return sigma(run, i); });
      row.push_back(with_sigma(truth(i) * mean_ratio(runs, i), deviation));
      row.push_back(number(scatter(runs, i), 2));
    }
  }
  std::string out = "\n" + title + "\n\n" + aligned(rows);
  for (const Procedure& procedure : procedures) {
    out += outcome(procedure);
  }
  if (paper.relative_error > 0.0) {
    out += "  paper: ‖Y − Wχ‖ / ‖Y‖ " + percent(paper.relative_error) + '\n';
  }
  return out;
}

}  // namespace rivid::study
