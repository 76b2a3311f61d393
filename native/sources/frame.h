/** Filling a frame: check the vendor's pictures, lay out the planes, take a slot, copy. */
#pragma once

#include "../sdk/ml2s.h"

/** A picture in the vendor's memory, as the vendor describes it. */
struct picture {
    const void *data;
    uint32_t width;
    uint32_t height;
    uint32_t stride_bytes;
    uint32_t bytes_per_pixel;
    uint64_t size_bytes;
};

/**
 * ML2S_VENDOR_FAILURE unless every pixel of picture lies in its memory, aligned, with bytes_per_pixel bytes each.
 * name is for the message.
 */
ml2s_result picture_check(const struct picture *picture, uint32_t bytes_per_pixel, const char *name, ml2s_error *error);

/** ML2S_VENDOR_FAILURE unless frames, an array of the vendor's, can have count elements, of which there are at most
 * most. */
ml2s_result array_check(const void *frames, uint32_t count, uint32_t most, const char *name, ml2s_error *error);

/** Empties frame, but for what was skipped before it: it is of stream, and has no slot. */
void frame_begin(ml2s_frame *frame, uint32_t stream, uint32_t width, uint32_t height);

/** Appends a plane for the pixels of picture, without padding, aligned to 64; in the order of the roles. */
void frame_add_plane(ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture);

/**
 * Takes a slot for the planes, of at least least_bytes if the library chooses its size. Without a free one the frame is
 * lost: it has neither slot, data nor planes. ML2S_INVALID_ARGUMENT when the slot provided is too small.
 */
ml2s_result frame_take_slot(ml2s_frame *frame, uint32_t least_bytes, ml2s_error *error);

/** Copies picture into the plane. Does nothing for a lost frame. */
void frame_copy(const ml2s_frame *frame, ml2s_plane_role role, const struct picture *picture);

/** All three for a frame whose only plane is its image. */
ml2s_result frame_copy_image(ml2s_frame *frame, const struct picture *picture, ml2s_error *error);

/** Releases the slots of frames that nobody will get. */
void frames_release(const ml2s_frame *frames, uint32_t count);
