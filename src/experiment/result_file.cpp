#include "rivid/experiment/result_file.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "experiment/json_node.hpp"
#include "experiment/parameter_file.hpp"
#include "identify/infer/parameter_set.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid {

namespace {

using detail::JsonNode;
using detail::NamedValues;

// Of docs/result.md; raised where a member is removed, renamed or changes its meaning.
constexpr double newest_format = 1.0;

// Of frames and of gravity, as files of other programs round them.
constexpr double tolerance = 1e-9;

std::string_view word(JointType type) { return type == JointType::revolute ? "revolute" : "prismatic"; }

JointType joint_type(const JsonNode& node) {
  const std::string found = node.text();
  for (const JointType type : {JointType::revolute, JointType::prismatic}) {
    if (found == word(type)) {
      return type;
    }
  }
  node.fail("is " + in_quotes(found) + ", must be \"revolute\" or \"prismatic\"");
}

Eigen::Vector3d vector3(const JsonNode& node) { return Eigen::Vector3d(node.numbers(3).data()); }

// Each row as long as there are rows.
Matrix square(const JsonNode& node) {
  Matrix out;
  node.read(out);
  if (out.rows() != out.cols() || !out.allFinite()) {
    node.fail("must be a square matrix of finite numbers");
  }
  return out;
}

Chain::Link link(const JsonNode& frame, JointType type) {
  Chain::Link out;
  out.type = type;
  const JsonNode rotation = frame.at("rotation");
  const Matrix R = square(rotation);
  if (R.rows() != 3 || !(R.transpose() * R).isIdentity(tolerance) || R.determinant() < 0.0) {
    rotation.fail("is no rotation");
  }
  out.R = R;
  out.p = vector3(frame.at("origin"));
  const JsonNode axes = frame.at("axes");
  const std::vector<double> signed_axes = axes.numbers(3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double axis = std::abs(signed_axes[k]);
    if (axis != 1.0 && axis != 2.0 && axis != 3.0) {
      axes.fail("must hold 1, 2 and 3, each with a sign");
    }
    out.axes[k] = static_cast<int>(axis) - 1;
    out.signs[k] = signed_axes[k] > 0.0 ? 1 : -1;
  }
  if (std::abs(link_axes(out).determinant()) != 1.0) {
    axes.fail("must hold 1, 2 and 3, each with a sign");
  }
  return out;
}

Joint joint(const JsonNode& node) {
  Joint out;
  out.name = node.at("name").text();
  out.link = node.at("link").text();
  out.type = joint_type(node.at("type"));
  node.read(out);
  return out;
}

int joint_index(const JsonNode& node, const Robot& robot) {
  const std::string wanted = node.text();
  const auto at = std::ranges::find(robot.joints, wanted, &Joint::name);
  if (at == robot.joints.end()) {
    node.fail("is " + in_quotes(wanted) + ", which is no joint of the robot");
  }
  return static_cast<int>(at - robot.joints.begin());
}

Coupling coupling(const JsonNode& node, const Robot& robot) {
  Coupling out;
  out.motor = joint_index(node.at("motor"), robot);
  for (const JsonNode& other : node.at("joints").list()) {
    out.joints.push_back(joint_index(other, robot));
  }
  node.read(out);
  return out;
}

std::string in_brackets(const Eigen::Vector3d& x) {
  return "[" + number(x.x()) + ", " + number(x.y()) + ", " + number(x.z()) + "]";
}

// The link that carries link k, −1 for the base.
int carrier(const JsonNode& joint, const Robot& robot, std::size_t k) {
  if (!joint.has("carried_by")) {
    return static_cast<int>(k) - 1;
  }
  const std::string link = joint.at("carried_by").text();
  for (std::size_t other = 0; other < robot.chain.links.size(); ++other) {
    if (robot.link_name(other) == link) {
      return static_cast<int>(other);
    }
  }
  if (link != robot.base) {
    joint.at("carried_by").fail("is " + in_quotes(link) + ", which is neither the base nor a link");
  }
  return -1;
}

Chain::Dependent dependent(const JsonNode& node, const Robot& robot) {
  Chain::Dependent out{
      .joint = node.at("name").text(), .link = node.at("link").text(), .offset = node.at("offset").number()};
  for (const auto& [name, factor] : node.at("of").json().items()) {
    const auto at = std::ranges::find(robot.joints, name, &Joint::name);
    if (at == robot.joints.end() || !factor.is_number()) {
      node.at("of").fail("must hold factors of joints of the robot");
    }
    out.terms.push_back({static_cast<int>(at - robot.joints.begin()), factor.get<double>()});
  }
  if (!node.has("curve")) {
    std::ranges::sort(out.terms, {}, &Chain::Dependent::Term::joint);  // the file has them by name
  } else if (const JsonNode curve = node.at("curve"); curve.has("pieces")) {
    curve.read(std::get<JointSpline>(out.curve.emplace(JointSpline{})));
  } else {
    curve.read(std::get<FourBarAngle>(out.curve.emplace(FourBarAngle{})));
  }
  return out;
}

// The member `robot` of a result, without a-priori values.
Robot result_robot(const JsonNode& robot) {
  Robot out;
  out.name = robot.at("name").text();
  out.base = robot.at("base").text();
  out.chain.gravity = vector3(robot.at("gravity"));
  out.base_joints = robot.has("base_joints") ? static_cast<Index>(robot.at("base_joints").number()) : 0;
  std::vector<JsonNode> joints = robot.at("joints").list();
  for (const JsonNode& node : joints) {
    out.joints.push_back(joint(node));
  }
  if (robot.has("dependent")) {
    for (const JsonNode& node : robot.at("dependent").list()) {
      out.chain.dependents.push_back(dependent(node, out));
      joints.push_back(node);
    }
  }
  for (const JsonNode& node : joints) {
    out.chain.links.push_back(link(node.at("frame"), joint_type(node.at("type"))));
  }
  for (std::size_t k = 0; k < joints.size(); ++k) {
    out.chain.parents.push_back(carrier(joints[k], out, k));
  }
  if (!out.chain.branches()) {
    out.chain.parents.clear();
  }
  out.inertials.assign(out.chain.links.size(), Inertial::Zero());
  for (const JsonNode& node : robot.at("coupling").list()) {
    out.couplings.push_back(coupling(node, out));
  }
  if (const JsonNode gears = robot.at("gear_matrix"); !gears.json().is_null()) {
    out.gear_matrix = square(gears);
  }
  if (const auto complaint = out.complaint()) {
    robot.fail("can not be used: " + *complaint);
  }
  return out;
}

// Refuses a result of another robot.
void expect_same_geometry(const JsonNode& node, const Robot& result, const Robot& robot) {
  const auto differs = [&](const std::string& what, const std::string& found, const std::string& wanted) {
    node.fail("is another one than \"" + robot.name + "\": " + what + " is " + found + " here and " + wanted +
              " there");
  };
  if (result.size() != robot.size()) {
    differs("the number of joints", std::to_string(result.size()), std::to_string(robot.size()));
  }
  const auto follow = [](const Chain::Dependent& a, const Chain::Dependent& b) {
    return a.joint == b.joint && std::abs(a.offset - b.offset) <= tolerance && a.curve == b.curve &&
           std::ranges::equal(a.terms, b.terms, [](const auto& x, const auto& y) {
             return x.joint == y.joint && std::abs(x.factor - y.factor) <= tolerance;
           });
  };
  if (!std::ranges::equal(result.chain.dependents, robot.chain.dependents, follow)) {
    const auto names = [](const Robot& of) {
      std::vector<std::string> out;
      for (const Chain::Dependent& each : of.chain.dependents) {
        out.push_back(each.joint);
      }
      return out.empty() ? "none" : quoted_list(out);
    };
    differs("what joints follow others, or how,", names(result), names(robot));
  }
  if ((result.chain.gravity - robot.chain.gravity).cwiseAbs().maxCoeff() > tolerance) {
    differs("gravity", in_brackets(result.chain.gravity), in_brackets(robot.chain.gravity));
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& here = result.joints[j];
    const Joint& there = robot.joints[j];
    if (here.name != there.name) {
      differs("joint " + std::to_string(j + 1), in_quotes(here.name), in_quotes(there.name));
    }
    const std::string who = "joint \"" + there.name + "\": ";
    if (result.chain.parent(j) != robot.chain.parent(j)) {
      differs(who + "the place of the link that carries it", std::to_string(result.chain.parent(j) + 1),
              std::to_string(robot.chain.parent(j) + 1));
    }
    if (here.type != there.type) {
      differs(who + "its type", std::string(word(here.type)), std::string(word(there.type)));
    }
    const Chain::Link& frame = result.chain.links[j];
    const Chain::Link& other = robot.chain.links[j];
    if ((frame.p - other.p).cwiseAbs().maxCoeff() > tolerance) {
      differs(who + "its origin in the frame before it", in_brackets(frame.p), in_brackets(other.p));
    }
    if ((frame.R - other.R).cwiseAbs().maxCoeff() > tolerance) {
      differs(who + "its axis z in the frame before it", in_brackets(frame.R.col(2)),
              in_brackets(other.R.col(2)));
    }
  }
}

constexpr const char* not_a_result = "is no result.json of rivid identify: ";

void expect_result(const JsonNode& file, const IdentifiedModelOptions& options) {
  if (!file.has("format") || !file.has("method") || !file.has("status")) {
    file.fail("is no result.json of rivid identify: it has no format, method and status");
  }
  if (const double format = file.at("format").number(); format > newest_format) {
    file.at("format").fail("is " + number(format) + ", this rivid knows " + number(newest_format) +
                           "; take the rivid that wrote the file");
  }
  std::vector<std::string> reasons;
  for (const JsonNode& reason : file.at("reasons").list()) {
    reasons.push_back(reason.text());
  }
  detail::expect_identified(file.file(), file.at("status").text(), reasons, options);
}

// chi_st, (N_s).
Vector values(const JsonNode& file, const BaseParameters& base, const IdentifiedModelOptions& options) {
  NamedValues out(file.file());
  const auto add = [&](const JsonNode& parameters) {
    for (const JsonNode& p : parameters.list()) {
      out.add(p.at("name").text(), p.at("value").json());
    }
  };
  if (detail::chosen_set(file.file(), file.has("physical"), options) == ParameterSet::estimate) {
    add(file.at("parameters"));
  } else {
    for (const JsonNode& link : file.at("physical").at("links").list()) {
      add(link.at("parameters"));
    }
  }
  return out.standard(base);
}

// The input of the run that has this name, or the first one that ends so where it begins with a point.
std::optional<IdentifiedRobot::Source> input_of_run(const JsonNode& provenance, const std::string& name) {
  for (const JsonNode& input : provenance.at("inputs").list()) {
    const std::string path = input.at("path").text();
    if (path == name || (name.starts_with('.') && std::filesystem::path(path).extension() == name)) {
      return IdentifiedRobot::Source{path, input.at("sha256").text()};
    }
  }
  return std::nullopt;
}

// A member that may be absent.
template <typename Value>
void take(const JsonNode& from, const char* member, Value& to) {
  if (from.has(member)) {
    from.at(member).read(to);
  }
}

// What the file says of its own origin. A file of another program may leave it out.
void take_provenance(const JsonNode& file, IdentifiedRobot& to) {
  if (!file.has("provenance")) {
    return;
  }
  const JsonNode provenance = file.at("provenance");
  to.run = provenance.at("run").text();
  to.experiment = input_of_run(provenance, ".toml");
  const JsonNode options = provenance.at("options");
  take(options, "signal", to.signal);
  const bool named = options.has("robot") && options.at("robot").has("urdf");
  if (!named) {
    to.urdf = input_of_run(provenance, ".urdf");
  } else if (const JsonNode urdf = options.at("robot").at("urdf"); urdf.json().is_string()) {
    to.urdf = input_of_run(provenance, urdf.text());
  }
}

IdentifiedRobot identified(const std::filesystem::path& path, const Robot* expected,
                           const IdentifiedModelOptions& options) {
  const nlohmann::json content = detail::parsed_json(path, "the result", not_a_result);
  const JsonNode file(content, path.string());
  expect_result(file, options);
  IdentifiedRobot out;
  out.robot = result_robot(file.at("robot"));
  if (expected != nullptr) {
    expect_same_geometry(file.at("robot"), out.robot, *expected);
  }
  out.chi_st = values(file, base_parameters(out.robot), options);
  out.parameters = detail::chosen_set(file.file(), file.has("physical"), options);
  out.method = file.at("method").text();
  out.status = file.at("status").text();
  for (const JsonNode& parameter : file.at("parameters").list()) {
    const auto value = [&](const char* key) {
      const bool known = parameter.has(key) && parameter.at(key).json().is_number();
      return known ? parameter.at(key).number() : std::numeric_limits<double>::quiet_NaN();
    };
    out.estimates.push_back({.name = parameter.at("name").text(),
                             .unit = parameter.has("unit") ? parameter.at("unit").text() : "",
                             .value = value("value"),
                             .sigma = value("sigma")});
  }
  take_provenance(file, out);
  return out;
}

// Bounds of the masses that a physically consistent set was found with.
void take_masses(const JsonNode& options, Physical& to) {
  take(options, "total_mass", to.total_mass);
  for (const auto& [link, bounds] : options.at("masses").json().items()) {
    Physical::MassBounds out{.link = link};
    const JsonNode node = options.at("masses").at(link.c_str());
    std::array<double, 2> values{};
    node.read(values);
    out.least = values[0];
    out.most = std::isnan(values[1]) ? out.most : values[1];
    to.masses.push_back(out);
  }
}

// What a result says of a fit and of the chosen set beside it.
void take_physical(const JsonNode& node, const BaseParameters& base, Identification& to) {
  PhysicalModel& out = to.physical.emplace();
  node.read(out.parameters);
  NamedValues links(node.file());
  for (const JsonNode& link : node.at("links").list()) {
    for (const JsonNode& p : link.at("parameters").list()) {
      links.add(p.at("name").text(), p.at("value").json());
    }
  }
  out.parameters.chi_st = links.standard(base);
  node.at("fit").read(out.fit);
  node.at("better").read(out.better);
  Vector sigma;
  node.at("sigma").read(sigma);
  out.C_chi = sigma.cwiseAbs2().asDiagonal();
  take(node, "C_chi", out.C_chi);
  take_masses(node.at("options"), out.options);
  if (out.parameters.chi.size() != base.size() || (sigma.size() > 0 && sigma.size() != base.size()) ||
      out.C_chi.rows() != sigma.size() || out.C_chi.cols() != sigma.size()) {
    node.fail("has another number of parameters than the robot");
  }
}

Validation validation(const JsonNode& node) {
  Validation out;
  node.read(out.fit);
  node.at("file").read(out.file);
  node.at("forecast").read(out.forecast);
  take(node, "physical", out.physical);
  take(node, "essential", out.essential);
  return out;
}

Finding warning(const JsonNode& node) {
  Finding out = {node.at("code").text(), node.at("subject").text(), node.at("text").text()};
  take(node, "changes", out.changes);
  return out;
}

// Estimates of a file, in the order of the base parameters of its robot.
std::vector<ParameterEstimate> estimates(const JsonNode& file, const BaseParameters& base) {
  std::vector<ParameterEstimate> out;
  file.at("parameters").read(out);
  if (!std::ranges::equal(out, base.parameters, {}, &ParameterEstimate::name, &BaseParameter::name)) {
    file.at("parameters").fail("are not the base parameters of its robot");
  }
  return out;
}

Matrix covariance_of(const JsonNode& file, const BaseParameters& base) {
  Matrix out;
  const JsonNode C_chi = file.at("covariance").at("C_chi");
  C_chi.read(out);
  if (out.rows() != out.cols() || out.rows() != base.size()) {
    C_chi.fail("must have a row and a column for each parameter");
  }
  return out;
}

Vector values_of(const std::vector<ParameterEstimate>& parameters) {
  Vector out(std::ssize(parameters));
  std::ranges::transform(parameters, out.begin(), &ParameterEstimate::value);
  return out;
}

Fit fit_of(const JsonNode& file, const Robot& robot) {
  Fit out;
  const JsonNode fit = file.at("fit");
  fit.read(out);
  if (std::ssize(out.joints) != robot.size()) {
    fit.at("joints").fail("must have one entry for each of the " + std::to_string(robot.size()) + " joints");
  }
  return out;
}

Identification identification(const JsonNode& file, const Robot& robot) {
  Identification out;
  file.at("method").read(out.method);
  file.at("status").read(out.status);
  file.at("reasons").read(out.reasons);
  file.at("notes").read(out.notes);
  for (const JsonNode& node : file.at("warnings").list()) {
    out.warnings.emplace_back(warning(node));
  }
  out.base = base_parameters(robot);
  out.parameters = estimates(file, out.base);
  out.chi = values_of(out.parameters);
  const JsonNode covariance = file.at("covariance");
  covariance.read(out.covariance);
  out.C_chi = covariance_of(file, out.base);
  take(covariance, "gain_slopes", out.gain_slopes);
  const JsonNode fit = file.at("fit");
  out.fit = fit_of(file, robot);
  fit.at("columns").read(out.columns);
  fit.at("condition").read(out.condition);
  fit.at("R_diagonal").read(out.R_diagonal);
  fit.at("weights").read(out.weights);
  for (const JsonNode& node : file.at("validation").list()) {
    out.validation.push_back(validation(node));
  }
  take(file, "forecast", out.forecast);
  take(file, "tests", out.diagnostics);
  take(file, "alternatives", out.alternatives);
  take(file, "row_choice", out.row_choice);
  take(file, "method_choice", out.method_choice);
  if (file.has("physical")) {
    take_physical(file.at("physical"), out.base, out);
  }
  if (file.has("gains") && file.at("gains").json().is_object()) {
    file.at("gains").at("C").read(out.estimation.gain_covariance);
  }
  const JsonNode options = file.at("provenance").at("options");
  options.at("signal").read(out.estimation.signal);
  Experiment ran;
  ran.take_method(out.method);
  const JsonNode robust = options.at("method").at("robust");
  out.title = std::string(title(ran.estimation.method)) + (robust.text() == "off"     ? ""
                                                           : robust.text() == "huber" ? ", Huber"
                                                                                      : ", bisquare");
  return out;
}

// @param out  without what the fit says of the joints
OnlineModel online_model(const std::string& who, OnlineModel out, const Fit& fit) {
  if (std::ssize(fit.joints) != out.robot.size()) {
    throw InputError(who + ": the result is that of another robot");
  }
  for (const auto& joint : fit.joints) {
    const auto j = &joint - fit.joints.data();
    out.sigma_rho[j] = joint.sigma_rho;
    out.velocity_threshold[j] = joint.velocity_threshold;
  }
  if (const auto fault = out.complaint()) {
    throw InputError(who + ": " + *fault);
  }
  return out;
}

}  // namespace

