#pragma once

#include <string>

// The long measurements of docs/online.md, one function each. They print tables.
namespace rivid::benchmarks {

/// @param data  folder of real logs, one folder a robot
/// @param arm   the only one that is simulated; empty: all
void ur10e_study(const std::string& data, const std::string& experiment);
void pick_up_study(const std::string& data, int pick_ups, const std::string& arm);
void bound_study(const std::string& data, int pick_ups, const std::string& arm);
void false_alarm_study(const std::string& data, double hours, const std::string& arm);
void push_study(const std::string& data, int each, const std::string& arm);
void drift_study(const std::string& data, const std::string& arm);
void tick_study(const std::string& data, int repetitions);

}  // namespace rivid::benchmarks
