#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "report/words.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::in_words;
using detail::percent;
using detail::with_decimals_of;

enum class Align { left, right };

struct Column {
  std::string title;
  Align align;
};

// Rows of cells under titles, each column as wide as its widest cell; the last column is folded at blanks.
class TextTable {
 public:
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  void print(std::ostream& out) const {
    std::vector<std::string> titles;
    titles.reserve(columns_.size());
    for (const Column& column : columns_) {
      titles.push_back(column.title);
    }
    print(out, titles);
  }

  /// Without the titles.
  void print_body(std::ostream& out) const { print(out, {}); }

 private:
  static constexpr std::size_t gap = 2;
  static constexpr std::size_t line_width = 110;
  static constexpr std::size_t narrowest_fold = 30;

  void print(std::ostream& out, const std::vector<std::string>& titles) const {
    std::vector<std::size_t> widths;
    std::size_t before_last = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      std::size_t width = titles.empty() ? 0 : display_width(titles[c]);
      for (const std::vector<std::string>& row : rows_) {
        width = std::max(width, display_width(row[c]));
      }
      widths.push_back(width);
      if (c + 1 < columns_.size()) {
        before_last += width + gap;
      }
    }
    if (!titles.empty()) {
      print_row(out, titles, widths, before_last);
    }
    for (const std::vector<std::string>& row : rows_) {
      print_row(out, row, widths, before_last);
    }
  }

  void print_row(std::ostream& out, const std::vector<std::string>& cells,
                 const std::vector<std::size_t>& widths, std::size_t before_last) const {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      line += std::string(gap, ' ');
      const std::string padding(widths[c] - display_width(cells[c]), ' ');
      if (c + 1 == cells.size() && columns_[c].align == Align::left) {
        line += folded(cells[c], before_last + gap);
      } else {
        line += columns_[c].align == Align::left ? cells[c] + padding : padding + cells[c];
      }
    }
    out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }

  static std::string folded(const std::string& cell, std::size_t indent) {
    const std::size_t room = std::max(narrowest_fold, line_width - std::min(line_width, indent));
    std::string out;
    std::size_t used = 0;
    std::istringstream words(cell);
    for (std::string word; words >> word;) {
      const std::size_t width = display_width(word);
      if (used > 0 && used + 1 + width > room) {
        out += '\n' + std::string(indent, ' ');
        used = 0;
      }
      out += (used > 0 ? " " : "") + word;
      used += width + (used > 0 ? 1 : 0);
    }
    return out;
  }

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

std::string mark(Verdict verdict) {
  return verdict == Verdict::identified ? "" : verdict == Verdict::weak ? " ?" : " x";
}

// Weak parameters by their names; those that are not excited with what they need.
void print_verdicts(std::ostream& out, const std::vector<ParameterEstimate>& parameters) {
  TextTable table({{"", Align::left}, {"", Align::left}});
  std::string weak;
  for (const ParameterEstimate& p : parameters) {
    if (p.verdict == Verdict::weak) {
      weak += (weak.empty() ? "" : ", ") + p.name;
    }
  }
  if (!weak.empty()) {
    table.add({"? weak", weak});
  }
  for (const ParameterEstimate& p : parameters) {
    if (p.verdict == Verdict::not_excited) {
      table.add({"x " + p.name, p.advice});
    }
  }
  table.print_body(out);
}

void print_parameters(std::ostream& out, const Identification& result) {
  TextTable table({{"parameter", Align::left},
                   {"value", Align::right},
                   {"unit", Align::left},
                   {"sigma", Align::right},
                   {"%sigma", Align::right},
                   {"95 % interval", Align::left},
                   {"grouped from", Align::left}});
  for (const ParameterEstimate& p : result.parameters) {
    const bool known = std::isfinite(p.sigma);
    table.add({p.name + mark(p.verdict), with_decimals_of(p.value, p.sigma), p.unit,
               known ? with_decimals_of(p.sigma, p.sigma) : "-",
               known ? fixed(p.relative_sigma_percent, 3) : "-",
               known ? "[" + with_decimals_of(p.interval_95[0], p.sigma) + ", " +
                           with_decimals_of(p.interval_95[1], p.sigma) + "]"
                     : "not determined",
               p.regrouped == p.name ? "" : p.regrouped});
  }
  table.print(out);
  print_verdicts(out, result.parameters);
}