IdentifiedRobot read_identified_robot(const std::filesystem::path& path,
                                      const IdentifiedModelOptions& options) {
  return identified(path, nullptr, options);
}

std::pair<Robot, Identification> result_of(std::string_view text, const std::string& source) {
  const nlohmann::json content = detail::parsed_json(text, source, not_a_result);
  const JsonNode file(content, source);
  expect_result(file, {.parameters = ParameterSet::estimate, .force = true});
  Robot robot = result_robot(file.at("robot"));
  Identification found = identification(file, robot);
  return {std::move(robot), std::move(found)};
}

OnlineModel online_model(const Robot& robot, const Identification& result) {
  if (result.status != Status::identified) {
    throw InputError("online_model: the result is not identified");
  }
  const Vector none = Vector::Zero(robot.size());
  return online_model("online_model", {robot, result.base, result.chi, result.C_chi, none, none}, result.fit);
}

OnlineModel read_online_model(const std::filesystem::path& path, const IdentifiedModelOptions& options) {
  const nlohmann::json content = detail::parsed_json(path, "the result", not_a_result);
  const JsonNode file(content, path.string());
  expect_result(file, options);
  const Robot robot = result_robot(file.at("robot"));
  const BaseParameters base = base_parameters(robot);
  const Vector none = Vector::Zero(robot.size());
  return online_model(path.string(),
                      {robot, base, values_of(estimates(file, base)), covariance_of(file, base), none, none},
                      fit_of(file, robot));
}

