// The depth camera: depth with confidence and flags, or the raw infrared picture.
#include "../sdk/dump.h"
#include "../sdk/error.h"
#include "../sdk/perception.h"
#include "conversions.h"
#include "depth_image.h"
#include "source.h"

static MLHandle camera;
static struct radial_factors radial;

static MLDepthCameraFrameType type_of(const ml2s_settings *settings) {
    return settings->second_streams ? MLDepthCameraFrameType_ShortRange : MLDepthCameraFrameType_LongRange;
}

static bool is_infra(const ml2s_settings *settings) { return settings->streams == ML2S_STREAM_BIT(ML2S_STREAM_INFRA); }

/** Rates in Hz, indexed by MLDepthCameraFrameRate. */
static const uint32_t rates[] = {1, 5, 25, 30, 50, 60};
enum { RATES = sizeof rates / sizeof *rates };

static ml2s_result rate_of(uint32_t rate_hz, MLDepthCameraFrameRate *vendor, ml2s_error *error) {
    for (*vendor = 0; *vendor < RATES; (*vendor)++) {
        if (rates[*vendor] == rate_hz) {
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_INVALID_ARGUMENT, 0, "depth: %u Hz, expected 1, 5, 25, 30, 50 or 60", rate_hz);
}

static ml2s_result translate(const ml2s_settings *settings, MLDepthCameraSettings *vendor, ml2s_error *error) {
    if (settings->streams & (settings->streams - 1)) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "depth: expected depth or infra, found both");
    }
    MLDepthCameraSettingsInit(vendor);
    vendor->streams = 1u << type_of(settings);
    MLDepthCameraStreamConfig *config = &vendor->stream_configs[type_of(settings)];
    if (is_infra(settings)) {
        config->flags = MLDepthCameraFlags_RawDepthImage;
    } else {
        // Always request the flags: they mark invalid depths.
        config->flags = MLDepthCameraFlags_DepthImage | MLDepthCameraFlags_DepthFlags;
        config->flags |= settings->wants & ML2S_WANT_CONFIDENCE ? MLDepthCameraFlags_Confidence : 0;
    }
    return rate_of(settings->rate_hz, &config->frame_rate, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    MLDepthCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    if (result || (result = perception_start(error))) {
        return result;
    }
    return SDK_CALL(error, depth, MLDepthCameraConnect, &vendor, &camera);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return SDK_CALL(error, depth, MLDepthCameraDisconnect, camera);
}

static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    MLDepthCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    return result ? result : SDK_CALL(error, depth, MLDepthCameraUpdateSettings, camera, &vendor);
}

static ml2s_result list_rates(const ml2s_settings *settings, uint32_t *rates_hz, uint32_t capacity, uint32_t *count,
                              ml2s_error *error) {
    MLDepthCameraCapabilityFilter filter;
    MLDepthCameraCapabilityFilterInit(&filter);
    filter.streams = 1u << type_of(settings);
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

/** Checks a buffer of frame. Its size must be that of the intrinsics. */
static ml2s_result view(const MLDepthCameraFrame *frame, const MLDepthCameraFrameBuffer *buffer, const char *name,
                        struct picture *out, ml2s_error *error) {
    static const MLDepthCameraFrameBuffer none;
    buffer = buffer ? buffer : &none;
    *out = (struct picture){buffer->data,   buffer->width,          buffer->height,
                            buffer->stride, buffer->bytes_per_unit, buffer->size};
    ml2s_result result = picture_check(out, 4, name, error);
    if (!result && (out->width != frame->intrinsics.width || out->height != frame->intrinsics.height ||
                    out->width > DEPTH_MAX_WIDTH || out->height > DEPTH_MAX_HEIGHT)) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels, intrinsics for %ux%u, at most %dx%d", name,
                         out->width, out->height, frame->intrinsics.width, frame->intrinsics.height, DEPTH_MAX_WIDTH,
                         DEPTH_MAX_HEIGHT);
    }
    return result;
}

static ml2s_result describe(const MLDepthCameraFrame *from, uint32_t stream, ml2s_frame *frame, ml2s_error *error) {
    frame_begin(frame, stream, from->intrinsics.width, from->intrinsics.height);
    frame->frame_number = from->frame_number;
    frame->lens = ML2S_LENS_PLUMB_BOB;
    memcpy(frame->distortion, from->intrinsics.distortion, sizeof from->intrinsics.distortion);
    frame_set_pinhole(frame, from->intrinsics.focal_length, from->intrinsics.principal_point);
    frame_set_pose(frame, &from->camera_pose);
    return frame_set_time(frame, from->frame_timestamp, error);
}

