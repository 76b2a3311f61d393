#include "session.h"

#include <stdatomic.h>

#include "../sdk/error.h"
#include "events.h"

#define READY_WITHIN_NANOS INT64_C(5000000000)

static atomic_flag is_polling = ATOMIC_FLAG_INIT;
static atomic_bool is_running;
static atomic_bool is_lost;
static atomic_bool has_moved;
static atomic_bool was_in_focus;

static ml2s_result change_state(XrSessionState state, ml2s_error *error) {
    switch (state) {
    case XR_SESSION_STATE_READY: {
        XrSessionBeginInfo info = {XR_TYPE_SESSION_BEGIN_INFO, NULL, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
        ml2s_result result = XR_CALL(error, core, xrBeginSession, xr.session, &info);
        atomic_store(&is_running, !result);
        return result;
    }
    case XR_SESSION_STATE_FOCUSED:
        if (!atomic_exchange(&was_in_focus, true)) {
            events_enable();
        }
        return ML2S_OK;
    case XR_SESSION_STATE_STOPPING:
        atomic_store(&is_running, false);
        return XR_CALL(error, core, xrEndSession, xr.session);
    case XR_SESSION_STATE_LOSS_PENDING:
    case XR_SESSION_STATE_EXITING:
        atomic_store(&is_lost, true);
        return ML2S_OK;
    default:
        return ML2S_OK;
    }
}

static ml2s_result handle(const XrEventDataBuffer *event, ml2s_error *error) {
    switch (event->type) {
    case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED:
        return change_state(((const XrEventDataSessionStateChanged *)event)->state, error);
    case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
        atomic_store(&is_lost, true);
        return ML2S_OK;
    case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING:
        if (((const XrEventDataReferenceSpaceChangePending *)event)->referenceSpaceType ==
            XR_REFERENCE_SPACE_TYPE_LOCAL) {
            atomic_store(&has_moved, true);
        }
        return ML2S_OK;
    default:
        events_keep(event);
        return ML2S_OK;
    }
}

static ml2s_result poll_events(ml2s_error *error) {
    for (;;) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        XrResult polled = xr.core.xrPollEvent(xr.instance, &event);
        if (polled == XR_EVENT_UNAVAILABLE) {
            return ML2S_OK;
        }
        ml2s_result result = xr_result_of(polled, "xrPollEvent", error);
        if (result || (result = handle(&event, error))) {
            return result;
        }
    }
}

ml2s_result session_handle_events(ml2s_error *error) {
    ml2s_result result = ML2S_OK;
    if (!atomic_flag_test_and_set(&is_polling)) {
        result = poll_events(error);
        atomic_flag_clear(&is_polling);
    }
    return result || !atomic_load(&is_lost)
               ? result
               : error_set(error, ML2S_VENDOR_FAILURE, XR_ERROR_SESSION_LOST,
                           "the OpenXR session is lost: close all its sensors and open them again");
}

bool session_world_moved(void) { return atomic_exchange(&has_moved, false); }

static ml2s_result wait_until_running(ml2s_error *error) {
    for (int64_t until = ml2s_now() + READY_WITHIN_NANOS; ml2s_now() < until; sleep_millisecond()) {
        ml2s_result result = session_handle_events(error);
        if (result || atomic_load(&is_running)) {
            return result;
        }
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "the OpenXR session was not ready within 5 s");
}

ml2s_result session_create(ml2s_error *error) {
    XrSessionCreateInfo info = {.type = XR_TYPE_SESSION_CREATE_INFO, .systemId = xr.system};
    ml2s_result result = XR_CALL(error, core, xrCreateSession, xr.instance, &info, &xr.session);
    if (result) {
        return result;
    }
    atomic_store(&is_running, false);
    atomic_store(&is_lost, false);
    atomic_store(&has_moved, false);
    atomic_store(&was_in_focus, false);
    events_reset();
    result = wait_until_running(error);
    if (result) {
        session_destroy(NULL);
    }
    return result;
}

ml2s_result session_destroy(ml2s_error *error) {
    ml2s_result result = XR_CALL(error, core, xrDestroySession, xr.session);
    xr.session = XR_NULL_HANDLE;
    return result;
}
