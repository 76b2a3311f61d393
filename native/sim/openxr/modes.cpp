#include "modes.h"

#include <algorithm>

#include "runtime.h"

namespace ml2sim::xr {
namespace {

bool agrees(const Mode &mode, const XrPixelSensorConfigBaseHeaderML *config) {
    if (config->capabilityType == XR_PIXEL_SENSOR_RESOLUTION_ML)
        return mode.size == requireType(reinterpret_cast<const XrPixelSensorConfigExtent2DiML *>(config),
                                        XR_TYPE_PIXEL_SENSOR_CONFIG_EXTENT_2DI_ML, "config of the resolution")
                                .value;
    return numberOf(mode, config->capabilityType) ==
           requireType(reinterpret_cast<const XrPixelSensorConfigUint32ML *>(config),
                       XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, "config of a number")
               .value;
}

} // namespace

bool operator==(const XrExtent2Di &a, const XrExtent2Di &b) { return a.width == b.width && a.height == b.height; }

uint32_t numberOf(const Mode &mode, XrPixelSensorCapabilityTypeML type) {
    switch (type) {
    case XR_PIXEL_SENSOR_UPDATE_RATE_ML:
        return mode.rate_hz;
    case XR_PIXEL_SENSOR_FORMAT_ML:
        return mode.format;
    case XR_PIXEL_SENSOR_MIXED_REALITY_ML:
        return mode.reality;
    default:
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_FEATURE_UNSUPPORTED, "a capability that the stream has not");
    }
}

std::vector<Mode> modesWith(const StreamModel &stream, uint32_t index, uint32_t configCount,
                            const XrPixelSensorConfigBaseHeaderML *const *configs) {
    std::vector<Mode> modes;
    for (const auto &mode : stream.modes)
        if (std::all_of(configs, configs + configCount,
                        [&](auto *config) { return config->stream != index || agrees(mode, config); }))
            modes.push_back(mode);
    return modes;
}

} // namespace ml2sim::xr
