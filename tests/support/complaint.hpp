#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "rivid/error.hpp"

namespace rivid::test {

/// What the error says that an action throws; empty where none is thrown.
template <typename Thrown = InputError, typename Action>
[[nodiscard]] std::string complaint_of(const Action& action) {
  try {
    static_cast<void>(action());
  } catch (const Thrown& error) {
    return error.what();
  }
  return "";
}

/// Whether a message contains these words.
inline testing::AssertionResult says(const std::string& message, std::string_view words) {
  if (message.find(words) != std::string::npos) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << "the message is\n  " << message << "\nwithout\n  " << words;
}

}  // namespace rivid::test
