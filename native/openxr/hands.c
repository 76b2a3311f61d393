// The joints of the hands, in the order of XrHandJointEXT.
#include "../sdk/error.h"
#include "../sources/source.h"
#include "poses.h"
#include "runtime.h"

enum { HANDS = 2 };

static const struct {
    uint32_t stream;
    XrHandEXT hand;
} hands[HANDS] = {{ML2S_STREAM_HAND_LEFT, XR_HAND_LEFT_EXT}, {ML2S_STREAM_HAND_RIGHT, XR_HAND_RIGHT_EXT}};

static XrHandTrackerEXT trackers[HANDS];

static ml2s_result check_system(ml2s_error *error) {
    XrSystemHandTrackingPropertiesEXT tracking = {.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &tracking};
    ml2s_result result = XR_CALL(error, core, xrGetSystemProperties, xr.instance, xr.system, &properties);
    return result || tracking.supportsHandTracking
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: hands (the system has no hand tracking)");
}

static ml2s_result destroy_trackers(ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    for (uint32_t i = 0; i < HANDS; i++) {
        if (trackers[i]) {
            ml2s_result result = XR_CALL(first ? NULL : error, hands, xrDestroyHandTrackerEXT, trackers[i]);
            first = first ? first : result;
            trackers[i] = XR_NULL_HANDLE;
        }
    }
    return first;
}

static ml2s_result create_trackers(const ml2s_settings *, ml2s_error *error) {
    ml2s_result result = check_system(error);
    for (uint32_t i = 0; i < HANDS && !result; i++) {
        XrHandTrackerCreateInfoEXT info = {XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, NULL, hands[i].hand,
                                           XR_HAND_JOINT_SET_DEFAULT_EXT};
        result = XR_CALL(error, hands, xrCreateHandTrackerEXT, xr.session, &info, &trackers[i]);
    }
    if (result) {
        destroy_trackers(NULL);
    }
    return result;
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_HANDS), create_trackers, settings, error);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) { return xr_end(destroy_trackers(error), error); }

static ml2s_result locate(uint32_t hand, const struct poses_time *now, struct readings *readings, ml2s_error *error) {
    XrHandJointLocationEXT joints[XR_HAND_JOINT_COUNT_EXT];
    XrHandJointsLocateInfoEXT info = {XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, NULL, xr.world, now->time};
    XrHandJointLocationsEXT located = {
        .type = XR_TYPE_HAND_JOINT_LOCATIONS_EXT, .jointCount = XR_HAND_JOINT_COUNT_EXT, .jointLocations = joints};
    ml2s_result result = XR_CALL(error, hands, xrLocateHandJointsEXT, trackers[hand], &info, &located);
    if (result) {
        return result;
    }
    for (uint32_t i = 0; i < XR_HAND_JOINT_COUNT_EXT; i++) {
        bool is_tracked = located.isActive && poses_is_tracked(joints[i].locationFlags, &joints[i].pose);
        ml2s_reading joint;
        poses_fill(&joint, hands[hand].stream, now, &joints[i].pose, is_tracked);
        joint.id = i;
        readings_add(readings, &joint);
    }
    return ML2S_OK;
}

static ml2s_result poll_readings(const ml2s_settings *settings, struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    ml2s_result result = xr_handle_events(error);
    if (!result) {
        result = poses_now(&now, error);
    }
    for (uint32_t i = 0; i < HANDS && !result; i++) {
        if (settings->streams & ML2S_STREAM_BIT(hands[i].stream)) {
            result = locate(i, &now, readings, error);
        }
    }
    return result;
}

const struct source_ops openxr_hands = {
    .require = xr_require, .open = begin, .poll_readings = poll_readings, .close = end};
