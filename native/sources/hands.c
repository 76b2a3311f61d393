// The joints of both hands, in the order of OpenXR's XrHandJointEXT.
#include "../sdk/dump.h"
#include "../sdk/snapshot.h"
#include "conversions.h"
#include "head_tracker.h"
#include "source.h"

#define KEY(name) MLHandTrackingKeyPoint_##name

/** The vendor's key point of each joint. */
static const uint8_t key_points[] = {
    KEY(Hand_Center), KEY(Wrist_Center),                                                   // palm, wrist
    KEY(Thumb_CMC),   KEY(Thumb_MCP),    KEY(Thumb_IP),   KEY(Thumb_Tip),                  // metacarpal to tip
    KEY(Index_Meta),  KEY(Index_MCP),    KEY(Index_PIP),  KEY(Index_DIP),  KEY(Index_Tip), // likewise
    KEY(Middle_Meta), KEY(Middle_MCP),   KEY(Middle_PIP), KEY(Middle_DIP), KEY(Middle_Tip),
    KEY(Ring_Meta),   KEY(Ring_MCP),     KEY(Ring_PIP),   KEY(Ring_DIP),   KEY(Ring_Tip),
    KEY(Pinky_Meta),  KEY(Pinky_MCP),    KEY(Pinky_PIP),  KEY(Pinky_DIP),  KEY(Pinky_Tip),
};
enum { JOINTS = sizeof key_points };

static const uint32_t streams[MLHandTrackingHandType_Count] = {ML2S_STREAM_HAND_LEFT, ML2S_STREAM_HAND_RIGHT};
static MLHandle head_tracker;
static MLHandle tracker;
static MLHandTrackingStaticData frames;

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return head_tracker_close_after(SDK_CALL(error, hand_tracking, MLHandTrackingDestroy, tracker), head_tracker,
                                    error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    MLHandTrackingSettings vendor;
    MLHandTrackingSettingsInit(&vendor);
    MLHandTrackingStaticDataInit(&frames);
    ml2s_result result = head_tracker_open(&head_tracker, error);
    if (result || (result = head_tracker_close_on_failure(
                       SDK_CALL(error, hand_tracking, MLHandTrackingCreateEx, &vendor, &tracker), head_tracker))) {
        return result;
    }
    result = SDK_CALL(error, hand_tracking, MLHandTrackingGetStaticData, tracker, &frames);
    if (result) {
        end(settings, NULL);
    }
    return result;
}

/** Adds the joints of a hand, each as it was made by now; those that are visible have a pose. */
static ml2s_result locate(const MLSnapshot *snapshot, uint32_t hand, const MLHandTrackingHandState *state,
                          const ml2s_reading *now, struct readings *readings, ml2s_error *error) {
    for (uint32_t i = 0; i < JOINTS; i++) {
        ml2s_reading joint = *now;
        MLTransform transform;
        joint.stream = streams[hand];
        joint.id = i;
        if (state->is_hand_detected && state->keypoints_mask[key_points[i]]) {
            ml2s_result result = SDK_CALL(error, snapshot, MLSnapshotGetTransform, snapshot,
                                          &frames.hand_cfuids[hand].keypoint_cfuids[key_points[i]], &transform);
            if (!result) {
                pose_set(&joint, &transform);
            } else if (result != ML2S_NO_POSE) {
                return result;
            }
        }
        readings_add(readings, &joint);
    }
    return ML2S_OK;
}

static ml2s_result poll_readings(const ml2s_settings *settings, struct readings *readings, ml2s_error *error) {
    WITH_ROOM(MLHandTrackingData) data;
    dump_begin(data.room);
    MLHandTrackingDataInit(&data.of);
    ml2s_reading now;
    struct snapshot snapshot;
    ml2s_result result = SDK_CALL(error, hand_tracking, MLHandTrackingGetData, tracker, &data.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLHandTrackingData", data);
    if ((result = pose_begin(&now, 0, error)) || (result = snapshot_take(now.device_nanos, &snapshot, error))) {
        return result;
    }
    for (uint32_t hand = 0; hand < MLHandTrackingHandType_Count && !result; hand++) {
        if (settings->streams & ML2S_STREAM_BIT(streams[hand])) {
            result = locate(snapshot.of, hand, &data.of.hand_state[hand], &now, readings, error);
        }
    }
    return snapshot_release(snapshot, result, error);
}

const struct source_ops source_hands = {.areas = HEAD_TRACKER_AREAS | 1u << SDK_HAND_TRACKING | 1u << SDK_SNAPSHOT,
                                        .open = begin,
                                        .poll_readings = poll_readings,
                                        .close = end};
