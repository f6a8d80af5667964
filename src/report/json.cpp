#include "rivid/report/json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/provenance_json.hpp"
#include "report/warnings_json.hpp"

namespace rivid {

namespace {

using Json = nlohmann::ordered_json;

Json parameters(const Identification& result) {
  Json out = Json::array();
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    Json regrouping = Json::object();
    for (const auto& [name, coefficient] : result.base.regrouping(static_cast<Index>(i))) {
      regrouping[name] = coefficient;
    }
    out.push_back({{"name", p.name},
                   {"value", p.value},
                   {"unit", p.unit},
                   {"sigma", p.sigma},
                   {"relative_sigma_percent", p.relative_sigma_percent},
                   {"interval_95", p.interval_95},
                   {"regrouped", p.regrouped},
                   {"regrouping", std::move(regrouping)},
                   {"a_priori", p.a_priori},
                   {"verdict", name(p.verdict)},
                   {"advice", p.advice}});
  }
  return out;
}

std::vector<double> list(const Vector& v) { return {v.begin(), v.end()}; }

Json motion_error(const MotionError& e) {
  return {{"position", list(e.q)}, {"velocity", list(e.qd)}, {"acceleration", list(e.qdd)}};
}

Json iterations(const IvHistory& history) {
  Json out = Json::array();
  for (const IvIteration& i : history.iterations) {
    Json gains = Json::object();
    for (const Gain& gain : i.gains) {
      gains[gain.name] = list(gain.values);
    }
    out.push_back({{"chi", list(i.chi)},
                   {"error_norm", i.error_norm},
                   {"relative_error", i.relative_error},
                   {"joint_error_norm", list(i.joint_error_norm)},
                   {"largest_step_sigmas", i.largest_step},
                   {"simulated_to_measured", motion_error(i.to_measured)},
                   {"simulated_to_reference", motion_error(i.to_reference)},
                   {"design_inertia", list(i.J)},
                   {"gains", std::move(gains)},
                   {"condition_V", i.condition_V},
                   {"condition_VW", i.condition_VW},
                   {"steps", i.effort.steps},
                   {"right_hand_sides", i.effort.right_hand_sides},
                   {"mode_changes", i.effort.mode_changes},
                   {"safeguard", i.safeguard}});
  }
  return out;
}

Json fit(const Fit& f) {
  Json joints = Json::array();
  for (const JointFit& j : f.joints) {
    joints.push_back({{"name", j.name},
                      {"relative_error", j.relative_error},
                      {"centred_relative_error", j.centred_relative_error},
                      {"sigma_rho", j.sigma_rho},
                      {"unit", j.unit},
                      {"rows", j.rows},
                      {"left_out", j.left_out},
                      {"velocity_threshold", j.velocity_threshold}});
  }
  return {{"relative_error", f.relative_error},
          {"centred_relative_error", f.centred_relative_error},
          {"error_norm", f.error_norm},
          {"sigma_rho", f.sigma_rho},
          {"rows", f.rows},
          {"joints", std::move(joints)}};
}

Json test(const TestResult& t) { return {{"statistic", t.statistic}, {"freedom", t.freedom}, {"p", t.p}}; }

Json tests(const Diagnostics& d) {
  Json residuals = Json::array();
  for (const ResidualTests& r : d.residuals) {
    residuals.push_back({{"joint", r.joint},
                         {"whiteness", test(r.whiteness)},
                         {"autocorrelation", r.autocorrelation},
                         {"normality", test(r.normality)},
                         {"skewness", r.skewness},
                         {"excess_kurtosis", r.excess_kurtosis}});
  }
  Json out = {{"residuals", std::move(residuals)}, {"hausman", nullptr}, {"torque_lag", nullptr}};
  if (d.hausman) {
    out["hausman"] = test(d.hausman->test);
    out["hausman"]["largest_shift"] = d.hausman->largest_shift;
    out["hausman"]["parameter"] = d.hausman->parameter;
  }
  if (d.torque_lag) {
    out["torque_lag"] = {{"samples", d.torque_lag->samples},
                         {"sigma", d.torque_lag->sigma},
                         {"largest_shift", d.torque_lag->largest_shift},
                         {"parameter", d.torque_lag->parameter}};
  }
  return out;
}

Json physical_settings(const Physical& options) {
  Json masses = Json::object();
  for (const Physical::MassBounds& bounds : options.masses) {
    masses[bounds.link] = {bounds.least, bounds.most};
  }
  Json out = {{"prior", name(options.prior)},
              {"weight", options.weight},
              {"masses", std::move(masses)},
              {"total_mass", nullptr}};
  if (options.total_mass) {
    out["total_mass"] = *options.total_mass;
  }
  return out;
}

// The standard parameters, link by link.
Json links(const Robot& robot, const BaseParameters& base, const Vector& chi_st) {
  const Vector a_priori = robot.chi_st();
  Json out = Json::array();
  for (const Joint& joint : robot.joints) {
    out.push_back({{"link", joint.link}, {"joint", joint.name}, {"parameters", Json::array()}});
  }
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const StandardParameter& p = base.standard[i];
    const auto j = static_cast<std::size_t>(p.joint);
    const auto at = static_cast<Index>(i);
    out[j]["parameters"].push_back({{"name", p.name()},
                                    {"value", chi_st[at]},
                                    {"unit", unit(p.kind, robot.joints[j].type)},
                                    {"a_priori", a_priori[at]}});
  }
  return out;
}

