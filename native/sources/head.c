// The pose of the headset at the instant of its stamp.
#include "conversions.h"
#include "head_tracker.h"
#include "source.h"

static MLHandle tracker;
static MLHeadTrackingStaticData head;

/** Map events that were read and not yet delivered. The device reports each event once. */
static uint64_t events;

static ml2s_result end(const ml2s_settings *, ml2s_error *error) { return head_tracker_close(tracker, error); }

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    ml2s_result result = head_tracker_open(&tracker, error);
    if (result) {
        return result;
    }
    result = SDK_CALL(error, head, MLHeadTrackingGetStaticData, tracker, &head);
    if (result) {
        end(settings, NULL);
    }
    return result;
}

static ml2s_result poll_readings(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    MLHeadTrackingStateEx state;
    MLHeadTrackingStateExInit(&state);
    uint64_t fetched = 0;
    ml2s_reading pose;
    ml2s_result result;
    if ((result = SDK_CALL(error, head, MLHeadTrackingGetStateEx, tracker, &state)) ||
        (result = SDK_CALL(error, head, MLHeadTrackingGetMapEvents, tracker, &fetched))) {
        return result;
    }
    events |= fetched;
    if ((result = pose_begin(&pose, ML2S_STREAM_HEAD_POSE, error)) ||
        (state.status == MLHeadTrackingStatus_Valid && (result = pose_locate(&head.coord_frame_head, &pose, error)))) {
        return result;
    }
    pose.values[ML2S_HEAD_STATUS] = (float)state.status;
    pose.values[ML2S_HEAD_CONFIDENCE] = state.confidence;
    pose.values[ML2S_HEAD_ERRORS] = (float)state.error;
    pose.events = (uint32_t)events; // ML2S_TRACKING_* are the vendor's bits.
    events = 0;
    readings_add(readings, &pose);
    return ML2S_OK;
}

_Static_assert((int)ML2S_TRACKING_LOST == (int)MLHeadTrackingMapEvent_Lost &&
                   (int)ML2S_TRACKING_RECOVERED == (int)MLHeadTrackingMapEvent_Recovered &&
                   (int)ML2S_TRACKING_RECOVERY_FAILED == (int)MLHeadTrackingMapEvent_RecoveryFailed &&
                   (int)ML2S_TRACKING_NEW_SESSION == (int)MLHeadTrackingMapEvent_NewSession,
               "events of head tracking");

const struct source_ops source_head = {
    .areas = HEAD_TRACKER_AREAS | 1u << SDK_SNAPSHOT, .open = begin, .poll_readings = poll_readings, .close = end};
