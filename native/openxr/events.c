#include "events.h"

#include <string.h>

#include "../sdk/error.h"

enum { LOCALIZATION, FIT, CALIBRATION, KINDS };

static const struct {
    XrStructureType type;
    size_t size_bytes;
    const char *enabled_by;
} kinds[KINDS] = {
    [LOCALIZATION] = {XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML, sizeof(XrEventDataLocalizationChangedML),
                      "xrEnableLocalizationEventsML"},
    [FIT] = {XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML, sizeof(XrEventDataHeadsetFitChangedML),
             "xrEnableUserCalibrationEventsML"},
    [CALIBRATION] = {XR_TYPE_EVENT_DATA_EYE_CALIBRATION_CHANGED_ML, sizeof(XrEventDataEyeCalibrationChangedML),
                     "xrEnableUserCalibrationEventsML"},
};

static lock_t access = ATOMIC_FLAG_INIT;
static struct {
    XrResult enabled;
    bool has_event;
    latest_event event;
} latest[KINDS];

void events_reset(void) {
    lock(&access);
    memset(latest, 0, sizeof latest);
    unlock(&access);
}

static void set_enabled(uint32_t kind, XrResult enabled) {
    lock(&access);
    latest[kind].enabled = enabled;
    unlock(&access);
}

void events_enable(void) {
    if (xr.areas & XR_AREA_BIT(XR_MAP)) {
        XrLocalizationEnableEventsInfoML info = {XR_TYPE_LOCALIZATION_ENABLE_EVENTS_INFO_ML, NULL, XR_TRUE};
        set_enabled(LOCALIZATION, xr.map.xrEnableLocalizationEventsML(xr.session, &info));
    }
    if (xr.areas & XR_AREA_BIT(XR_CALIBRATION)) {
        XrUserCalibrationEnableEventsInfoML info = {XR_TYPE_USER_CALIBRATION_ENABLE_EVENTS_INFO_ML, NULL, XR_TRUE};
        XrResult enabled = xr.calibration.xrEnableUserCalibrationEventsML(xr.instance, &info);
        set_enabled(FIT, enabled);
        set_enabled(CALIBRATION, enabled);
    }
}

void events_keep(const XrEventDataBuffer *event) {
    for (uint32_t i = 0; i < KINDS; i++) {
        if (event->type == kinds[i].type) {
            lock(&access);
            memcpy(&latest[i].event, event, kinds[i].size_bytes);
            latest[i].has_event = true;
            unlock(&access);
        }
    }
}

ml2s_result events_latest(XrStructureType type, latest_event *event, ml2s_error *error) {
    for (uint32_t i = 0; i < KINDS; i++) {
        if (type == kinds[i].type) {
            lock(&access);
            bool has_event = latest[i].has_event;
            XrResult enabled = latest[i].enabled;
            *event = latest[i].event;
            unlock(&access);
            ml2s_result result = has_event ? ML2S_OK : xr_result_of(enabled, kinds[i].enabled_by, error);
            return result || has_event ? result : ML2S_TIMEOUT;
        }
    }
    return error_set(error, ML2S_INVALID_ARGUMENT, 0, "events: no kind %d is kept", (int)type);
}