void print_fit(std::ostream& out, const Fit& fit) {
  TextTable table({{"joint", Align::left},
                   {"rows", Align::right},
                   {"left out", Align::right},
                   {"rel. error", Align::right},
                   {"centred", Align::right},
                   {"sigma_rho", Align::right},
                   {"unit", Align::left}});
  Index left_out = 0;
  for (const JointFit& joint : fit.joints) {
    table.add({joint.name, std::to_string(joint.rows), std::to_string(joint.left_out),
               percent(joint.relative_error), percent(joint.centred_relative_error),
               number(joint.sigma_rho, 4), joint.unit});
    left_out += joint.left_out;
  }
  if (fit.joints.size() > 1) {
    table.add({"all", std::to_string(fit.rows), std::to_string(left_out), percent(fit.relative_error),
               percent(fit.centred_relative_error), "", ""});
  }
  table.print(out);
}

void print_covariance(std::ostream& out, const CovarianceReport& covariance) {
  if (covariance.quantile_975 != 0.0) {
    out << "  sigma: " << in_words(covariance) << '\n';
  }
}

void print_residuals(std::ostream& out, const std::vector<ResidualTests>& residuals) {
  TextTable table({{"joint", Align::left},
                   {"autocorrelation", Align::right},
                   {"p (Ljung-Box)", Align::right},
                   {"skewness", Align::right},
                   {"exc. kurtosis", Align::right},
                   {"p (Jarque-Bera)", Align::right}});
  for (const ResidualTests& r : residuals) {
    table.add({r.joint, fixed(r.autocorrelation, 2), number(r.whiteness.p, 2), fixed(r.skewness, 2),
               fixed(r.excess_kurtosis, 2), number(r.normality.p, 2)});
  }
  table.print(out);
}

// What another model costs in fit.
void print_price(std::ostream& out, const Fit& plain, const Fit& other, const std::string& title) {
  TextTable table({{"joint", Align::left},
                   {"rel. error", Align::right},
                   {title, Align::right},
                   {"centred", Align::right},
                   {title, Align::right}});
  for (std::size_t j = 0; j < plain.joints.size(); ++j) {
    table.add({plain.joints[j].name, percent(plain.joints[j].relative_error),
               percent(other.joints[j].relative_error), percent(plain.joints[j].centred_relative_error),
               percent(other.joints[j].centred_relative_error)});
  }
  if (plain.joints.size() > 1) {
    table.add({"all", percent(plain.relative_error), percent(other.relative_error),
               percent(plain.centred_relative_error), percent(other.centred_relative_error)});
  }
  table.print(out);
}

void print_links(std::ostream& out, const BaseParameters& base, const Vector& chi_st) {
  TextTable table({{"link", Align::right}, {"standard parameters, SI on the joint side", Align::left}});
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const StandardParameter& p = base.standard[i];
    const auto joint = static_cast<std::size_t>(p.joint);
    cells.resize(std::max(cells.size(), joint + 1));
    // Glued, so that no line is broken within.
    cells[joint] += p.name() + "=" + number(chi_st[static_cast<Index>(i)], 4) + " ";
  }
  for (std::size_t j = 0; j < cells.size(); ++j) {
    table.add({std::to_string(j + 1), cells[j]});
  }
  table.print(out);
}

void print_physical(std::ostream& out, const Identification& result, const PhysicalModel& model) {
  out << "\nPhysically consistent parameters: prior " << name(model.options.prior) << " with weight "
      << number(model.options.weight, 4) << ", divergence " << number(model.parameters.divergence, 4)
      << " from the robot description\n";
  print_links(out, result.base, model.parameters.chi_st);
  out << "\nTheir price in fit\n";
  print_price(out, result.fit, model.fit, "physical");
  for (const Validation& validation : result.validation) {
    if (validation.physical) {
      out << "\nTheir price on " << validation.file << '\n';
      print_price(out, validation.fit, *validation.physical, "physical");
    }
  }
}