Json physical(const Robot& robot, const BaseParameters& base, const PhysicalModel& model) {
  const PhysicalParameters& found = model.parameters;
  return {{"links", links(robot, base, found.chi_st)},
          {"chi", list(found.chi)},
          {"fit", fit(model.fit)},
          {"options", physical_settings(model.options)},
          {"cost", found.cost},
          {"distance", found.distance},
          {"divergence", found.divergence},
          {"gap", found.gap},
          {"steps", found.steps},
          {"reached", found.reached}};
}

Json essential(const Identification& result, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  Json kept = Json::array();
  for (const Index i : found.kept) {
    const double sigma = std::sqrt(found.C_chi(i, i));
    kept.push_back({{"name", result.base.parameters[static_cast<std::size_t>(i)].name},
                    {"value", found.chi[i]},
                    {"sigma", sigma},
                    {"relative_sigma_percent", 100.0 * sigma / std::abs(found.chi[i])}});
  }
  Json eliminated = Json::array();
  for (const EliminatedParameter& p : found.eliminated) {
    eliminated.push_back({{"name", p.name}, {"F", p.F}, {"p", p.p}});
  }
  return {{"parameters", std::move(kept)},
          {"eliminated", std::move(eliminated)},
          {"held", found.held},
          {"F", found.F},
          {"p", found.p},
          {"significance", model.options.significance},
          {"fit", fit(model.fit)}};
}

Json prefilter(const PrefilterReport& report) {
  Json noise = Json::array();
  for (const NoiseModel& model : report.noise) {
    noise.push_back({{"joint", model.joint}, {"ar", list(model.ar)}, {"innovation", model.innovation}});
  }
  return {{"noise", std::move(noise)},
          {"rounds", report.rounds},
          {"rows", report.rows},
          {"without", {{"chi", list(report.chi)}, {"sigma", list(report.sigma)}}}};
}

Json robust(const RobustReport& report) {
  Json joints = Json::array();
  for (const RobustJoint& joint : report.joints) {
    joints.push_back({{"name", joint.name},
                      {"scale", joint.scale},
                      {"rows", joint.rows},
                      {"below_one", joint.below_one},
                      {"below_half", joint.below_half},
                      {"rejected", joint.rejected}});
  }
  return {{"loss", name(report.options.kind)},
          {"tuning", report.options.loss().tuning},
          {"rounds", report.rounds},
          {"joints", std::move(joints)},
          {"largest_shift", report.largest_shift},
          {"parameter", report.parameter},
          {"without", {{"chi", list(report.chi)}}}};
}

Json signal_settings(const SignalOptions& s) {
  Json out = {{"rows", name(s.exact_rows() ? RowScheme::exact : RowScheme::paper)},
              {"torque_held", s.torque_held},
              {"cutoff_hz", s.cutoff_hz},
              {"order", s.order},
              {"torque_cutoff_hz", s.torque_cutoff_hz},
              {"torque_order", s.torque_order},
              {"decimation", s.decimation},
              {"trim", nullptr},
              {"velocity_threshold", s.velocity_threshold},
              {"window", nullptr},
              {"convention", s.convention == Convention::matlab ? "matlab" : "standard"}};
  if (s.trim) {
    out["trim"] = *s.trim;
  }
  if (s.window) {
    out["window"] = *s.window;
  }
  return out;
}

std::vector<std::vector<double>> rows_of(const Matrix& x) {
  std::vector<std::vector<double>> out;
  for (const auto row : x.rowwise()) {
    out.emplace_back(row.begin(), row.end());
  }
  return out;
}

