// The pixel sensors: the sensor and format of each stream, and polling of several sensors.
#include <string.h>

#include "../sdk/error.h"
#include "../sources/frame.h"
#include "../sources/source.h"
#include "pixel_frame.h"
#include "runtime.h"

/** Longest wait for one sensor while another may have a frame. */
#define WAIT_NANOS UINT64_C(4000000)

/** One year: limits timeouts so that sums with them do not overflow. */
#define MAX_TIMEOUT_NANOS UINT64_C(31536000000000000)

static const struct {
    const char *path;
    XrPixelSensorFrameTypeML format;
} streams[ML2S_STREAM_EYE_TEMPLE_RIGHT + 1] = {
    [ML2S_STREAM_WORLD_CENTER] = {"/pixelsensor/world/center", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_WORLD_LEFT] = {"/pixelsensor/world/left", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_WORLD_RIGHT] = {"/pixelsensor/world/right", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_COLOR] = {"/pixelsensor/picture/center", XR_PIXEL_SENSOR_JPEG_ML},
    [ML2S_STREAM_MIXED_REALITY] = {"/pixelsensor/picture/center", XR_PIXEL_SENSOR_JPEG_ML},
    [ML2S_STREAM_DEPTH] = {"/pixelsensor/depth/center", XR_PIXEL_SENSOR_DEPTH32_ML},
    [ML2S_STREAM_INFRA] = {"/pixelsensor/depth/center", XR_PIXEL_SENSOR_DEPTH_RAW_ML},
    [ML2S_STREAM_EYE_NASAL_LEFT] = {"/pixelsensor/eye/nasal/left", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_EYE_NASAL_RIGHT] = {"/pixelsensor/eye/nasal/right", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_EYE_TEMPLE_LEFT] = {"/pixelsensor/eye/temple/left", XR_PIXEL_SENSOR_GRAYSCALE_ML},
    [ML2S_STREAM_EYE_TEMPLE_RIGHT] = {"/pixelsensor/eye/temple/right", XR_PIXEL_SENSOR_GRAYSCALE_ML},
};

/** The running pixel sensors of one handle. */
static struct source {
    struct pixel_sensor sensors[SOURCE_MAX_FRAMES];
    uint32_t count;
    ml2s_settings settings; /**< The current settings. */
    ml2s_error lost;        /**< The error by which an open source lost its sensors. */
} sources[ML2S_SENSOR_HANDS + 1];

static struct pixel_sensor describe(const ml2s_settings *settings, uint32_t stream) {
    bool is_second = settings->second_streams & ML2S_STREAM_BIT(stream);
    return (struct pixel_sensor){
        .stream = stream,
        .mode = {.path = streams[stream].path,
                 .device_stream = stream == ML2S_STREAM_MIXED_REALITY || is_second,
                 .rate_hz = settings->rate_hz,
                 .width = settings->width,
                 .height = settings->height,
                 .format = streams[stream].format,
                 .reality = stream == ML2S_STREAM_MIXED_REALITY ? XR_PIXEL_SENSOR_REALITY_MIXED_ML
                                                                : XR_PIXEL_SENSOR_REALITY_CAMERA_ML},
        .wants = settings->wants,
        .last_capture = 1,
    };
}

static bool is_same(const char *one, const char *other) { return strcmp(one, other) == 0; }

static ml2s_result stop(struct source *source, ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    while (source->count) {
        ml2s_result result = pixel_sensor_stop(&source->sensors[--source->count], first ? NULL : error);
        first = first ? first : result;
    }
    return first;
}

static ml2s_result start(const ml2s_settings *settings, ml2s_error *error) {
    struct source *source = &sources[settings->sensor];
    for (uint32_t stream = 0; stream < sizeof streams / sizeof *streams; stream++) {
        if (!(settings->streams & ML2S_STREAM_BIT(stream))) {
            continue;
        }
        struct pixel_sensor *sensor = &source->sensors[source->count];
        *sensor = describe(settings, stream);
        ml2s_result result = source->count && is_same(sensor[-1].mode.path, sensor->mode.path)
                                 ? error_set(error, ML2S_INVALID_ARGUMENT, 0,
                                             "%s: expected one of its streams, found two", sensor->mode.path)
                                 : pixel_sensor_start(sensor, error);
        if (result) {
            stop(source, NULL);
            return result;
        }
        source->count++;
    }
    source->settings = *settings;
    return ML2S_OK;
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_FUTURE) | XR_AREA_BIT(XR_PIXEL), start, settings, error);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    struct source *source = &sources[settings->sensor];
    return xr_end(stop(source, error), error);
}

/** Starts the previous streams again, or else leaves the source without sensors, which each poll then says. */
static void restore(struct source *source) {
    const ml2s_settings before = source->settings;
    source->lost = (ml2s_error){.struct_size = sizeof source->lost};
    start(&before, &source->lost);
}

/** Stopping comes first, since two streams of a sensor do not run at a time. */
static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    struct source *source = &sources[settings->sensor];
    ml2s_result result = stop(source, error);
    if (result || (result = start(settings, error))) {
        restore(source);
    }
    return result;
}

/** Returns the sensor with the oldest last frame, whose next frame is due first. */
static uint32_t oldest_sensor(const struct source *source) {
    uint32_t due = 0;
    for (uint32_t i = 1; i < source->count; i++) {
        if (source->sensors[i].last_capture < source->sensors[due].last_capture) {
            due = i;
        }
    }
    return due;
}

/** Polls each sensor once, and waits for the one that is due. */
static ml2s_result poll_sensors(struct source *source, uint64_t wait_nanos, struct frameset *set, ml2s_error *error) {
    uint32_t due = oldest_sensor(source);
    for (uint32_t i = 0; i < source->count; i++) {
        ml2s_result result =
            pixel_frame_get(&source->sensors[(due + i) % source->count], i ? 0 : wait_nanos, set, error);
        if (result && result != ML2S_TIMEOUT) {
            return result;
        }
    }
    return ML2S_OK;
}

static ml2s_result poll(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set,
                        ml2s_error *error) {
    struct source *source = &sources[settings->sensor];
    if (!source->count) {
        return error_set(error, ML2S_VENDOR_FAILURE, source->lost.vendor_code,
                         "no stream runs, close the sensor and open it again: the new settings failed, and the "
                         "previous ones could not be started again (%s)",
                         source->lost.message);
    }
    int64_t until = ml2s_now() + (int64_t)(timeout_nanos < MAX_TIMEOUT_NANOS ? timeout_nanos : MAX_TIMEOUT_NANOS);
    ml2s_result result = xr_handle_events(error);
    while (!result && !set->count) {
        int64_t left = until - ml2s_now();
        uint64_t wait = left < 0 ? 0 : (uint64_t)left < WAIT_NANOS ? (uint64_t)left : WAIT_NANOS;
        result = poll_sensors(source, wait, set, error);
        if (left <= 0) {
            break;
        }
    }
    return result;
}

const struct source_ops openxr_pixels = {
    .require = xr_require, .open = begin, .configure = configure, .poll = poll, .close = end};
