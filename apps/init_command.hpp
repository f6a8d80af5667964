#pragma once

namespace rivid::apps {

/// rivid_identify init ROBOT.urdf LOG.csv…: an experiment file to begin with. argv[0] is "init".
///
/// @return  exit code: success, no_success where something is left to be filled in
int init_command(int argc, char** argv);

}  // namespace rivid::apps
