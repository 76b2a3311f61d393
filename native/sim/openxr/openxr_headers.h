// Khronos' header with what the simulated runtime offers beside the core, without prototypes of the loader's functions.
#pragma once

#include <ctime>

#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include "../../openxr/xr_pixel_sensor.h"
#include <openxr/openxr_platform.h>
