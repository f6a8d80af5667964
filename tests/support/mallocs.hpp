#pragma once

#include "support/allocations.hpp"

// Makes allocations.hpp count what goes to malloc as well, as Eigen's memory does, in the library too. For
// tests that rivid_count_mallocs() of tests/CMakeLists.txt links with -Wl,--wrap=malloc.

extern "C" void* __real_malloc(std::size_t size);
extern "C" void* __wrap_malloc(std::size_t size);
extern "C" void* __wrap_malloc(std::size_t size) {
  ++rivid::test::allocations;
  return __real_malloc(size);
}
