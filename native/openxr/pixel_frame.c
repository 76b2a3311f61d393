#include "pixel_frame.h"

#include <string.h>

#include "../sdk/error.h"
#include "../sdk/memory.h"
#include "../sources/depth_image.h"
#include "pixel_metadata.h"
#include "poses.h"

static struct radial_factors radial;

/** The memory into which the runtime writes a capture. */
struct target {
    uint32_t slot; /**< ML2S_NO_SLOT: memory is spare, or a frame has the slot. */
    ml2s_memory memory;
};

/** The pictures of one capture, by ml2s_plane_role. */
struct pictures {
    struct picture of[ML2S_PLANE_COUNT];
    bool is_wanted[ML2S_PLANE_COUNT];
};

/** Reads the one plane of a picture of the given type. A JPEG is one row of its bytes. */
static ml2s_result plane_of(const XrPixelSensorFrameML *from, XrPixelSensorFrameTypeML type,
                            const struct pixel_sensor *sensor, struct picture *picture, ml2s_error *error) {
    if (!from || !from->planes || from->planeCount != 1 || from->frameType != type) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %u planes of type %u, expected 1 of %u", sensor->mode.path,
                         from ? from->planeCount : 0, from ? from->frameType : 0, type);
    }
    const XrPixelSensorPlaneML *plane = from->planes;
    if (type == XR_PIXEL_SENSOR_JPEG_ML) {
        *picture = (struct picture){plane->buffer, plane->bufferSize, 1, plane->bufferSize, 1, plane->bufferSize};
        return picture_check(picture, 1, sensor->mode.path, error);
    }
    *picture = (struct picture){plane->buffer, plane->width,         plane->height,
                                plane->stride, plane->bytesPerPixel, plane->bufferSize};
    if (plane->width != sensor->mode.width || plane->height != sensor->mode.height) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels, configured for %ux%u", sensor->mode.path,
                         plane->width, plane->height, sensor->mode.width, sensor->mode.height);
    }
    return picture_check(picture, type == XR_PIXEL_SENSOR_GRAYSCALE_ML ? 1 : 4, sensor->mode.path, error);
}

static ml2s_result find_depth(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                              const struct pixel_metadata *metadata, struct pictures *pictures, ml2s_error *error) {
    ml2s_result result =
        plane_of(data->frame, XR_PIXEL_SENSOR_DEPTH32_ML, sensor, &pictures->of[ML2S_PLANE_IMAGE], error);
    if (result || (result = plane_of(metadata->flags.frame, XR_PIXEL_SENSOR_DEPTH_FLAGS_ML, sensor,
                                     &pictures->of[ML2S_PLANE_FLAGS], error))) {
        return result;
    }
    if (sensor->mode.width > DEPTH_MAX_WIDTH || sensor->mode.height > DEPTH_MAX_HEIGHT) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels, at most %dx%d", sensor->mode.path,
                         sensor->mode.width, sensor->mode.height, DEPTH_MAX_WIDTH, DEPTH_MAX_HEIGHT);
    }
    pictures->is_wanted[ML2S_PLANE_FLAGS] = sensor->wants & ML2S_WANT_FLAGS;
    pictures->is_wanted[ML2S_PLANE_CONFIDENCE] = sensor->wants & ML2S_WANT_CONFIDENCE;
    return sensor->wants & ML2S_WANT_CONFIDENCE
               ? plane_of(metadata->confidence.frame, XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML, sensor,
                          &pictures->of[ML2S_PLANE_CONFIDENCE], error)
               : ML2S_OK;
}

static ml2s_result find_pictures(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                                 const struct pixel_metadata *metadata, struct pictures *pictures, ml2s_error *error) {
    *pictures = (struct pictures){.is_wanted = {[ML2S_PLANE_IMAGE] = true}};
    return sensor->mode.format == XR_PIXEL_SENSOR_DEPTH32_ML
               ? find_depth(sensor, data, metadata, pictures, error)
               : plane_of(data->frame, sensor->mode.format, sensor, &pictures->of[ML2S_PLANE_IMAGE], error);
}

/** Describes the picture as a plane of memory, with padding after the last row. Returns false if it lies elsewhere. */
static bool locate_plane(const struct picture *picture, const ml2s_memory *memory, ml2s_plane *plane) {
    uint64_t offset = (uint64_t)((uintptr_t)picture->data - (uintptr_t)memory->data);
    uint64_t size = (uint64_t)picture->stride_bytes * picture->height;
    if (offset >= memory->size_bytes || size > memory->size_bytes - offset) {
        return false;
    }
    *plane = (ml2s_plane){
        .offset_bytes = (uint32_t)offset, .size_bytes = (uint32_t)size, .stride_bytes = picture->stride_bytes};
    return true;
}

/** Gives the frame the slot of target, if all pictures lie there. Returns false otherwise. */
static bool take_in_place(const struct pictures *pictures, struct target *target, ml2s_frame *frame) {
    bool are_inside = target->slot != ML2S_NO_SLOT;
    for (uint32_t role = 0; role < ML2S_PLANE_COUNT && are_inside; role++) {
        are_inside =
            !pictures->is_wanted[role] || locate_plane(&pictures->of[role], &target->memory, &frame->planes[role]);
    }
    if (are_inside) {
        frame->slot = target->slot;
        frame->data = target->memory.data;
        target->slot = ML2S_NO_SLOT;
    } else {
        memset(frame->planes, 0, sizeof frame->planes);
    }
    return are_inside;
}

