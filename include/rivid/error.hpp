#pragma once

#include <stdexcept>
#include <string>

namespace rivid {

/// Base of everything that rivid throws. The message is one line that names the function or file, the
/// argument, line, column or joint, the value got with its unit, and what is required.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the caller gave can not be used: a file, a robot, a log, an option.
class InputError : public Error {
 public:
  using Error::Error;
};

/// Arithmetic gave up where no result can carry the outcome.
class NumericsError : public Error {
 public:
  using Error::Error;
};

}  // namespace rivid
