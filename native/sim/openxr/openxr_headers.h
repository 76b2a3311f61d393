// OpenXR's headers with the extensions of the simulated runtime, without prototypes.
#pragma once

#include <ctime>

#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include "../../openxr/xr_pixel_sensor.h"
#include <openxr/openxr_platform.h>
