#pragma once

#include "experiment/toml_reader.hpp"
#include "rivid/experiment/experiment.hpp"

// The sections of an experiment file that tell how to identify.
namespace rivid::detail {

/// [signal].
///
/// @param n  joints
[[nodiscard]] SignalOptions read_signal(TomlReader keys, Index n);

/// [method], for a robot that is known.
void read_method(TomlReader keys, Experiment& out);

}  // namespace rivid::detail
