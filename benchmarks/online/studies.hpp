#pragma once

#include <string>

// The long measurements of docs/online.md, one function each. They print tables.
namespace rivid::benchmarks {

/// @param data  folder of real logs, one folder a robot
void ur10e_study(const std::string& data, const std::string& experiment);
void pick_up_study(const std::string& data, int pick_ups);
void false_alarm_study(const std::string& data, double hours);
void push_study(const std::string& data, int pushes);
void drift_study(const std::string& data);
void tick_study(const std::string& data);

}  // namespace rivid::benchmarks
