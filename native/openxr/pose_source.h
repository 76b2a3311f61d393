/** What the sensors of ML2S_BACKEND_OPENXR that give poses share. */
#pragma once

#include "../sources/source.h"

/** For a sensor whose settings are looked at by its polls only. */
static inline ml2s_result keep_as_it_is(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    (void)error;
    return ML2S_OK;
}
