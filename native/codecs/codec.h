/**
 * The interface of a codec, which encode.c calls after it has checked the image. A codec uses no memory but its stack,
 * and keeps nothing between calls: any number of threads may encode at a time.
 */
#pragma once

#include "../sdk/ml2s.h"

struct codec {
    const char *name;         /**< In messages. */
    uint32_t bytes_per_pixel; /**< Also the alignment of data and rows. */
    uint32_t least_quality;   /**< 0, as most_quality, if the codec has no quality. */
    uint32_t most_quality;    /**< See least_quality. */
    /** Returns the most bytes that an image of this size needs, whatever it shows. */
    uint64_t (*most_bytes)(uint32_t width, uint32_t height);
    /** Encodes the image and returns the end of its bytes. output has room for most_bytes. */
    uint8_t *(*encode)(const ml2s_image *image, uint8_t *output);
};

extern const struct codec grey_jpeg, depth_rvl;
