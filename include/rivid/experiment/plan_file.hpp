#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/excite/excitation.hpp"
#include "rivid/fields.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// What a plan.json or forecast.json of rivid excite says of a motion.
struct PlanFile {
  std::filesystem::path path;
  double duration = 0.0;  ///< of the motion [s]
  double log_det = 0.0;   ///< of the information; −∞ where it does not determine all parameters
  bool known = false;     ///< whether earlier logs count in it
  Vector noise;           ///< assumed torque errors of each joint, σ / √rate, (n) [N·m/√Hz | N/√Hz]
  std::vector<ForecastParameter> parameters;  ///< (b)
};

/// @param path  the file, or the folder of a design
/// @throws InputError  "file: member …" where it can not be read or is no plan
[[nodiscard]] PlanFile read_plan(const std::filesystem::path& path);

/// Two plans for the same robot.
struct PlanComparison {
  struct Parameter {
    std::string name;
    std::string unit;
    double sigma_a = 0.0;
    double sigma_b = 0.0;
    double ratio = 0.0;  ///< of b to a
    double time = 0.0;   ///< that motion a must be repeated for to reach sigma_b [s]

    template <typename R = Parameter>
    static constexpr auto fields() {
      return std::tuple(
          Field{"name", &R::name, "of the base parameter"}, Field{"unit", &R::unit, "SI, joint side"},
          Field{"sigma_a", &R::sigma_a, "forecast standard deviation of plan A"},
          Field{"sigma_b", &R::sigma_b, "of plan B"}, Field{"ratio", &R::ratio, "of B to A"},
          Field{"time", &R::time, "that motion A must be repeated for to reach sigma_b", {.unit = "s"}});
    }
  };
  double sigma_ratio = 0.0;  ///< geometric mean of `ratio` over the parameters that both motions show
  /// That motion a must be repeated for until its information has the determinant of b's, T_a exp((log det b
  /// − log det a) / b) [s]; infinite where a does not determine all parameters, not a number where earlier
  /// logs count in a plan.
  double time = 0.0;
  bool same_noise = true;  ///< whether both assume the same torque errors
  std::vector<Parameter> parameters;
};

/// @throws InputError  where the plans have not the same base parameters
[[nodiscard]] PlanComparison compare(const PlanFile& a, const PlanFile& b);

/// Reported standard deviations of an identification beside those of the plan of its motion.
struct PlanCheck {
  struct ParameterRatio {
    std::string name;
    std::string unit;
    double forecast = 0.0;  ///< standard deviation
    double reported = 0.0;
    double ratio = 0.0;  ///< reported over forecast
    bool apart = false;  ///< whether that is not between 1 / disagreement and disagreement

    template <typename R = ParameterRatio>
    static constexpr auto fields() {
      return std::tuple(Field{"name", &R::name, "of the base parameter"},
                        Field{"unit", &R::unit, "SI, joint side"},
                        Field{"forecast", &R::forecast, "standard deviation of the plan"},
                        Field{"reported", &R::reported, "standard deviation of the identification"},
                        Field{"ratio", &R::ratio, "reported over forecast"},
                        Field{"apart", &R::apart, "whether the ratio is not between 2/3 and 3/2"});
    }
  };
  /// The parameters of one link and joint together.
  struct JointRatio {
    std::string name;
    Index parameters = 0;
    double ratio = 0.0;  ///< geometric mean
    bool apart = false;

    template <typename R = JointRatio>
    static constexpr auto fields() {
      return std::tuple(Field{"name", &R::name, "of the joint"},
                        Field{"parameters", &R::parameters, "base parameters that belong to it and its link"},
                        Field{"ratio", &R::ratio, "geometric mean of their ratios"},
                        Field{"apart", &R::apart, "whether that is not between 2/3 and 3/2"});
    }
  };
  static constexpr double disagreement = 1.5;  // factor; a choice

  double ratio = 0.0;  ///< geometric mean over the parameters that both know
  std::vector<ParameterRatio> parameters;
  std::vector<JointRatio> joints;
};

/// @throws InputError  where the plan has not these base parameters
void require_parameters(const PlanFile& plan, const BaseParameters& base);

/// @param robot   of the identification
/// @throws InputError  where the plan has not the base parameters of the result
[[nodiscard]] PlanCheck check_against(const PlanFile& plan, const Robot& robot, const Identification& result);

}  // namespace rivid
