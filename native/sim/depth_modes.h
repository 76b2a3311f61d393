// The settings that the depth camera supports.
#pragma once

#include "ml_depth_camera.h"
#include "scene/render.h"

namespace ml2sim {

/** A rate of a stream, as the vendor lists it. */
struct DepthMode {
    MLDepthCameraFrameType type;
    MLDepthCameraFrameRate rate;
    uint32_t delivered_hz; ///< Captures a second.
    uint32_t mains_hz;     ///< Mains frequency where the rate is available; 0: any.
};
constexpr DepthMode kDepthModes[] = {
    {MLDepthCameraFrameType_LongRange, MLDepthCameraFrameRate_1FPS, 1, 0},
    {MLDepthCameraFrameType_LongRange, MLDepthCameraFrameRate_5FPS, 5, 0},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_5FPS, 5, 0},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_25FPS, 25, 50},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_30FPS, 30, 60},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_50FPS, 50, 50},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_60FPS, 60, 60},
};

/** A stream, indexed by MLDepthCameraFrameType. */
struct DepthStream {
    MLDepthCameraStream bit;
    const char *name;
    uint32_t least_exposure_us;
    uint32_t most_exposure_us;
    DepthRange range;
};
constexpr DepthStream kDepthStreams[] = {
    {MLDepthCameraStream_LongRange, "depth_long", 250, 2000, kLongRange},
    {MLDepthCameraStream_ShortRange, "depth_short", 50, 375, kShortRange},
};

/** The content of checked settings. */
struct DepthChoice {
    MLDepthCameraFrameType type;
    uint32_t planes; ///< MLDepthCameraFlags
    uint32_t delivered_hz;
};

/** Returns true if the mode is available with the mains frequency of the key. */
bool isOnMains(const DepthMode &mode);

/** Checks settings. Unsupported ones are a misuse, except a rate that only the mains frequency excludes. */
MLResult chooseDepth(const char *function, const MLDepthCameraSettings *settings, DepthChoice *out);

} // namespace ml2sim
