/** Fills a frame: checks the vendor's pictures, lays out the planes, takes a slot and copies. */
#pragma once

#include "../sdk/ml2s.h"

/** A picture in the vendor's memory, with the vendor's description. */
struct picture {
    const void *data;
    uint32_t width;
    uint32_t height;
    uint32_t stride_bytes;
    uint32_t bytes_per_pixel;
    uint64_t size_bytes;
};

/**
 * Returns ML2S_VENDOR_FAILURE unless all pixels lie in the memory of picture, are aligned and have bytes_per_pixel
 * bytes. name begins the error message.
 */
ml2s_result picture_check(const struct picture *picture, uint32_t bytes_per_pixel, const char *name, ml2s_error *error);

/** Resets frame to one of stream without a slot. Keeps its count of skipped frames. */
void frame_begin(ml2s_frame *frame, uint32_t stream, uint32_t width, uint32_t height);

/** Appends a plane for picture, without row padding, aligned to 64 bytes. Call it in the order of the roles. */
void frame_add_plane(ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture);

/** Takes a slot for the planes, of at least least_bytes. If none is free, the frame is lost: without slot and planes.
 */
void frame_take_slot(ml2s_frame *frame, uint32_t least_bytes);

/** Copies picture into the plane. Does nothing for a lost frame. */
void frame_copy(const ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture);

/** Adds the image plane, takes a slot and copies, for a frame with no other plane. */
void frame_copy_image(ml2s_frame *frame, const struct picture *picture);

/** Releases the slots of frames that are not delivered. */
void frames_release(const ml2s_frame *frames, uint32_t count);