static ml2s_result copy_infra(const MLDepthCameraFrame *from, ml2s_frame *frame, ml2s_error *error) {
    struct picture raw;
    ml2s_result result = view(from, from->raw_depth_image, "infra", &raw, error);
    if (result || (result = describe(from, ML2S_STREAM_INFRA, frame, error))) {
        return result;
    }
    frame->illumination = 1;
    frame->has |= ML2S_HAS_ILLUMINATION;
    frame_copy_image(frame, &raw);
    return ML2S_OK;
}

static ml2s_result copy_depth(const MLDepthCameraFrame *from, uint32_t wants, ml2s_frame *frame, ml2s_error *error) {
    struct picture distances, confidence, flags;
    ml2s_result result = view(from, from->depth_image, "depth", &distances, error);
    if (result || (result = view(from, from->flags, "depth flags", &flags, error)) ||
        (wants & ML2S_WANT_CONFIDENCE &&
         (result = view(from, from->confidence, "depth confidence", &confidence, error))) ||
        (result = describe(from, ML2S_STREAM_DEPTH, frame, error))) {
        return result;
    }
    if (!(wants & ML2S_WANT_RADIAL) && !(frame->has & ML2S_HAS_INTRINSICS)) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0,
                         "depth: intrinsics are not finite, so z is unknown; the option radial works without");
    }
    frame_add_plane(frame, ML2S_PLANE_IMAGE, &distances);
    if (wants & ML2S_WANT_CONFIDENCE) {
        frame_add_plane(frame, ML2S_PLANE_CONFIDENCE, &confidence);
    }
    if (wants & ML2S_WANT_FLAGS) {
        frame_add_plane(frame, ML2S_PLANE_FLAGS, &flags);
    }
    frame_take_slot(frame, 0);
    depth_copy(frame, &distances, &flags, MLDepthCameraDepthFlags_Invalid,
               wants & ML2S_WANT_RADIAL ? NULL : radial_factors_of(&radial, frame));
    if (wants & ML2S_WANT_CONFIDENCE) {
        frame_copy(frame, ML2S_PLANE_CONFIDENCE, &confidence);
    }
    if (wants & ML2S_WANT_FLAGS) {
        frame_copy(frame, ML2S_PLANE_FLAGS, &flags);
    }
    return ML2S_OK;
}

static ml2s_result copy_frame(const ml2s_settings *settings, const void *depth_frame, ml2s_frame *frame,
                              ml2s_error *error) {
    const MLDepthCameraFrame *from = depth_frame;
    ml2s_result result =
        frameset_check_size(frame->stream, from->intrinsics.width, from->intrinsics.height, "depth", error);
    return result               ? result
           : is_infra(settings) ? copy_infra(from, frame, error)
                                : copy_depth(from, settings->wants, frame, error);
}

static ml2s_result find_stream(const ml2s_settings *settings, const void *depth_frame, uint32_t *stream,
                               ml2s_error *error) {
    const MLDepthCameraFrame *from = depth_frame;
    if (from->frame_type >= MLDepthCameraFrameType_Count) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "depth: unexpected frame of type %u", from->frame_type);
    }
    if (from->frame_type == type_of(settings)) {
        *stream = is_infra(settings) ? ML2S_STREAM_INFRA : ML2S_STREAM_DEPTH;
    }
    return ML2S_OK;
}

static struct camera depth = {
    "depth", "MLDepthCameraFrame", MLDepthCameraFrameType_Count, sizeof(MLDepthCameraFrame), find_stream, copy_frame,
    false};

static ml2s_result poll(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set,
                        ml2s_error *error) {
    WITH_ROOM(MLDepthCameraData) data;
    dump_begin(data.room);
    MLDepthCameraDataInit(&data.of);
    ml2s_result result =
        SDK_CALL(error, depth, MLDepthCameraGetLatestDepthData, camera, millis_of(timeout_nanos), &data.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLDepthCameraData", data);
    frameset_copy(set, &depth, settings, data.of.frames, data.of.frame_count, error);
    return SDK_CALL(error, depth, MLDepthCameraReleaseDepthData, camera, &data.of);
}

const struct source_ops source_depth = {.areas = PERCEPTION_AREAS | 1u << SDK_DEPTH,
                                        .open = begin,
                                        .configure = configure,
                                        .poll = poll,
                                        .list_rates = list_rates,
                                        .close = end};
