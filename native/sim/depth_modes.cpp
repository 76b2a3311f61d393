#include "depth_modes.h"

#include "camera_connection.h"

namespace ml2sim {

bool isOnMains(const DepthMode &mode) {
    const double mains_hz = number(Key::Mains);
    return mains_hz == 0 || mode.mains_hz == 0 || mode.mains_hz == mains_hz;
}

MLResult chooseDepth(const char *function, const MLDepthCameraSettings *settings, DepthChoice *out) {
    constexpr uint32_t kAllPlanes = 0x1f;
    if (const auto result = checkStructure(function, settings, 2))
        return result;
    if (settings->streams != MLDepthCameraStream_LongRange && settings->streams != MLDepthCameraStream_ShortRange)
        return refuseArgument(function, "streams is not exactly one of LongRange, ShortRange");
    const MLDepthCameraFrameType type = settings->streams == MLDepthCameraStream_LongRange
                                            ? MLDepthCameraFrameType_LongRange
                                            : MLDepthCameraFrameType_ShortRange;
    const auto &config = settings->stream_configs[type];
    const auto &stream = kDepthStreams[type];
    if (config.flags == 0 || (config.flags & ~kAllPlanes) != 0)
        return refuseArgument(function, "flags are not some of MLDepthCameraFlags");
    if (config.exposure < stream.least_exposure_us || config.exposure > stream.most_exposure_us)
        return refuseArgument(function, "exposure is out of the stream's range");
    for (const auto &mode : kDepthModes) {
        if (mode.type != type || mode.rate != config.frame_rate)
            continue;
        if (!isOnMains(mode))
            return MLResult_InvalidParam;
        *out = {type, config.flags, mode.delivered_hz};
        return MLResult_Ok;
    }
    return refuseArgument(function, "frame_rate is none of the stream's");
}

} // namespace ml2sim
