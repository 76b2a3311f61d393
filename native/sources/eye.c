// The eye cameras: one handle for all four. The vendor gives no pose and no intrinsics.
#include "../sdk/dump.h"
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

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    MLEyeCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    if (result || (result = perception_start(error))) {
        return result;
    }
    return SDK_CALL(error, eye, MLEyeCameraConnect, &vendor, &cameras);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return SDK_CALL(error, eye, MLEyeCameraDisconnect, cameras);
}

static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    MLEyeCameraSettings vendor;
    ml2s_result result = translate(settings, &vendor, error);
    return result ? result : SDK_CALL(error, eye, MLEyeCameraUpdateSettings, cameras, &vendor);
}

static ml2s_result copy_frame(const ml2s_settings *, const void *eye_frame, ml2s_frame *frame, ml2s_error *error) {
    const MLEyeCameraFrame *from = eye_frame;
    const MLEyeCameraFrameBuffer *buffer = &from->frame_buffer;
    struct picture picture = {buffer->data,   buffer->width,           buffer->height,
                              buffer->stride, buffer->bytes_per_pixel, buffer->size};
    ml2s_result result = picture_check(&picture, 1, "eye camera", error);
    if (result || (result = frameset_check_size(frame->stream, buffer->width, buffer->height, "eye camera", error))) {
        return result;
    }
    if (buffer->pixel_stride != 1) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "eye camera: pixel stride %u, expected 1",
                         buffer->pixel_stride);
    }
    frame_begin(frame, frame->stream, buffer->width, buffer->height);
    frame->frame_number = from->frame_number;
    if (!(result = frame_set_time(frame, from->timestamp, error))) {
        frame_copy_image(frame, &picture);
    }
    return result;
}

static ml2s_result find_stream(const ml2s_settings *, const void *eye_frame, uint32_t *stream, ml2s_error *error) {
    const MLEyeCameraFrame *from = eye_frame;
    for (int i = 0; i < CAMERAS; i++) {
        if (known[i].id == from->camera_id) {
            *stream = known[i].stream;
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "eye camera: unknown camera %u", from->camera_id);
}

static struct camera eye = {"eye camera", "MLEyeCameraFrame", CAMERAS, sizeof(MLEyeCameraFrame),
                            find_stream,  copy_frame,         false};

static ml2s_result poll(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set,
                        ml2s_error *error) {
    WITH_ROOM(MLEyeCameraData) data;
    dump_begin(data.room);
    MLEyeCameraDataInit(&data.of);
    ml2s_result result =
        SDK_CALL(error, eye, MLEyeCameraGetLatestCameraData, cameras, millis_of(timeout_nanos), &data.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLEyeCameraData", data);
    frameset_copy(set, &eye, settings, data.of.frames, data.of.frame_count, error);
    return SDK_CALL(error, eye, MLEyeCameraReleaseCameraData, cameras, &data.of);
}

const struct source_ops source_eye = {
    .areas = PERCEPTION_AREAS | 1u << SDK_EYE, .open = begin, .configure = configure, .poll = poll, .close = end};
