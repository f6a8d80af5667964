#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "rivid/regressor/base.hpp"

namespace rivid::detail {

/// Names and values of a file, each once.
class NamedValues {
 public:
  /// @param where  the file, as messages start with it
  explicit NamedValues(std::string where) : where_(std::move(where)) {}

  /// @throws InputError  where the value is not finite or the name is there already
  void add(const std::string& name, double value);

  /// @param node  a number, or an object with a value
  /// @throws InputError  as above, and where that is no number
  void add(const std::string& name, const nlohmann::json& node);

  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] const std::map<std::string, double>& all() const { return values_; }

  /// chi_st, (N_s), of values for all base parameters or all standard ones; see read_parameters().
  ///
  /// @throws InputError  for names that the robot does not have, or that are missing
  [[nodiscard]] Vector standard(const BaseParameters& base) const;

 private:
  std::string where_;
  std::map<std::string, double> values_;
};

}  // namespace rivid::detail
