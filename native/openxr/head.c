// The pose of the head, which is the VIEW space.
#include "../sdk/error.h"
#include "../sources/source.h"
#include "poses.h"
#include "runtime.h"
#include "session.h"

static XrSpace view;
static bool was_tracked;

static ml2s_result create_view(const ml2s_settings *, ml2s_error *error) {
    XrReferenceSpaceCreateInfo info = {
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, NULL, XR_REFERENCE_SPACE_TYPE_VIEW, {{0, 0, 0, 1}, {0, 0, 0}}};
    was_tracked = true;
    return XR_CALL(error, core, xrCreateReferenceSpace, xr.session, &info, &view);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(0, create_view, settings, error);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    ml2s_result result = XR_CALL(error, core, xrDestroySpace, view);
    view = XR_NULL_HANDLE;
    return xr_end(result, error);
}

static uint32_t events_of(bool is_tracked) {
    uint32_t events = session_world_moved() ? ML2S_TRACKING_NEW_SESSION : 0;
    if (is_tracked != was_tracked) {
        events |= is_tracked ? ML2S_TRACKING_RECOVERED : ML2S_TRACKING_LOST;
    }
    was_tracked = is_tracked;
    return events;
}

static ml2s_result poll_readings(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    XrPosef pose;
    ml2s_reading reading;
    bool is_tracked;
    ml2s_result result = xr_handle_events(error);
    if (result || (result = poses_now(&now, error)) ||
        (result = poses_locate(view, now.time, &pose, &is_tracked, error))) {
        return result;
    }
    poses_fill(&reading, ML2S_STREAM_HEAD_POSE, &now, &pose, is_tracked);
    reading.values[ML2S_HEAD_STATUS] = -1;
    reading.events = events_of(is_tracked);
    readings_add(readings, &reading);
    return ML2S_OK;
}

const struct source_ops openxr_head = {
    .require = xr_require, .open = begin, .poll_readings = poll_readings, .close = end};
