// The markers that the headset sees: its own detector, one at a time.
#include <string.h>

#include "../sdk/error.h"
#include "../sources/source.h"
#include "poses.h"
#include "runtime.h"

enum {
    MOST_MARKERS = 32, /**< Twice what the vendor's detector is said to follow at a time. */
    MOST_LISTED = 64,
};

#define READY_WITHIN_NANOS INT64_C(5000000000)
#define FORGOTTEN_AFTER_NANOS INT64_C(10000000000)

/** A marker that was seen. Its space follows it over snapshots. */
struct marker {
    XrSpace space;
    uint64_t number;
    char text[sizeof((ml2s_reading *)0)->name];
    float length_m, reprojection_error_m;
    int64_t seen_nanos; /**< CLOCK_BOOTTIME of the last snapshot with it. */
};

static uint32_t type;               /**< XrMarkerTypeML */
static XrMarkerDetectorML detector; /**< Null after settings that the runtime has refused. */
static struct marker markers[MOST_MARKERS];
static int64_t snapshot_nanos; /**< CLOCK_BOOTTIME of the pending snapshot; 0: none. */
static int64_t listed_nanos;   /**< That of the last one that was ready. */

static ml2s_result check_system(ml2s_error *error) {
    XrSystemMarkerUnderstandingPropertiesML understanding = {.type = XR_TYPE_SYSTEM_MARKER_UNDERSTANDING_PROPERTIES_ML};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &understanding};
    ml2s_result result = XR_CALL(error, core, xrGetSystemProperties, xr.instance, xr.system, &properties);
    return result || understanding.supportsMarkerUnderstanding
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: markers (the system does not detect them)");
}

static ml2s_result create_detector(const ml2s_settings *settings, ml2s_error *error) {
    XrMarkerDetectorSizeInfoML size = {XR_TYPE_MARKER_DETECTOR_SIZE_INFO_ML, NULL, settings->marker_length_m};
    XrMarkerDetectorArucoInfoML aruco = {XR_TYPE_MARKER_DETECTOR_ARUCO_INFO_ML, &size,
                                         (XrMarkerArucoDictML)settings->marker_dictionary};
    XrMarkerDetectorAprilTagInfoML april = {XR_TYPE_MARKER_DETECTOR_APRIL_TAG_INFO_ML, &size,
                                            (XrMarkerAprilTagDictML)settings->marker_dictionary};
    const void *kind = settings->marker_type == XR_MARKER_TYPE_ARUCO_ML       ? (const void *)&aruco
                       : settings->marker_type == XR_MARKER_TYPE_APRIL_TAG_ML ? (const void *)&april
                                                                              : (const void *)&size;
    XrMarkerDetectorCustomProfileInfoML custom = {
        .type = XR_TYPE_MARKER_DETECTOR_CUSTOM_PROFILE_INFO_ML,
        .next = kind,
        .fpsHint = XR_MARKER_DETECTOR_FPS_MAX_ML,
        .resolutionHint = XR_MARKER_DETECTOR_RESOLUTION_HIGH_ML,
        .cameraHint = settings->marker_camera == ML2S_MARKER_CAMERA_RGB ? XR_MARKER_DETECTOR_CAMERA_RGB_CAMERA_ML
                                                                        : XR_MARKER_DETECTOR_CAMERA_WORLD_CAMERAS_ML,
        .cornerRefineMethod = XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_SUBPIX_ML,
        .useEdgeRefinement = XR_TRUE,
        .fullAnalysisIntervalHint = XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_FAST_ML,
    };
    bool is_custom = settings->marker_camera != ML2S_MARKER_CAMERA_AUTO;
    XrMarkerDetectorCreateInfoML info = {XR_TYPE_MARKER_DETECTOR_CREATE_INFO_ML, is_custom ? &custom : kind,
                                         is_custom ? XR_MARKER_DETECTOR_PROFILE_CUSTOM_ML
                                                   : (XrMarkerDetectorProfileML)settings->marker_profile,
                                         (XrMarkerTypeML)settings->marker_type};
    ml2s_result result = check_system(error);
    return result ? result : XR_CALL(error, marker, xrCreateMarkerDetectorML, xr.session, &info, &detector);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    type = settings->marker_type;
    memset(markers, 0, sizeof markers);
    snapshot_nanos = listed_nanos = 0;
    return xr_begin(XR_AREA_BIT(XR_MARKER), create_detector, settings, error);
}

