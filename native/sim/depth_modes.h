// What the depth camera can be set to.
#pragma once

#include "ml_depth_camera.h"
#include "scene/render.h"

namespace ml2sim {

/** A row of the vendor's tables: one rate of one stream. */
struct DepthMode {
    MLDepthCameraFrameType type;
    MLDepthCameraFrameRate rate;
    uint32_t delivered_hz; ///< 60 is accepted and delivers 30.
    uint32_t mains_hz;     ///< Where lights run on another mains it is not to be had; 0: anywhere.
};
constexpr DepthMode kDepthModes[] = {
    {MLDepthCameraFrameType_LongRange, MLDepthCameraFrameRate_1FPS, 1, 0},
    {MLDepthCameraFrameType_LongRange, MLDepthCameraFrameRate_5FPS, 5, 0},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_5FPS, 5, 0},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_25FPS, 25, 50},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_30FPS, 30, 60},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_50FPS, 50, 50},
    {MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_60FPS, 30, 60},
};

/** By MLDepthCameraFrameType. */
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

/** What settings that were checked ask for. */
struct DepthChoice {
    MLDepthCameraFrameType type;
    uint32_t planes; ///< MLDepthCameraFlags
    uint32_t delivered_hz;
};

/** Whether a mode is to be had on the mains of the key. */
bool isOnMains(const DepthMode &mode);

/** Whether the device can do it; tells of the misuse when not, but for a rate that only the mains excludes. */
MLResult chooseDepth(const char *function, const MLDepthCameraSettings *settings, DepthChoice *out);

} // namespace ml2sim
