#include "depth_rates.h"

#include "../sdk/error.h"

/** Rates in Hz, indexed by MLDepthCameraFrameRate. */
static const uint32_t rates[] = {1, 5, 25, 30, 50, 60};
enum { RATES = sizeof rates / sizeof *rates };

ml2s_result depth_rate_of(uint32_t rate_hz, MLDepthCameraFrameRate *vendor, ml2s_error *error) {
    for (*vendor = 0; *vendor < RATES; (*vendor)++) {
        if (rates[*vendor] == rate_hz) {
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_INVALID_ARGUMENT, 0, "depth: %u Hz, expected 1, 5, 25, 30, 50 or 60", rate_hz);
}

ml2s_result depth_rates(MLHandle camera, MLDepthCameraFrameType type, uint32_t *rates_hz, uint32_t capacity,
                        uint32_t *count, ml2s_error *error) {
    MLDepthCameraCapabilityFilter filter;
    MLDepthCameraCapabilityFilterInit(&filter);
    filter.streams = 1u << type;
    MLDepthCameraCapabilityList list = {0};
    ml2s_result result;
    if ((result = sdk_require(1u << SDK_DEPTH_CAPABILITIES, error)) ||
        (result = SDK_CALL(error, depth_capabilities, MLDepthCameraGetCapabilities, camera, &filter, &list))) {
        return result;
    }
    for (uint32_t i = 0; list.capabilities && i < list.size; i++) {
        const MLDepthCameraCapability *mode = &list.capabilities[i];
        // Modes with two streams are for both ranges at once, which the interface does not deliver.
        bool is_of_range = mode->size == 1 && mode->stream_capabilities &&
                           mode->stream_capabilities->stream == filter.streams &&
                           mode->stream_capabilities->frame_rate < RATES;
        if (is_of_range && *count < capacity) {
            rates_hz[(*count)++] = rates[mode->stream_capabilities->frame_rate];
        }
    }
    return SDK_CALL(error, depth_capabilities, MLDepthCameraReleaseCapabilities, camera, &list);
}
