// Keys of the simulated OpenXR runtime.
#pragma once

#include "../key_table.h"

namespace ml2sim::xr {

/** Returns a new table of all keys of the runtime, with their defaults. */
KeyTable declareKeys();

/** Sets all keys to their defaults, then to those of the environment variable ML2SIM_XR; a mistake there aborts. */
void resetKeys(KeyTable &keys);

} // namespace ml2sim::xr
