/** The instance and session that all sensors of this backend share: made or borrowed by the first that opens. */
#pragma once

#include "xr_api.h"

#define XR_AREA_BIT(area) (1u << (area))

/** Whether the app said how to reach OpenXR, and the loader that it named is there; nothing is begun. Any thread. */
ml2s_result xr_require(ml2s_error *error);

/**
 * Session and tables for areas, a mask of XR_AREA_BITs beside core and time, then make; ML2S_NOT_AVAILABLE names the
 * extension that is missing. A failure leaves nothing; a success is ended by one xr_end.
 */
ml2s_result xr_begin(uint32_t areas, ml2s_result (*make)(const ml2s_settings *settings, ml2s_error *error),
                     const ml2s_settings *settings, ml2s_error *error);

/** After what make made was ended with result; answers the first failure. */
ml2s_result xr_end(ml2s_result result, ml2s_error *error);

/** To be called by every poll: a session of our own answers its runtime's events. */
ml2s_result xr_handle_events(ml2s_error *error);