IdentifiedArm read_identified_arm(const std::filesystem::path& path, const Robot& robot) {
  const nlohmann::json content = detail::parsed_json(path, "the result", not_a_result);
  const JsonNode file(content, path.string());
  expect_result(file, {});
  const Robot own = result_robot(file.at("robot"));
  expect_same_geometry(file.at("robot"), own, robot);
  if (const JsonNode covariance = file.at("covariance"); !covariance.has("gain_slopes")) {
    covariance.fail("has no gain_slopes, what drive gains do to the parameters; identify the arm again");
  }
  const Identification found = identification(file, own);
  const IdentifiedArm out{own, found.chi, found.C_chi, found.gain_slopes, found.estimation.gain_covariance};
  if (const auto fault = out.complaint()) {
    throw InputError(path.string() + ": " + *fault);
  }
  return out;
}

DynamicModel read_identified_model(const std::filesystem::path& path, const IdentifiedModelOptions& options) {
  const IdentifiedRobot out = identified(path, nullptr, options);
  return {out.robot, out.chi_st};
}

DynamicModel read_identified_model(const std::filesystem::path& path, const Robot& robot,
                                   const IdentifiedModelOptions& options) {
  const IdentifiedRobot out = identified(path, &robot, options);
  return {out.robot, out.chi_st};
}

}  // namespace rivid
