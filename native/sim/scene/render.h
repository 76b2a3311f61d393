/**
 * Renders the images of the simulated cameras. All functions are pure (equal arguments, equal pixels), need no state
 * but the caller's, and may run in several threads. Rows are `stride_bytes` apart; what lies between rows is left
 * alone.
 */
#pragma once

#include "cameras.h"
#include "scene.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ml2sim {

/** The unit ray of every pixel, in camera axes, row by row. Costs some 0.1 us per pixel: make it once per lens. */
struct RayTable {
    explicit RayTable(const FisheyeTangential &lens);
    explicit RayTable(const PlumbBob &lens);

    uint32_t width;
    uint32_t height;
    float radians_per_pixel; ///< At the centre.
    std::vector<float> x;
    std::vector<float> y;
    std::vector<float> z;
};

/** Gaussian noise, a pure function of seed, frame and pixel; sigma in grey levels, or metres for distance. 0 is none.
 */
struct Noise {
    float sigma = 0;
    uint64_t seed = 0;
    uint64_t frame = 0;
    float sigmaOfSquare = 0; ///< Added to sigma for each unit of the value's square.
    float shot = 0;          ///< Added to the square of sigma for each unit of the value; only without sigmaOfSquare.
};

/** Exposure and errors of a picture. */
struct Shot {
    float gain = 1;   ///< 1 is normal exposure. It amplifies the noise, too.
    Noise noise = {}; ///< Each channel of colour has noise of its own.
    Vec3 turn = {};   ///< By how much the camera turns while it is exposed: radians about camera axes.
};

/** One byte per pixel. `camera` is camera -> world at the centre of exposure and must be inside the room. */
void renderWorld(const Scene &scene, const RayTable &rays, const Pose &camera, uint8_t *grey, size_t stride_bytes,
                 const Shot &shot = {});

/** Three bytes per pixel, R G B. With `hologram`, as in mixed reality, a virtual object floats in the room. */
void renderColor(const Scene &scene, const RayTable &rays, const Pose &camera, bool hologram, uint8_t *rgb,
                 size_t stride_bytes, const Shot &shot = {});

/** One of the depth camera's two streams, as it is set. */
struct DepthRange {
    float near_m;      ///< Nearer, or bright beyond measure, is Saturated.
    float far_m;       ///< Farther is LowSignal.
    float exposure_us; ///< Counts are proportional to it.
};
constexpr DepthRange kLongRange = {0.5f, 7.5f, 1600};
/** Nominally to 0.9 m; like the device's it measures on as long as enough light comes back. */
constexpr DepthRange kShortRange = {0.2f, 3.0f, 375};

/** Bits of MLDepthCameraDepthFlags that are set here. */
enum DepthFlag : uint32_t {
    kDepthValid = 0,
    kDepthInvalid = 1u << 0, ///< Set whenever any other is.
    kDepthSaturated = 1u << 1,
    kDepthLowSignal = 1u << 3,
    kDepthFlyingPixel =
        1u << 4, ///< Beside an edge in depth; the distance is that through the pixel's centre all the same.
};

/** The buffers of a depth frame; null means not wanted. All are 4 bytes per pixel and have the same stride. */
struct DepthImages {
    float *distance_m = nullptr;  ///< Radial, exact through the pixel's centre; 0 when saturated or low signal.
    float *confidence = nullptr;  ///< Counts that came back; larger is better.
    uint32_t *flags = nullptr;    ///< DepthFlag
    float *raw = nullptr;         ///< Infrared, illuminator on, counts.
    float *ambient_raw = nullptr; ///< Infrared, illuminator off, counts.
    size_t stride_bytes = 0;
};

/** `noise` is for the distance only. */
void renderDepth(const Scene &scene, const RayTable &rays, const Pose &camera, DepthRange range,
                 const DepthImages &images, Noise noise = {});

/** MLEyeCameraIdentifier. */
enum class EyeCamera { LeftTemple = 1, LeftNasal = 2, RightNasal = 4, RightTemple = 8 };

/** One byte per pixel, kEyeWidth x kEyeHeight. The gaze goes round, and blinks once, in a `phase` from 0 to 1. */
void renderEye(EyeCamera camera, double phase, uint8_t *grey, size_t stride_bytes, Noise noise = {});

} // namespace ml2sim
