#include "pixel_frame.h"

#include <string.h>

#include "../sdk/error.h"
#include "../sources/depth_image.h"
#include "poses.h"

static struct radial_factors radial;

/** The only plane of a picture of the given type, wholly within memory. */
static ml2s_result plane_of(const XrPixelSensorFrameML *picture, XrPixelSensorFrameTypeML type,
                            const ml2s_memory *memory, const struct pixel_sensor *sensor,
                            const XrPixelSensorPlaneML **plane, ml2s_error *error) {
    if (!picture || !picture->planes || picture->planeCount != 1 || picture->frameType != type) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %u planes of type %u, expected 1 of %u", sensor->mode.path,
                         picture ? picture->planeCount : 0, picture ? picture->frameType : 0, type);
    }
    *plane = picture->planes;
    uint64_t offset = (uint64_t)((uintptr_t)(*plane)->buffer - (uintptr_t)memory->data);
    if (offset >= memory->size_bytes || (*plane)->bufferSize > memory->size_bytes - offset) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: a picture outside the buffer given to it",
                         sensor->mode.path);
    }
    return ML2S_OK;
}

/** A picture of bytes_per_pixel, and where it lies in the frame. */
static ml2s_result raster_of(const XrPixelSensorFrameML *from, XrPixelSensorFrameTypeML type, uint32_t bytes_per_pixel,
                             const ml2s_memory *memory, const struct pixel_sensor *sensor, struct picture *picture,
                             ml2s_plane *out, ml2s_error *error) {
    const XrPixelSensorPlaneML *plane;
    ml2s_result result = plane_of(from, type, memory, sensor, &plane, error);
    if (result) {
        return result;
    }
    *picture = (struct picture){plane->buffer, plane->width,         plane->height,
                                plane->stride, plane->bytesPerPixel, plane->bufferSize};
    if (plane->width != sensor->mode.width || plane->height != sensor->mode.height) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels, configured for %ux%u", sensor->mode.path,
                         plane->width, plane->height, sensor->mode.width, sensor->mode.height);
    }
    *out = (ml2s_plane){.offset_bytes = (uint32_t)(plane->buffer - memory->data),
                        .size_bytes = plane->bufferSize,
                        .stride_bytes = plane->stride};
    return picture_check(picture, bytes_per_pixel, sensor->mode.path, error);
}

static ml2s_result read_depth(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                              const struct pixel_metadata *metadata, const ml2s_memory *memory, ml2s_frame *frame,
                              ml2s_error *error) {
    struct picture distances, flags, confidence;
    ml2s_plane flags_plane;
    ml2s_result result = raster_of(data->frame, XR_PIXEL_SENSOR_DEPTH32_ML, 4, memory, sensor, &distances,
                                   &frame->planes[ML2S_PLANE_IMAGE], error);
    if (result || (result = raster_of(metadata->flags.frame, XR_PIXEL_SENSOR_DEPTH_FLAGS_ML, 4, memory, sensor, &flags,
                                      &flags_plane, error))) {
        return result;
    }
    if (frame->width > DEPTH_MAX_WIDTH || frame->height > DEPTH_MAX_HEIGHT) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels, at most %dx%d", sensor->mode.path,
                         frame->width, frame->height, DEPTH_MAX_WIDTH, DEPTH_MAX_HEIGHT);
    }
    depth_copy(frame, &distances, &flags, XR_PIXEL_SENSOR_DEPTH_INVALID_ML,
               sensor->wants & ML2S_WANT_RADIAL ? NULL : radial_factors_of(&radial, frame));
    if (sensor->wants & ML2S_WANT_FLAGS) {
        frame->planes[ML2S_PLANE_FLAGS] = flags_plane;
    }
    return sensor->wants & ML2S_WANT_CONFIDENCE
               ? raster_of(metadata->confidence.frame, XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML, 4, memory, sensor,
                           &confidence, &frame->planes[ML2S_PLANE_CONFIDENCE], error)
               : ML2S_OK;
}

static ml2s_result read_picture(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                                const struct pixel_metadata *metadata, const ml2s_memory *memory, ml2s_frame *frame,
                                ml2s_error *error) {
    struct picture picture;
    const XrPixelSensorPlaneML *jpeg;
    ml2s_plane *plane = &frame->planes[ML2S_PLANE_IMAGE];
    switch (sensor->mode.format) {
    case XR_PIXEL_SENSOR_DEPTH32_ML:
        return read_depth(sensor, data, metadata, memory, frame, error);
    case XR_PIXEL_SENSOR_JPEG_ML: {
        ml2s_result result = plane_of(data->frame, XR_PIXEL_SENSOR_JPEG_ML, memory, sensor, &jpeg, error);
        if (!result) {
            *plane =
                (ml2s_plane){.offset_bytes = (uint32_t)(jpeg->buffer - memory->data), .size_bytes = jpeg->bufferSize};
        }
        return result;
    }
    case XR_PIXEL_SENSOR_DEPTH_RAW_ML:
        return raster_of(data->frame, XR_PIXEL_SENSOR_DEPTH_RAW_ML, 4, memory, sensor, &picture, plane, error);
    default:
        return raster_of(data->frame, XR_PIXEL_SENSOR_GRAYSCALE_ML, 1, memory, sensor, &picture, plane, error);
    }
}

static ml2s_result read_pose(const struct pixel_sensor *sensor, ml2s_frame *frame, ml2s_error *error) {
    XrPosef pose;
    bool is_tracked;
    ml2s_result result = poses_locate(sensor->space, frame->device_nanos, &pose, &is_tracked, error);
    if (!result && is_tracked) {
        memcpy(frame->rotation, &pose.orientation, sizeof frame->rotation);
        memcpy(frame->position, &pose.position, sizeof frame->position);
        frame->has |= ML2S_HAS_POSE;
    }
    return result;
}

ml2s_result pixel_frame_read(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                             const struct pixel_metadata *metadata, const ml2s_memory *memory, ml2s_frame *frame,
                             ml2s_error *error) {
    frame_begin(frame, sensor->stream, sensor->mode.width, sensor->mode.height);
    frame->data = memory->data;
    frame->frame_number = sensor->frame_count;
    frame->device_nanos = data->captureTime;
    pixel_metadata_read(metadata, sensor->metadata, frame);
    ml2s_result result = poses_boottime_of(data->captureTime, &frame->capture_nanos, error);
    if (result || (result = read_pose(sensor, frame, error))) {
        return result;
    }
    return read_picture(sensor, data, metadata, memory, frame, error);
}

void pixel_frame_lose(ml2s_frame *frame) {
    frame->data = NULL;
    memset(frame->planes, 0, sizeof frame->planes);
}
