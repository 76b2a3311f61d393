/** The Khronos loader of a standalone app, and the extensions that its runtime offers. */
#pragma once

#include "xr_api.h"

/** Loads the library at openxr.loader_path. */
ml2s_result loader_find(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error);

/** Loads the library, and on Android initialises the loader with the app's VM and activity. */
ml2s_result loader_open(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error);

/** Creates an instance with all extensions that the library uses and the runtime offers. */
ml2s_result loader_create_instance(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr get_proc, ml2s_error *error);

/** Returns true if the runtime of that instance offers an extension. */
bool loader_offers(const char *extension);
