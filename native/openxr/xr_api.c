#include "xr_api.h"

#include "../sdk/error.h"

/** Longer than a session takes to be ready. */
#define RETURNED_WITHIN_MS 6000

struct xr xr;

static ml2s_result ml2s_result_of(XrResult result) {
    switch ((int)result) {
    case XR_TIMEOUT_EXPIRED:
        return ML2S_TIMEOUT;
    case XR_ERROR_RUNTIME_UNAVAILABLE:
    case XR_ERROR_FORM_FACTOR_UNAVAILABLE:
    case XR_ERROR_FEATURE_UNSUPPORTED:
    case XR_ERROR_LOCALIZATION_MAP_UNAVAILABLE_ML:
        return ML2S_NOT_AVAILABLE;
    case XR_ERROR_PERMISSION_INSUFFICIENT:
    case XR_ERROR_MARKER_DETECTOR_PERMISSION_DENIED_ML:
    case XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML:
    case XR_ERROR_LOCALIZATION_MAP_IMPORT_EXPORT_PERMISSION_DENIED_ML:
    case XR_ERROR_SPATIAL_ANCHORS_PERMISSION_DENIED_ML:
    case XR_ERROR_WORLD_MESH_DETECTOR_PERMISSION_DENIED_ML:
    case XR_ERROR_FACIAL_EXPRESSION_PERMISSION_DENIED_ML:
        return ML2S_PERMISSION_DENIED;
    case XR_ERROR_TIME_INVALID:
    case XR_ERROR_MARKER_DETECTOR_LOCATE_FAILED_ML:
    case XR_ERROR_SPATIAL_ANCHORS_SPACE_NOT_LOCATABLE_ML:
    case XR_ERROR_WORLD_MESH_DETECTOR_SPACE_NOT_LOCATABLE_ML:
        return ML2S_NO_POSE;
    default:
        return XR_SUCCEEDED(result) ? ML2S_OK : ML2S_VENDOR_FAILURE;
    }
}

ml2s_result xr_result_of(XrResult result, const char *call, ml2s_error *error) {
    ml2s_result kind = ml2s_result_of(result);
    if (kind == ML2S_OK || kind == ML2S_TIMEOUT) {
        return kind;
    }
    char name[XR_MAX_RESULT_STRING_SIZE] = "XrResult";
    if (xr.core.xrResultToString) {
        xr.core.xrResultToString(xr.instance, result, name);
    }
    return error_set(error, kind, result, "%s: %s (%d)", call, name, result);
}

uint32_t xr_take_turn(turn_t *turn, ml2s_error *error) {
    uint32_t own = turn_take(turn, RETURNED_WITHIN_MS);
    if (!own) {
        error_set(error, ML2S_VENDOR_FAILURE, 0, "the OpenXR runtime has not returned to another sensor within %u ms",
                  RETURNED_WITHIN_MS);
    }
    return own;
}
