#include "rivid/export/samples.hpp"

#include <algorithm>
#include <cmath>

#include "experiment/json_fields.hpp"
#include "export/joint_values.hpp"
#include "identify/figures/numpy_archive.hpp"
#include "rivid/input.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::JointValues;
using detail::Json;

// Of sorted values, between those that are nearest.
double quantile_of(const std::vector<double>& sorted, double part) {
  const double at = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

// The middle 95 % of what `value` is in each draw.
template <typename Value>
Json range_of(const std::vector<std::vector<JointValues>>& draws, const Value& value) {
  std::vector<double> values;
  values.reserve(draws.size());
  for (const std::vector<JointValues>& draw : draws) {
    values.push_back(value(draw));
  }
  std::ranges::sort(values);
  return {quantile_of(values, 0.025), quantile_of(values, 0.975)};
}

std::vector<std::string> names_of_standard(const BaseParameters& base) {
  std::vector<std::string> out;
  for (const StandardParameter& parameter : base.standard) {
    out.push_back(parameter.name());
  }
  return out;
}

double mass(const JointValues& values) { return values.inertial[static_cast<Index>(ParameterKind::M)]; }
double com(const JointValues& values, int axis) {
  return values.inertial[static_cast<Index>(ParameterKind::MX) + axis] / mass(values);
}

}  // namespace

std::filesystem::path sample_file(const std::filesystem::path& main, int k) {
  constexpr std::size_t digits = 3;  // at least: files of up to 999 samples stand in order
  std::string number = std::to_string(k);
  number.insert(0, digits - std::min(digits, number.size()), '0');
  return main.parent_path() / (main.stem().string() + "_" + number + main.extension().string());
}

std::string to_npz(const BaseParameters& base, const PosteriorSamples& samples) {
  std::vector<std::string> names;
  for (const BaseParameter& parameter : base.parameters) {
    names.push_back(parameter.name);
  }
  detail::NumpyArchive out;
  out.add("chi_st", samples.chi_st);
  out.add("chi", samples.chi);
  out.add("standard_parameters", names_of_standard(base));
  out.add("parameters", names);
  return out.finished();
}

std::string randomisation_ranges(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
                                 const PosteriorSamples& samples) {
  constexpr const char* who = "randomisation_ranges";
  const std::vector<JointValues> centre = detail::joint_values(robot, chi_st, who);
  std::vector<std::vector<JointValues>> draws;
  for (Index k = 0; k < samples.chi_st.rows(); ++k) {
    draws.push_back(detail::joint_values(robot, samples.chi_st.row(k).transpose(), who));
  }
  Json mujoco;
  Json joint_terms;
  Json mass_terms;
  Json com_terms;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const std::string& joint = robot.joints[j].name;
    const auto put = [&](const char* field, const char* term, const auto& value) {
      mujoco[field][joint] = joint_terms[joint][term] =
          range_of(draws, [&](const auto& draw) { return value(draw[j]); });
    };
    if (robot.joints[j].rotor_inertia) {
      put("dof_armature", "armature_distribution_params", [](const JointValues& v) { return v.Ia; });
    }
    if (centre[j].damping) {
      put("dof_damping", "viscous_friction_distribution_params",
          [](const JointValues& v) { return *v.damping; });
    }
    if (centre[j].friction) {
      put("dof_frictionloss", "friction_distribution_params",
          [](const JointValues& v) { return *v.friction; });
    }
    if (joint_terms.contains(joint)) {
      joint_terms[joint]["operation"] = "abs";
    }
  }
  for (std::size_t j = 0; j < centre.size(); ++j) {
    const std::string& link = robot.link_name(j);
    const Json masses = range_of(draws, [&](const auto& draw) { return mass(draw[j]) - mass(centre[j]); });
    mujoco["body_mass"][link] = masses;
    mass_terms[link] = {{"mass_distribution_params", masses}, {"operation", "add"}};
    for (int axis = 0; axis < 3; ++axis) {
      const Json range =
          range_of(draws, [&](const auto& draw) { return com(draw[j], axis) - com(centre[j], axis); });
      mujoco["body_ipos"][link].push_back(range);
      com_terms[link]["com_range"][std::string(1, static_cast<char>('x' + axis))] = range;
    }
  }
  return detail::json_text({{"format", 1},
                            {"program", "rivid_identify export"},
                            {"interval", {0.025, 0.975}},
                            {"mujoco", mujoco},
                            {"isaac_lab",
                             {{"randomize_joint_parameters", joint_terms},
                              {"randomize_rigid_body_mass", mass_terms},
                              {"randomize_rigid_body_com", com_terms}}}});
}

std::string sample_manifest(const InputFile& result, const PosteriorOptions& options,
                            const PosteriorSamples& samples, const std::vector<ExportedModel::File>& files) {
  return detail::json_text({{"format", 1},
                            {"program", "rivid_identify export"},
                            {"version", version},
                            {"result", {{"path", result.path}, {"sha256", result.sha256}}},
                            {"seed", options.seed},
                            {"count", options.count},
                            {"held", samples.held},
                            {"outputs", detail::json_list(files, [](const ExportedModel::File& file) {
                               return Json{{"path", file.path.filename().string()},
                                           {"sha256", sha256(file.text)}};
                             })}});
}

}  // namespace rivid
