// The eye cameras: one handle for all four. The vendor gives no pose and no intrinsics.
#include "../sdk/error.h"
#include "../sdk/perception.h"
#include "conversions.h"
#include "frame.h"
#include "source.h"

enum { CAMERAS = 4 };

static MLHandle cameras;

static const struct {
    MLEyeCameraIdentifier id;
    uint32_t stream;
} known[CAMERAS] = {
    {MLEyeCameraIdentifier_LeftTemple, ML2S_STREAM_EYE_TEMPLE_LEFT},
    {MLEyeCameraIdentifier_LeftNasal, ML2S_STREAM_EYE_NASAL_LEFT},
    {MLEyeCameraIdentifier_RightNasal, ML2S_STREAM_EYE_NASAL_RIGHT},
    {MLEyeCameraIdentifier_RightTemple, ML2S_STREAM_EYE_TEMPLE_RIGHT},
};

static ml2s_result translate(const ml2s_settings *settings, MLEyeCameraSettings *vendor, ml2s_error *error) {
    if (settings->second_streams) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "eye camera: expected stream 0, found stream 1");
    }
    MLEyeCameraSettingsInit(vendor);
    vendor->cameras = 0;
    for (int i = 0; i < CAMERAS; i++) {
        vendor->cameras |= settings->streams & ML2S_STREAM_BIT(known[i].stream) ? known[i].id : 0;
    }
    return ML2S_OK;
}

static ml2s_result require(ml2s_error *error) {
    return sdk_require(1u << SDK_EYE | 1u << SDK_PERCEPTION | 1u << SDK_TIME, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    MLEyeCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    if (result || (result = perception_start(error))) {
        return result;
    }
    return SDK_CALL(error, eye, MLEyeCameraConnect, &vendor, &cameras);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    return SDK_CALL(error, eye, MLEyeCameraDisconnect, cameras);
}

static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    MLEyeCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    return result ? result : SDK_CALL(error, eye, MLEyeCameraUpdateSettings, cameras, &vendor);
}

static ml2s_result copy_frame(const MLEyeCameraFrame *from, uint32_t stream, ml2s_frame *frame, ml2s_error *error) {
    const MLEyeCameraFrameBuffer *buffer = &from->frame_buffer;
    struct picture picture = {buffer->data,   buffer->width,           buffer->height,
                              buffer->stride, buffer->bytes_per_pixel, buffer->size};
    ml2s_result result = picture_check(&picture, 1, "eye camera", error);
    if (result || (result = frameset_check_size(stream, buffer->width, buffer->height, "eye camera", error))) {
        return result;
    }
    if (buffer->pixel_stride != 1) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "eye camera: pixel stride %u, expected 1",
                         buffer->pixel_stride);
    }
    frame_begin(frame, stream, buffer->width, buffer->height);
    frame->frame_number = from->frame_number;
    if (!(result = frame_set_time(frame, from->timestamp, error))) {
        frame_copy_image(frame, &picture);
    }
    return result;
}

static ml2s_result find_stream(MLEyeCameraIdentifier id, uint32_t *stream, ml2s_error *error) {
    for (int i = 0; i < CAMERAS; i++) {
        if (known[i].id == id) {
            *stream = known[i].stream;
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "eye camera: unknown camera %u", id);
}

/** Ignores frames of other cameras, which can follow a change of settings. */
static void copy(const MLEyeCameraData *data, struct frameset *set, ml2s_error *error) {
    if (array_check(data->frames, data->frame_count, CAMERAS, "eye camera", error)) {
        frameset_skip_all(set);
        return;
    }
    for (uint32_t i = 0; i < data->frame_count; i++) {
        uint32_t stream = 0;
        if (find_stream(data->frames[i].camera_id, &stream, error)) {
            frameset_skip_unknown(set);
        } else if (set->streams & ML2S_STREAM_BIT(stream)) {
            ml2s_frame *to = frameset_add(set, stream, error);
            if (to) {
                frameset_complete(set, to, copy_frame(&data->frames[i], stream, to, error));
            }
        }
    }
}

static ml2s_result poll(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set,
                        ml2s_error *error) {
    (void)settings;
    MLEyeCameraData data;
    MLEyeCameraDataInit(&data);
    ml2s_result result = SDK_CALL(error, eye, MLEyeCameraGetLatestCameraData, cameras, millis_of(timeout_nanos), &data);
    if (result) {
        return result;
    }
    copy(&data, set, error);
    return SDK_CALL(error, eye, MLEyeCameraReleaseCameraData, cameras, &data);
}

const struct source_ops source_eye = {
    .require = require, .open = begin, .configure = configure, .poll = poll, .close = end};
