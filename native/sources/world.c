// The world cameras: one handle for all three, each at normal or low exposure.
#include "../sdk/dump.h"
#include "../sdk/error.h"
#include "../sdk/perception.h"
#include "conversions.h"
#include "frame.h"
#include "source.h"

enum { CAMERAS = 3, MODES = 2 };

static MLHandle cameras;

static const struct {
    MLWorldCameraIdentifier id;
    uint32_t stream;
} known[CAMERAS] = {
    {MLWorldCameraIdentifier_Left, ML2S_STREAM_WORLD_LEFT},
    {MLWorldCameraIdentifier_Right, ML2S_STREAM_WORLD_RIGHT},
    {MLWorldCameraIdentifier_Center, ML2S_STREAM_WORLD_CENTER},
};

/** Returns the mode of a stream. Frame types have the same values as modes. */
static uint32_t mode_of(const ml2s_settings *settings, uint32_t stream) {
    return settings->second_streams & ML2S_STREAM_BIT(stream) ? MLWorldCameraMode_LowExposure
                                                              : MLWorldCameraMode_NormalExposure;
}

static MLWorldCameraSettings translate(const ml2s_settings *settings) {
    MLWorldCameraSettings vendor;
    MLWorldCameraSettingsInit(&vendor);
    vendor.mode = vendor.cameras = 0;
    for (int i = 0; i < CAMERAS; i++) {
        if (settings->streams & ML2S_STREAM_BIT(known[i].stream)) {
            vendor.cameras |= known[i].id;
            vendor.mode |= mode_of(settings, known[i].stream);
        }
    }
    return vendor;
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    MLWorldCameraSettings vendor = translate(settings);
    ml2s_result result = perception_start(error);
    return result ? result : SDK_CALL(error, world, MLWorldCameraConnect, &vendor, &cameras);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return SDK_CALL(error, world, MLWorldCameraDisconnect, cameras);
}

static ml2s_result configure(const ml2s_settings *settings, ml2s_error *error) {
    MLWorldCameraSettings vendor = translate(settings);
    return SDK_CALL(error, world, MLWorldCameraUpdateSettings, cameras, &vendor);
}

static ml2s_result copy_frame(const ml2s_settings *, const void *world_frame, ml2s_frame *frame, ml2s_error *error) {
    const MLWorldCameraFrame *from = world_frame;
    const MLWorldCameraFrameBuffer *buffer = &from->frame_buffer;
    struct picture picture = {buffer->data,   buffer->width,           buffer->height,
                              buffer->stride, buffer->bytes_per_pixel, buffer->size};
    ml2s_result result = picture_check(&picture, 1, "world camera", error);
    if (result || (result = frameset_check_size(frame->stream, buffer->width, buffer->height, "world camera", error))) {
        return result;
    }
    frame_begin(frame, frame->stream, buffer->width, buffer->height);
    frame->frame_number = from->frame_number;
    frame->lens = ML2S_LENS_FISHEYE_TANGENTIAL;
    memcpy(frame->distortion, from->intrinsics.radial_distortion, sizeof from->intrinsics.radial_distortion);
    memcpy(frame->distortion + 4, from->intrinsics.tangential_distortion,
           sizeof from->intrinsics.tangential_distortion);
    frame_set_pinhole(frame, from->intrinsics.focal_length, from->intrinsics.principal_point);
    frame_set_pose(frame, &from->camera_pose);
    if (!(result = frame_set_time(frame, from->timestamp, error))) {
        frame_copy_image(frame, &picture);
    }
    return result;
}

static ml2s_result find_stream(const ml2s_settings *settings, const void *world_frame, uint32_t *stream,
                               ml2s_error *error) {
    const MLWorldCameraFrame *from = world_frame;
    for (int i = 0; i < CAMERAS; i++) {
        if (known[i].id == from->id && (from->frame_type == MLWorldCameraFrameType_LowExposure ||
                                        from->frame_type == MLWorldCameraFrameType_NormalExposure)) {
            bool is_wanted = from->frame_type == mode_of(settings, known[i].stream);
            *stream = is_wanted ? known[i].stream : ML2S_STREAM_COUNT;
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "world camera: unknown camera %u or frame type %u", from->id,
                     from->frame_type);
}

static struct camera world = {"world camera", "MLWorldCameraFrame", CAMERAS *MODES, sizeof(MLWorldCameraFrame),
                              find_stream,    copy_frame,           false};

static ml2s_result poll(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set,
                        ml2s_error *error) {
    WITH_ROOM(MLWorldCameraData) data;
    dump_begin(data.room);
    MLWorldCameraDataInit(&data.of);
    MLWorldCameraData *filled = &data.of; // The vendor fills what this points to, and refuses null.
    ml2s_result result =
        SDK_CALL(error, world, MLWorldCameraGetLatestWorldCameraData, cameras, millis_of(timeout_nanos), &filled);
    if (result || !filled) {
        return result;
    }
    DUMP_ONCE("MLWorldCameraData", data);
    frameset_copy(set, &world, settings, filled->frames, filled->frame_count, error);
    return SDK_CALL(error, world, MLWorldCameraReleaseCameraData, cameras, filled);
}

const struct source_ops source_world = {
    .areas = PERCEPTION_AREAS | 1u << SDK_WORLD, .open = begin, .configure = configure, .poll = poll, .close = end};
