#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "rivid/export/model.hpp"
#include "rivid/identify/posterior.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// Name of the main file of draw k: "arm_007.xml" of "arm.xml".
[[nodiscard]] std::filesystem::path sample_file(const std::filesystem::path& main, int k);

/// Draws as arrays of NumPy (.npz): `chi_st` (count × N_s) and `chi` (count × b) in SI on the joint side, and
/// the names of their columns, `standard_parameters` and `parameters`. Equal draws are equal bytes.
[[nodiscard]] std::string to_npz(const BaseParameters& base, const PosteriorSamples& samples);

/// Where 95 % of the draws are, by parameter, in the words of programs that draw them anew for each run:
/// arrays of an MjModel by names of joints and bodies, and parameters of the event terms of Isaac Lab.
/// Friction and rotor inertia are values; mass and centre of mass of a link, with what is fixed to it, are
/// differences from the result. Ranges know nothing of the correlations that the draws have.
///
/// @param chi_st  that differences are from, (N_s)
[[nodiscard]] std::string randomisation_ranges(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
                                               const PosteriorSamples& samples);

/// What says where files of draws come from: seed, count, the result with its SHA-256, what was held, and the
/// SHA-256 of each file by its name.
[[nodiscard]] std::string sample_manifest(const InputFile& result, const PosteriorOptions& options,
                                          const PosteriorSamples& samples,
                                          const std::vector<ExportedModel::File>& files);

}  // namespace rivid
