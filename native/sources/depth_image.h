/** Depth as the cameras give it, a distance along the ray of each pixel, made z along the optical axis. */
#pragma once

#include "../sdk/ml2s.h"
#include "frame.h"

enum { DEPTH_MAX_WIDTH = 544, DEPTH_MAX_HEIGHT = 480 };

/** z / distance per pixel, for the intrinsics of the last frame it was made for. One thread. */
struct radial_factors {
    uint32_t width;
    double intrinsics[9];
    float factors[DEPTH_MAX_WIDTH * DEPTH_MAX_HEIGHT];
};

/** Factors for the size and intrinsics (ML2S_LENS_PLUMB_BOB) of frame, at most DEPTH_MAX_*; made again when they
 * change. */
const float *radial_factors_of(struct radial_factors *radial, const ml2s_frame *frame);

/**
 * Copies distances (float32 metres) into the image plane of frame, each times its factor (null: as it is). NaN where
 * flags (uint32) has a bit of invalid_mask, or the distance is not finite and positive. Both pictures are checked ones
 * of the frame's size. Does nothing for a lost frame.
 */
void depth_copy(const ml2s_frame *frame, const struct picture *distances, const struct picture *flags,
                uint32_t invalid_mask, const float *factors);
