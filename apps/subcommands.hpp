#pragma once

// The subcommands of rivid_identify: what comes before an identification. argv[0] is the name of the subcommand.
namespace rivid::apps {

/// rivid_identify init ROBOT.urdf LOG.csv…: an experiment file to begin with.
///
/// @return  exit code: success, no_success where something is left to be filled in
int init_command(int argc, char** argv);

/// rivid_identify check EXPERIMENT.toml.
///
/// @return  exit code: success, no_success where a finding makes an identification useless
int check_command(int argc, char** argv);

/// rivid_identify payload EXPERIMENT.toml --loaded LOG.csv.
///
/// @return  exit code: success, no_success where the payload is not identified
int payload_command(int argc, char** argv);

/// rivid_identify explain [CODE].
int explain_command(int argc, char** argv);

}  // namespace rivid::apps