// Of frame j in frame j − 1 at q_j = 0; the axes of the link frame as those of frame j, counted from 1, with their signs.
Json frame(const Chain::Link& link) {
  Json axes = Json::array();
  for (std::size_t k = 0; k < 3; ++k) {
    axes.push_back(link.signs[k] * (link.axes[k] + 1));
  }
  return {{"rotation", rows_of(link.R)}, {"origin", list(link.p)}, {"axes", std::move(axes)}};
}

Json joints(const Robot& robot) {
  Json out = Json::array();
  for (std::size_t k = 0; k < robot.joints.size(); ++k) {
    const Joint& j = robot.joints[k];
    out.push_back({{"name", j.name},
                   {"link", j.link},
                   {"type", j.type == JointType::revolute ? "revolute" : "prismatic"},
                   {"friction", name(j.friction)},
                   {"sign_speed", j.sign_speed},
                   {"rotor_inertia", j.rotor_inertia},
                   {"drive_gain", j.drive_gain},
                   {"gear_ratio", j.gear_ratio},
                   {"frame", frame(robot.chain.links[k])}});
  }
  return out;
}

Json couplings(const Robot& robot) {
  const auto joint_name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  Json out = Json::array();
  for (const Coupling& c : robot.couplings) {
    Json names = Json::array();
    for (const int j : c.joints) {
      names.push_back(joint_name(j));
    }
    out.push_back({{"motor", joint_name(c.motor)},
                   {"joints", std::move(names)},
                   {"ratios", c.ratios},
                   {"inertia", name(c.inertia)},
                   {"viscous", c.viscous},
                   {"coulomb", name(c.coulomb)},
                   {"terms", name(c.terms)}});
  }
  return out;
}

// Its rows; null without one.
Json gear_matrix(const Robot& robot) {
  return robot.gear_matrix.size() > 0 ? Json(rows_of(robot.gear_matrix)) : Json();
}

}  // namespace

std::string to_json(const Robot& robot, const Identification& result, const Provenance& provenance) {
  Json fit_members = fit(result.fit);
  fit_members["columns"] = result.columns;
  fit_members["condition"] = result.condition;
  fit_members["R_diagonal"] = std::vector<double>(result.R_diagonal.begin(), result.R_diagonal.end());
  fit_members["weights"] = result.weights;
  Json validation = Json::array();
  for (const Validation& v : result.validation) {
    Json members = {{"file", v.file}};
    members.update(fit(v.fit));
    if (v.physical) {
      members["physical"] = fit(*v.physical);
    }
    if (v.essential) {
      members["essential"] = fit(*v.essential);
    }
    validation.push_back(std::move(members));
  }
  Json covariance = {{"kind", name(result.covariance.kind)},
                     {"lag", result.covariance.lag},
                     {"decimation_factor", result.covariance.decimation_factor},
                     {"quantile_975", result.covariance.quantile_975}};
  Json out = {{"format", 1},
              {"method", result.method},
              {"status", name(result.status)},
              {"reasons", result.reasons},
              {"warnings", detail::warnings_json(result.warnings)},
              {"notes", result.notes},
              {"robot",
               {{"name", robot.name},
                {"base", robot.base},
                {"gravity", list(robot.chain.gravity)},
                {"joints", joints(robot)},
                {"coupling", couplings(robot)},
                {"gear_matrix", gear_matrix(robot)}}},
              {"parameters", parameters(result)},
              {"covariance", std::move(covariance)},
              {"fit", std::move(fit_members)},
              {"validation", std::move(validation)},
              {"provenance",
               detail::provenance_json(provenance, {{"signal", signal_settings(result.estimation.signal)}})}};
  if (result.diagnostics) {
    out["tests"] = tests(*result.diagnostics);
  }
  if (result.iv) {
    out["iterations"] = iterations(*result.iv);
    out["loop"] = {{"control_error", list(result.iv->loop.control_error)},
                   {"tracking_ratio", list(result.iv->loop.tracking_ratio)}};
    out["first_stage_F"] = list(result.iv->first_stage_F);
  }
  if (result.prefilter) {
    out["prefilter"] = prefilter(*result.prefilter);
  }
  if (result.robust) {
    out["robust"] = robust(*result.robust);
  }
  if (result.essential) {
    out["essential"] = essential(result, *result.essential);
  }
  if (result.physical) {
    out["physical"] = physical(robot, result.base, *result.physical);
  }
  // A path may hold any bytes; JSON is UTF-8.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rivid
