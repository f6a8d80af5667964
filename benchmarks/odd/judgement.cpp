#include "odd/judgement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>

namespace rivid::odd {

namespace {

constexpr double wrong_sigmas = 5.0;
constexpr double material_part = 0.1;
constexpr double material_of_largest = 0.02;
constexpr std::string_view naming_warning = "weak_excitation";

// Whether a text has a name as a word of its own.
bool names(const std::string& text, const std::string& name) {
  const auto part_of_a_name = [&](std::size_t at) {
    return at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) != 0);
  };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    if (!(at > 0 && part_of_a_name(at - 1)) && !part_of_a_name(at + name.size())) {
      return true;
    }
  }
  return false;
}

// The largest true value of each unit.
std::map<std::string, double> scales(const Identification& result, const Vector& truth) {
  std::map<std::string, double> out;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    double& largest = out[result.parameters[i].unit];
    largest = std::max(largest, std::abs(truth[static_cast<Index>(i)]));
  }
  return out;
}

}  // namespace

std::string_view word(Outcome outcome) {
  constexpr std::array<std::string_view, 6> words = {"honest",  "warned", "doubtful",
                                                     "refused", "wrong",  "crashed"};
  return words[static_cast<std::size_t>(outcome)];
}

Judgement judged(const Identification& result, const Vector& truth, bool inertial_only) {
  Judgement out;
  bool warned = false;
  bool beside_naming = false;
  std::string named;
  for (const Finding& finding : result.warnings) {
    if (severity(finding) == Severity::note) {
      continue;
    }
    warned = true;
    out.warnings += (out.warnings.empty() ? "" : ";") + finding.code;
    if (finding.code == naming_warning) {
      named += finding.text + ' ' + finding.subject + ' ';
    } else {
      beside_naming = true;
    }
  }
  if (result.status != Status::identified) {
    out.outcome = result.status == Status::doubtful ? Outcome::doubtful : Outcome::refused;
    return out;
  }
  const std::map<std::string, double> largest = scales(result, truth);
  bool wrong = false;
  double squares = 0.0;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const Role role_of_it = role(result.base.parameters[i].leading.kind);
    const bool inertial = role_of_it == Role::inertial || role_of_it == Role::rotor;
    if (!std::isfinite(p.sigma) || !std::isfinite(p.value) || (inertial_only && !inertial)) {
      continue;
    }
    const double chi = truth[static_cast<Index>(i)];
    const double error = std::abs(p.value - chi);
    const double scale = largest.at(p.unit);
    const auto holds = static_cast<Index>(p.interval_95[0] <= chi && chi <= p.interval_95[1]);
    ++out.counted;
    out.covered += holds;
    if (!inertial) {
      auto& of_symbol = out.friction[std::string(symbol(result.base.parameters[i].leading.kind))];
      ++of_symbol[0];
      of_symbol[1] += holds;
    }
    squares += scale > 0.0 ? std::pow(error / scale, 2) : 0.0;
    if (error > out.worst_sigmas * p.sigma && p.verdict == Verdict::identified) {
      out.worst = p.name;
      out.worst_sigmas = error / p.sigma;
      out.worst_percent = 100.0 * error / std::abs(chi);
    }
    if (p.verdict == Verdict::identified && error > wrong_sigmas * p.sigma && !names(named, p.name)) {
      wrong = true;
      out.material =
          out.material || (error > material_part * std::abs(chi) && error > material_of_largest * scale);
    }
  }
  out.rms_error = std::sqrt(squares / static_cast<double>(std::max<Index>(1, out.counted)));
  out.outcome = wrong && !beside_naming ? Outcome::wrong : warned ? Outcome::warned : Outcome::honest;
  out.material = out.material && out.outcome == Outcome::wrong;
  return out;
}

}  // namespace rivid::odd
