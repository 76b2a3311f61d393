/** The Khronos loader that a standalone app ships, and what its runtime offers. */
#pragma once

#include "xr_api.h"

/** Loads the library; openxr has a loader_path. */
ml2s_result loader_find(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error);

/** The same, and on Android initialises the loader with the app's VM and activity. */
ml2s_result loader_open(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error);

/** An instance with every extension of this library that the runtime offers; the session can then be headless. */
ml2s_result loader_create_instance(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr get_proc, ml2s_error *error);

/** Whether the instance so created has an extension. */
bool loader_offers(const char *extension);
