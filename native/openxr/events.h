/** Events of the vendor's extensions in the library's own session: the latest of each kind. Thread-safe. */
#pragma once

#include "xr_api.h"

typedef union latest_event {
    XrEventDataLocalizationChangedML localization;
    XrEventDataHeadsetFitChangedML fit;
    XrEventDataEyeCalibrationChangedML calibration;
} latest_event;

/** Forgets the events of the session before. */
void events_reset(void);

/** Asks for the events of the extensions that the runtime has. They might never come if asked for before focus. */
void events_enable(void);

/** Keeps an event if it is of one of the kinds. */
void events_keep(const XrEventDataBuffer *event);

/**
 * Copies the latest event of type. Returns ML2S_TIMEOUT if none has come yet, and the failure if the runtime refused to
 * send them.
 */
ml2s_result events_latest(XrStructureType type, latest_event *event, ml2s_error *error);
