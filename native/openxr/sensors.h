/** What stands behind ML2S_BACKEND_OPENXR, for the table in sources/handles.c. */
#pragma once

#include "../sources/source.h"

extern const struct source_ops openxr_pixels; /**< DEPTH, WORLD, EYE and COLOR. */
extern const struct source_ops openxr_head, openxr_gaze, openxr_hands;

/** For a sensor whose settings are looked at by its polls only. */
static inline ml2s_result keep_as_it_is(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    (void)error;
    return ML2S_OK;
}
