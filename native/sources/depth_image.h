/** Conversion of the radial distance that the camera measures to z along the optical axis. */
#pragma once

#include "../sdk/ml2s.h"
#include "frame.h"

enum { DEPTH_MAX_WIDTH = 544, DEPTH_MAX_HEIGHT = 480 };

/** z / distance for each pixel, for the intrinsics of the last frame. Not thread-safe. */
struct radial_factors {
    uint32_t width;
    double intrinsics[9];
    float factors[DEPTH_MAX_WIDTH * DEPTH_MAX_HEIGHT];
};

/** Returns the factors for size and intrinsics of frame (ML2S_LENS_PLUMB_BOB). Computes them when these change. */
const float *radial_factors_of(struct radial_factors *radial, const ml2s_frame *frame);

/**
 * Copies distances (float32 metres), multiplied by factors unless these are null, into the image plane of frame. A
 * pixel is NaN if its flags (uint32) have a bit of invalid_mask, or its distance is not finite and positive. Both
 * pictures have been checked and have the size of the frame. Does nothing for a lost frame.
 */
void depth_copy(const ml2s_frame *frame, const struct picture *distances, const struct picture *flags,
                uint32_t invalid_mask, const float *factors);
