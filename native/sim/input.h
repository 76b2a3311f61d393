/**
 * The service behind MLInput*. Its state is in this library, beside that of the headset; libinput.magicleap.so, which
 * is a library of its own as on the headset, forwards to it.
 */
#pragma once

#include "ml_controller.h"

#define ML2SIM_INPUT_PROTOTYPE(name, parameters)                                                                       \
    extern "C" __attribute__((visibility("default"))) MLResult ml2sim_##name parameters;
ML_INPUT_FUNCTIONS(ML2SIM_INPUT_PROTOTYPE)
