// libinput.magicleap.so.
#include "input.h"

MLResult MLInputCreate(MLHandle *out_tracker) { return ml2sim_MLInputCreate(out_tracker); }

MLResult MLInputDestroy(MLHandle tracker) { return ml2sim_MLInputDestroy(tracker); }

MLResult MLInputGetControllerStateEx(MLHandle tracker, MLInputControllerStateEx out_states[MLInput_MaxControllers]) {
    return ml2sim_MLInputGetControllerStateEx(tracker, out_states);
}