static void copy(const struct pictures *pictures, uint32_t least_bytes, ml2s_frame *frame) {
    for (uint32_t role = 0; role < ML2S_PLANE_COUNT; role++) {
        if (pictures->is_wanted[role]) {
            frame_add_plane(frame, role, &pictures->of[role]);
        }
    }
    frame_take_slot(frame, least_bytes);
    for (uint32_t role = 0; role < ML2S_PLANE_COUNT; role++) {
        if (pictures->is_wanted[role]) {
            frame_copy(frame, role, &pictures->of[role]);
        }
    }
}

/** Sets the pose if the runtime knows one. */
static void read_pose(const struct pixel_sensor *sensor, ml2s_frame *frame) {
    XrPosef pose;
    bool is_tracked;
    if (!poses_locate(sensor->space, frame->device_nanos, &pose, &is_tracked, NULL) && is_tracked) {
        memcpy(frame->rotation, &pose.orientation, sizeof frame->rotation);
        memcpy(frame->position, &pose.position, sizeof frame->position);
        frame->has |= ML2S_HAS_POSE;
    }
}

/**
 * Fills frame from data. If all pictures lie in the slot of target, it becomes the frame's. Otherwise they are copied
 * into another slot; if none is free, the frame is lost. Depth is converted to z along the optical axis, or NaN, unless
 * the settings ask for the radial distance. Returns ML2S_VENDOR_FAILURE, and a frame without slot, if a picture does
 * not match the mode or its own description.
 */
static ml2s_result read_frame(struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                              const struct pixel_metadata *metadata, struct target *target, ml2s_frame *frame,
                              ml2s_error *error) {
    frame_begin(frame, sensor->stream, sensor->mode.width, sensor->mode.height);
    frame->frame_number = sensor->frame_count;
    frame->device_nanos = data->captureTime;
    pixel_metadata_read(metadata, sensor->metadata, frame);
    struct pictures pictures;
    ml2s_result result = poses_boottime_of(data->captureTime, &frame->capture_nanos, error);
    if (result || (result = find_pictures(sensor, data, metadata, &pictures, error))) {
        return result;
    }
    read_pose(sensor, frame);
    if (!take_in_place(&pictures, target, frame)) {
        sensor->is_copied |= target->slot != ML2S_NO_SLOT;
        copy(&pictures, sensor->buffer_bytes, frame);
    }
    if (sensor->mode.format == XR_PIXEL_SENSOR_JPEG_ML) {
        frame->planes[ML2S_PLANE_IMAGE].stride_bytes = 0;
    } else if (sensor->mode.format == XR_PIXEL_SENSOR_DEPTH32_ML) {
        depth_copy(frame, &pictures.of[ML2S_PLANE_IMAGE], &pictures.of[ML2S_PLANE_FLAGS],
                   XR_PIXEL_SENSOR_DEPTH_INVALID_ML,
                   sensor->wants & ML2S_WANT_RADIAL ? NULL : radial_factors_of(&radial, frame));
    }
    return result;
}

/** Returns memory for the runtime to write to: a slot, or else spare memory. */
static ml2s_result find_target(struct pixel_sensor *sensor, struct target *target, ml2s_error *error) {
    if (!sensor->is_copied && !ml2s_take(sensor->stream, sensor->buffer_bytes, &target->slot, &target->memory)) {
        return ML2S_OK;
    }
    if (!sensor->spare.data) {
        sensor->spare = memory_map(sensor->buffer_bytes);
    }
    *target = (struct target){ML2S_NO_SLOT, sensor->spare};
    return sensor->spare.data ? ML2S_OK
                              : error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: cannot map %u bytes of memory",
                                          sensor->mode.path, sensor->buffer_bytes);
}

/** Reads the next frame. */
static ml2s_result fetch(struct pixel_sensor *sensor, uint64_t timeout_nanos, struct target *target,
                         struct frameset *set, ml2s_error *error) {
    struct pixel_metadata metadata;
    XrPixelSensorDataGetInfoML info = {XR_TYPE_PIXEL_SENSOR_DATA_GET_INFO_ML, NULL, sensor->mode.device_stream,
                                       sensor->last_capture, (XrDuration)timeout_nanos};
    XrPixelSensorBufferML buffer = {XR_TYPE_PIXEL_SENSOR_BUFFER_ML, NULL, sensor->buffer_bytes, target->memory.data};
    XrPixelSensorDataML data = {.type = XR_TYPE_PIXEL_SENSOR_DATA_ML};
    pixel_metadata_chain(&metadata, sensor->metadata, &data);
    ml2s_result result = XR_CALL(error, pixel, xrGetPixelSensorDataML, sensor->sensor, &info, &buffer, &data);
    ml2s_frame *frame = result ? NULL : frameset_add(set, sensor->stream, error);
    if (!frame) {
        return result;
    }
    sensor->last_capture = data.captureTime;
    sensor->frame_count++;
    frameset_complete(set, frame, read_frame(sensor, &data, &metadata, target, frame, error));
    return ML2S_OK;
}

ml2s_result pixel_frame_get(struct pixel_sensor *sensor, uint64_t timeout_nanos, struct frameset *set,
                            ml2s_error *error) {
    struct target target;
    ml2s_result result = find_target(sensor, &target, error);
    if (!result) {
        result = fetch(sensor, timeout_nanos, &target, set, error);
        if (target.slot != ML2S_NO_SLOT) {
            ml2s_release(sensor->stream, target.slot);
        }
    }
    return result;
}
