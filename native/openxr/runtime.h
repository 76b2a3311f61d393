/** The OpenXR instance and session that all sensors of this backend share. The first sensor that opens creates them. */
#pragma once

#include "xr_api.h"

/** Checks that ml2s_use_openxr was called and its loader exists. Creates nothing. Thread-safe. */
ml2s_result xr_require(ml2s_error *error);

/**
 * Provides the session and the function tables of areas (a mask of XR_AREA_BITs; core and time are always included),
 * and calls make. Returns ML2S_NOT_AVAILABLE with the name of a missing extension. After a failure nothing is left;
 * each success needs one xr_end.
 */
ml2s_result xr_begin(uint32_t areas, ml2s_result (*make)(const ml2s_settings *settings, ml2s_error *error),
                     const ml2s_settings *settings, ml2s_error *error);

/** Releases the session after the objects of make were destroyed with result. Returns the first failure. */
ml2s_result xr_end(ml2s_result result, ml2s_error *error);

/** Handles the events of the library's own session. Every poll must call it. */
ml2s_result xr_handle_events(ml2s_error *error);
