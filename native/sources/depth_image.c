#include "depth_image.h"

#include <string.h>

enum { UNDISTORT_STEPS = 20 };

/** Returns z / distance for the ray through the distorted normalised point (x0, y0). */
static float factor_of(double x0, double y0, const double distortion[5]) {
    double k1 = distortion[0], k2 = distortion[1], p1 = distortion[2], p2 = distortion[3], k3 = distortion[4];
    double x = x0, y = y0;
    for (int step = 0; step < UNDISTORT_STEPS; step++) {
        double r2 = x * x + y * y;
        double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
        double next_x = (x0 - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / radial;
        double next_y = (y0 - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / radial;
        double moved = __builtin_fabs(next_x - x) + __builtin_fabs(next_y - y);
        x = next_x;
        y = next_y;
        if (moved < 1e-9) {
            break;
        }
    }
    return (float)(1 / __builtin_sqrt(1 + x * x + y * y));
}

const float *radial_factors_of(struct radial_factors *radial, const ml2s_frame *frame) {
    double intrinsics[9];
    memcpy(intrinsics, frame->focal_length, sizeof frame->focal_length);
    memcpy(intrinsics + 2, frame->principal_point, sizeof frame->principal_point);
    memcpy(intrinsics + 4, frame->distortion, 5 * sizeof *intrinsics);
    // The height is not compared: the factors cover the greatest height.
    if (radial->width == frame->width && memcmp(radial->intrinsics, intrinsics, sizeof intrinsics) == 0) {
        return radial->factors;
    }
    radial->width = frame->width;
    memcpy(radial->intrinsics, intrinsics, sizeof intrinsics);
    for (uint32_t y = 0; y < DEPTH_MAX_HEIGHT; y++) {
        for (uint32_t x = 0; x < frame->width; x++) {
            radial->factors[y * frame->width + x] =
                factor_of((x - intrinsics[2]) / intrinsics[0], (y - intrinsics[3]) / intrinsics[1], intrinsics + 4);
        }
    }
    return radial->factors;
}

static void copy_row(float *to, const float *distances, const uint32_t *flags, uint32_t invalid_mask,
                     const float *factors, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        float distance = distances[x];
        int is_valid = !(flags[x] & invalid_mask) & (distance > 0) & (distance < __builtin_inff());
        to[x] = is_valid ? distance * (factors ? factors[x] : 1) : __builtin_nanf("");
    }
}

void depth_copy(const ml2s_frame *frame, const struct picture *distances, const struct picture *flags,
                uint32_t invalid_mask, const float *factors) {
    if (!frame->data) {
        return;
    }
    const ml2s_plane *plane = &frame->planes[ML2S_PLANE_IMAGE];
    for (uint32_t y = 0; y < frame->height; y++) {
        copy_row((float *)(frame->data + plane->offset_bytes + (size_t)y * plane->stride_bytes),
                 (const float *)((const uint8_t *)distances->data + (size_t)y * distances->stride_bytes),
                 (const uint32_t *)((const uint8_t *)flags->data + (size_t)y * flags->stride_bytes), invalid_mask,
                 factors ? factors + (size_t)y * frame->width : NULL, frame->width);
    }
}