void print_essential(std::ostream& out, const Identification& result, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  out << "\nEssential parameters: " << found.kept.size() << " of " << result.base.size() << '\n';
  if (found.eliminated.empty()) {
    return;
  }
  TextTable kept({{"parameter", Align::left},
                  {"value", Align::right},
                  {"unit", Align::left},
                  {"sigma", Align::right},
                  {"%sigma", Align::right}});
  for (const Index i : found.kept) {
    const BaseParameter& p = result.base.parameters[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(found.C_chi(i, i));
    kept.add({p.name, with_decimals_of(found.chi[i], sigma), p.unit, with_decimals_of(sigma, sigma),
              fixed(100.0 * sigma / std::abs(found.chi[i]), 3)});
  }
  kept.print(out);
  TextTable eliminated({{"eliminated", Align::left}, {"F", Align::right}, {"p", Align::right}});
  for (const EliminatedParameter& p : found.eliminated) {
    eliminated.add({p.name, number(p.F, 3), number(p.p, 2)});
  }
  eliminated.print(out);
  for (const std::string& name : found.held) {
    out << "  " << name << " stays: without it no robot would move like this\n";
  }
  out << "\nTheir price in fit\n";
  print_price(out, result.fit, model.fit, "essential");
  for (const Validation& validation : result.validation) {
    if (validation.essential) {
      out << "\nTheir price on " << validation.file << '\n';
      print_price(out, validation.fit, *validation.essential, "essential");
    }
  }
}

void print_prefilter(std::ostream& out, const PrefilterReport& report) {
  out << "  prefilter: autoregressive noise of order ";
  for (std::size_t j = 0; j < report.noise.size(); ++j) {
    out << (j == 0 ? "" : ", ") << report.noise[j].ar.size();
  }
  out << " taken off " << report.rows << " rows, in " << counted(report.rounds, "round") << '\n';
}

void print_robust(std::ostream& out, const RobustReport& report) {
  const bool rejects = report.options.kind == RobustKind::bisquare;
  TextTable table({{"joint", Align::left},
                   {"scale", Align::right},
                   {rejects ? "no weight" : "weight below 1", Align::right},
                   {"below 1/2", Align::right}});
  for (const RobustJoint& joint : report.joints) {
    const auto share = [&](Index rows) {
      return percent(static_cast<double>(rows) / static_cast<double>(joint.rows));
    };
    table.add({joint.name, number(joint.scale, 4), share(rejects ? joint.rejected : joint.below_one),
               share(joint.below_half)});
  }
  table.print(out);
  out << "  " << in_words(report) << '\n';
}

// The residual of Y against the simulated regressor tells whether the assumed loop is the actual one.
void print_iterations(std::ostream& out, const IvHistory& history) {
  TextTable table({{"k", Align::right},
                   {"|Y - V chi| / |Y|", Align::right},
                   {"largest step", Align::right},
                   {"sim. to measured q", Align::right},
                   {"condition V", Align::right},
                   {"remark", Align::left}});
  for (std::size_t k = 0; k < history.iterations.size(); ++k) {
    const IvIteration& i = history.iterations[k];
    table.add({std::to_string(k), percent(i.relative_error),
               k == 0 ? "" : number(i.largest_step, 3) + " sigma", percent(i.to_measured.q.maxCoeff()),
               number(i.condition_V, 4), i.safeguard});
  }
  table.print(out);
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const Identification& result) {
  out << result.title << ": " << name(result.status) << ", " << result.columns << " base parameters from "
      << result.fit.rows << " rows, relative error " << percent(result.fit.relative_error) << ", condition "
      << number(result.condition, 4) << '\n';
  for (const std::string& reason : result.reasons) {
    out << "  " << reason << '\n';
  }
  TextTable findings({{"", Align::left}});
  for (const Finding& warning : result.warnings) {
    findings.add({with_cure(warning)});
  }
  findings.print_body(out);
  out << '\n';
  print_parameters(out, result);
  print_covariance(out, result.covariance);
  if (result.prefilter) {
    print_prefilter(out, *result.prefilter);
  }
  if (result.iv) {
    out << "\nIterations\n";
    print_iterations(out, *result.iv);
  }
  out << "\nFit\n";
  print_fit(out, result.fit);
  if (result.diagnostics) {
    out << "\nResidual\n";
    print_residuals(out, result.diagnostics->residuals);
    if (result.diagnostics->hausman) {
      out << "  " << in_words(*result.diagnostics->hausman) << '\n';
    }
    if (result.diagnostics->torque_lag) {
      out << "  " << in_words(*result.diagnostics->torque_lag) << '\n';
    }
  }
  if (result.robust) {
    out << "\nWeights of the rows\n";
    print_robust(out, *result.robust);
  }
  for (const Validation& validation : result.validation) {
    out << "\nValidation on " << validation.file << "\n";
    print_fit(out, validation.fit);
  }
  if (result.essential) {
    print_essential(out, result, *result.essential);
  }
  if (result.physical) {
    print_physical(out, result, *result.physical);
  }
  return out;
}

}  // namespace rivid