static ml2s_result forget(struct marker *marker, ml2s_error *error) {
    ml2s_result result = marker->space ? XR_CALL(error, core, xrDestroySpace, marker->space) : ML2S_OK;
    *marker = (struct marker){0};
    return result;
}

/** Reads what is known of a marker of the snapshot. Returns ML2S_TIMEOUT for a text that is too long. */
static ml2s_result read_marker(XrMarkerML atom, struct marker *marker, ml2s_error *error) {
    ml2s_result result = XR_CALL(error, marker, xrGetMarkerLengthML, detector, atom, &marker->length_m);
    if (result || (result = XR_CALL(error, marker, xrGetMarkerReprojectionErrorML, detector, atom,
                                    &marker->reprojection_error_m))) {
        return result;
    }
    if (type != XR_MARKER_TYPE_QR_ML) {
        return XR_CALL(error, marker, xrGetMarkerNumberML, detector, atom, &marker->number);
    }
    uint32_t count;
    XrResult read = xr.marker.xrGetMarkerStringML(detector, atom, sizeof marker->text, &count, marker->text);
    return read == XR_ERROR_SIZE_INSUFFICIENT ? ML2S_TIMEOUT : xr_result_of(read, "xrGetMarkerStringML", error);
}

/** Returns the marker of the same content, or else the place of the one that was not seen for longest. */
static struct marker *place_of(const struct marker *seen) {
    struct marker *place = &markers[0];
    for (uint32_t i = 0; i < MOST_MARKERS; i++) {
        struct marker *known = &markers[i];
        if (known->space && known->number == seen->number && !strcmp(known->text, seen->text)) {
            return known;
        }
        place = known->seen_nanos < place->seen_nanos ? known : place;
    }
    return place;
}

static ml2s_result create_space(XrMarkerML atom, XrSpace *space, ml2s_error *error) {
    // Frames of AprilTag are turned by half a turn about x.
    float turned = type == XR_MARKER_TYPE_APRIL_TAG_ML;
    XrMarkerSpaceCreateInfoML info = {
        XR_TYPE_MARKER_SPACE_CREATE_INFO_ML, NULL, detector, atom, {{turned, 0, 0, 1 - turned}, {0, 0, 0}}};
    return XR_CALL(error, marker, xrCreateMarkerSpaceML, xr.session, &info, space);
}

static ml2s_result keep(XrMarkerML atom, ml2s_error *error) {
    struct marker seen = {.seen_nanos = listed_nanos};
    ml2s_result result = read_marker(atom, &seen, error);
    if (result) {
        return result == ML2S_TIMEOUT ? ML2S_OK : result;
    }
    struct marker *known = place_of(&seen);
    if (known->seen_nanos == listed_nanos) {
        return ML2S_OK; // of the same content as another of this snapshot, or there is no room for it
    }
    bool is_same = known->space && known->number == seen.number && !strcmp(known->text, seen.text);
    if (is_same) {
        seen.space = known->space;
    } else if ((result = forget(known, error)) || (result = create_space(atom, &seen.space, error))) {
        return result;
    }
    *known = seen;
    return ML2S_OK;
}

