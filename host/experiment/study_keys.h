// The option tables of studies' files (keys_experiment.def, keys_sweep.def).
#pragma once

#include "scene_compiler/option_table.h"

namespace raycube::experiment {

const scene::FileFormat& experiment_format();
const scene::FileFormat& sweep_format();

}  // namespace raycube::experiment
