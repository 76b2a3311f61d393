#include "frame.h"

#include <string.h>

#include "../sdk/error.h"

enum { ALIGNMENT = 64 };

ml2s_result picture_check(const struct picture *picture, uint32_t bytes_per_pixel, const char *name,
                          ml2s_error *error) {
    uint64_t row = (uint64_t)picture->width * bytes_per_pixel;
    if (!picture->data || !picture->width || !picture->height) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: empty picture of %ux%u", name, picture->width,
                         picture->height);
    }
    if (picture->bytes_per_pixel != bytes_per_pixel) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %u bytes per pixel, expected %u", name,
                         picture->bytes_per_pixel, bytes_per_pixel);
    }
    if (((uintptr_t)picture->data | picture->stride_bytes) % bytes_per_pixel) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: pixels not aligned to %u", name, bytes_per_pixel);
    }
    if (picture->stride_bytes < row ||
        picture->size_bytes < (picture->height - 1) * (uint64_t)picture->stride_bytes + row) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %ux%u pixels with stride %u do not fit %lld bytes", name,
                         picture->width, picture->height, picture->stride_bytes, (long long)picture->size_bytes);
    }
    return ML2S_OK;
}

void frame_begin(ml2s_frame *frame, uint32_t stream, uint32_t width, uint32_t height) {
    uint32_t skipped = frame->skipped;
    memset(frame, 0, sizeof *frame);
    frame->stream = stream;
    frame->skipped = skipped;
    frame->slot = ML2S_NO_SLOT;
    frame->width = width;
    frame->height = height;
}

static uint32_t end_of(const ml2s_frame *frame) {
    uint32_t end = 0;
    for (uint32_t role = 0; role < ML2S_PLANE_COUNT; role++) {
        if (frame->planes[role].size_bytes) {
            end = frame->planes[role].offset_bytes + frame->planes[role].size_bytes;
        }
    }
    return end;
}

void frame_add_plane(ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture) {
    uint32_t stride = picture->width * picture->bytes_per_pixel;
    frame->planes[role] = (ml2s_plane){
        .offset_bytes = (end_of(frame) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT,
        .size_bytes = stride * picture->height,
        .stride_bytes = stride,
    };
}

void frame_take_slot(ml2s_frame *frame, uint32_t least_bytes) {
    ml2s_memory memory;
    uint32_t end = end_of(frame);
    if (ml2s_take(frame->stream, end < least_bytes ? least_bytes : end, &frame->slot, &memory)) {
        frame->slot = ML2S_NO_SLOT;
        memset(frame->planes, 0, sizeof frame->planes);
    } else {
        frame->data = memory.data;
    }
}

void frame_copy(const ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture) {
    const ml2s_plane *plane = &frame->planes[role];
    if (!frame->data) {
        return;
    }
    uint8_t *to = frame->data + plane->offset_bytes;
    const uint8_t *from = picture->data;
    if (picture->stride_bytes == plane->stride_bytes) {
        memcpy(to, from, plane->size_bytes);
        return;
    }
    for (uint32_t y = 0; y < picture->height; y++, to += plane->stride_bytes, from += picture->stride_bytes) {
        memcpy(to, from, plane->stride_bytes);
    }
}

void frame_copy_image(ml2s_frame *frame, const struct picture *picture) {
    frame_add_plane(frame, ML2S_PLANE_IMAGE, picture);
    frame_take_slot(frame, 0);
    frame_copy(frame, ML2S_PLANE_IMAGE, picture);
}

void frames_release(const ml2s_frame *frames, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (frames[i].slot != ML2S_NO_SLOT) {
            ml2s_release(frames[i].stream, frames[i].slot);
        }
    }
}
