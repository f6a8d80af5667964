#pragma once

#include <map>
#include <string>

// The lists of keys in docs/experiment.md, of members in docs/result.md and of limits in docs/reliability.md,
// and the schema of experiment files, made from the fields.
namespace rivid::detail {

/// Markdown lists and tables by their names: "signal", "result.fit".
[[nodiscard]] std::map<std::string, std::string> page_tables();

/// A page with each table that follows a line "<!-- table: NAME -->" as it must be.
///
/// @throws InputError  where a name is unknown
[[nodiscard]] std::string with_tables(const std::string& page);

/// JSON Schema of experiment files, from which editors complete and check keys: docs/experiment.schema.json.
[[nodiscard]] std::string experiment_schema();

}  // namespace rivid::detail
