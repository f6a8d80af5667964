#pragma once

// The subcommands of rivid_identify that look before anything is identified.
namespace rivid::apps {

/// rivid_identify check EXPERIMENT.toml. argv[0] is "check".
///
/// @return  exit code: success, no_success where a finding makes an identification useless
int check_command(int argc, char** argv);

/// rivid_identify explain [CODE]. argv[0] is "explain".
int explain_command(int argc, char** argv);

}  // namespace rivid::apps
