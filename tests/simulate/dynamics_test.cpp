#include "rivid/simulate/dynamics.hpp"

#include <gtest/gtest.h>

namespace rivid {
namespace {
TEST(Dynamics, Later) {}
}  // namespace
}  // namespace rivid
