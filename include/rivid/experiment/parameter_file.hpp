#pragma once

#include <filesystem>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid {

/// Values for the parameters of a robot, by their names: all its base parameters ("ZZ1R", "Fv1", …) or all its standard
/// parameters ("XX1", …, "M1", "Fv1", …).
///
/// What the file's name ends in tells its form:
///   .json  result.json of rivid_identify or simulation.json of rivid_simulate: a list `parameters` of objects with
///          name and value; or an object, itself or its member `parameters`, from names to values, each a number or an
///          object with a value
///   .toml  names = values, in the table [parameters] or at the top
///   .csv   a header with the columns name and value; others are not looked at
///
/// @return  chi_st, (N_s), with the values asked for; base parameters stand in the places of the leading ones
/// @throws InputError  where the file can not be read; for a name that the robot does not have, with the nearest one that
///                     it has; a name twice; a value that is missing, null or not finite; names that are neither all
///                     base nor all standard parameters
[[nodiscard]] Vector read_parameters(const std::filesystem::path& path, const BaseParameters& base);

}  // namespace rivid