/** Takes over the markers of the snapshot that is ready, and forgets those that were not seen for long. */
static ml2s_result list_markers(ml2s_error *error) {
    XrMarkerML atoms[MOST_LISTED];
    uint32_t count;
    listed_nanos = snapshot_nanos;
    snapshot_nanos = 0;
    ml2s_result result = XR_CALL(error, marker, xrGetMarkersML, detector, MOST_LISTED, &count, atoms);
    for (uint32_t i = 0; i < count && !result; i++) {
        result = keep(atoms[i], error);
    }
    for (uint32_t i = 0; i < MOST_MARKERS && !result; i++) {
        if (markers[i].space && listed_nanos - markers[i].seen_nanos > FORGOTTEN_AFTER_NANOS) {
            result = forget(&markers[i], error);
        }
    }
    return result;
}

static ml2s_result take_snapshot(ml2s_error *error) {
    XrMarkerDetectorSnapshotInfoML info = {.type = XR_TYPE_MARKER_DETECTOR_SNAPSHOT_INFO_ML};
    snapshot_nanos = ml2s_now();
    return XR_CALL(error, marker, xrSnapshotMarkerDetectorML, detector, &info);
}

/** Ends the pending snapshot if it is ready. */
static ml2s_result check_snapshot(ml2s_error *error) {
    XrMarkerDetectorStateML state = {.type = XR_TYPE_MARKER_DETECTOR_STATE_ML};
    ml2s_result result = XR_CALL(error, marker, xrGetMarkerDetectorStateML, detector, &state);
    if (result) {
        return result;
    }
    if (state.state == XR_MARKER_DETECTOR_STATUS_READY_ML) {
        return list_markers(error);
    }
    if (state.state == XR_MARKER_DETECTOR_STATUS_ERROR_ML) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "xrSnapshotMarkerDetectorML: the snapshot failed");
    }
    return ml2s_now() - snapshot_nanos < READY_WITHIN_NANOS
               ? ML2S_OK
               : error_set(error, ML2S_VENDOR_FAILURE, 0, "xrSnapshotMarkerDetectorML: not ready within 5 s");
}

static ml2s_result add_tracked(struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    ml2s_result result = poses_now(&now, error);
    for (uint32_t i = 0; i < MOST_MARKERS && !result; i++) {
        const struct marker *marker = &markers[i];
        XrPosef pose;
        bool is_tracked = false;
        if (marker->space && marker->seen_nanos == listed_nanos) {
            result = poses_locate(marker->space, now.time, &pose, &is_tracked, error);
        }
        if (!result && is_tracked) {
            ml2s_reading reading;
            poses_fill(&reading, ML2S_STREAM_MARKERS, &now, &pose, true);
            reading.id = marker->number;
            reading.values[ML2S_MARKER_LENGTH_M] = marker->length_m;
            reading.values[ML2S_MARKER_REPROJECTION_ERROR_M] = marker->reprojection_error_m;
            memcpy(reading.name, marker->text, sizeof reading.name);
            readings_add(readings, &reading);
        }
    }
    return result;
}

static ml2s_result poll_readings(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    ml2s_result result = xr_handle_events(error);
    if (!result && !detector) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "the marker detector did not start with its new settings");
    }
    if (!result && snapshot_nanos) {
        result = check_snapshot(error);
    }
    if (!result && !snapshot_nanos) {
        result = take_snapshot(error);
    }
    return result ? result : add_tracked(readings, error);
}

static ml2s_result destroy_detector(ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    for (uint32_t i = 0; i < MOST_MARKERS; i++) {
        ml2s_result result = forget(&markers[i], first ? NULL : error);
        first = first ? first : result;
    }
    if (detector) {
        ml2s_result result = XR_CALL(first ? NULL : error, marker, xrDestroyMarkerDetectorML, detector);
        first = first ? first : result;
    }
    detector = XR_NULL_HANDLE;
    return first;
}

static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    ml2s_result result = destroy_detector(error);
    type = settings->marker_type;
    snapshot_nanos = listed_nanos = 0;
    return result ? result : create_detector(settings, error);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) { return xr_end(destroy_detector(error), error); }

const struct source_ops openxr_markers = {
    .require = xr_require, .open = begin, .configure = configure, .poll_readings = poll_readings, .close = end};
