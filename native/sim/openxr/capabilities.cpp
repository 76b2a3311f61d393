#include "capabilities.h"

#include <algorithm>

#include "entry_points.h"
#include "pixel_sensor.h"

namespace ml2sim::xr {
namespace {

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

template <class Value, class Read> std::vector<Value> distinct(const std::vector<Mode> &modes, Read read) {
    std::vector<Value> values;
    for (const auto &mode : modes) {
        const Value value = read(mode);
        if (std::none_of(values.begin(), values.end(), [&](const Value &other) { return other == value; }))
            values.push_back(value);
    }
    return values;
}

template <class Range, class Value>
XrResult fill(Range *range, XrStructureType type, const std::vector<Value> &values) {
    auto &out = requireType(range, type, "range");
    out.valid = !values.empty();
    return enumerate(values, out.capacityInput, &out.countOutput, out.values);
}

} // namespace

std::vector<Mode> modesWith(const StreamModel &stream, uint32_t index, uint32_t configCount,
                            const XrPixelSensorConfigBaseHeaderML *const *configs) {
    std::vector<Mode> modes;
    for (const auto &mode : stream.modes)
        if (std::all_of(configs, configs + configCount,
                        [&](auto *config) { return config->stream != index || agrees(mode, config); }))
            modes.push_back(mode);
    return modes;
}

XrResult xrEnumeratePixelSensorCapabilitiesML(XrPixelSensorML sensor, uint32_t stream, uint32_t capacity,
                                              uint32_t *count, XrPixelSensorCapabilityML *capabilities) {
    return entry([&](auto &) {
        auto &self = find<PixelSensor>(sensor, "pixel sensor");
        self.stream(stream);
        std::vector<XrPixelSensorCapabilityML> offered;
        const auto offer = [&](XrPixelSensorCapabilityTypeML type, XrPixelSensorDataTypeML data) {
            offered.push_back(
                {XR_TYPE_PIXEL_SENSOR_CAPABILITY_ML, nullptr, type, data, XR_PIXEL_SENSOR_RANGE_DISCRETE_ML});
        };
        offer(XR_PIXEL_SENSOR_UPDATE_RATE_ML, XR_PIXEL_SENSOR_UINT32_ML);
        offer(XR_PIXEL_SENSOR_RESOLUTION_ML, XR_PIXEL_SENSOR_EXTENT_2DI_ML);
        offer(XR_PIXEL_SENSOR_FORMAT_ML, XR_PIXEL_SENSOR_UINT32_ML);
        if (self.model->streams[stream].hasMixedReality)
            offer(XR_PIXEL_SENSOR_MIXED_REALITY_ML, XR_PIXEL_SENSOR_UINT32_ML);
        for (uint32_t i = 0; i < capacity; i++)
            requireType(&capabilities[i], XR_TYPE_PIXEL_SENSOR_CAPABILITY_ML, "XrPixelSensorCapability");
        return enumerate(offered, capacity, count, capabilities);
    });
}

XrResult xrQueryPixelSensorCapabilityRangeML(XrPixelSensorML sensor, const XrPixelSensorCapabilityQueryInfoML *info,
                                             uint32_t configCount,
                                             const XrPixelSensorConfigBaseHeaderML *const *configs,
                                             XrPixelSensorRangeBaseHeaderML *range) {
    return entry([&](auto &) {
        auto &self = find<PixelSensor>(sensor, "pixel sensor");
        const auto &query =
            requireType(info, XR_TYPE_PIXEL_SENSOR_CAPABILITY_QUERY_INFO_ML, "XrPixelSensorCapabilityQueryInfo");
        self.stream(query.stream);
        const auto modes = modesWith(self.model->streams[query.stream], query.stream, configCount, configs);
        if (query.capabilityType == XR_PIXEL_SENSOR_RESOLUTION_ML)
            return fill(reinterpret_cast<XrPixelSensorRangeDiscreteExtent2DiML *>(range),
                        XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_EXTENT_2DI_ML,
                        distinct<XrExtent2Di>(modes, [](const Mode &mode) { return mode.size; }));
        const auto type = query.capabilityType;
        return fill(reinterpret_cast<XrPixelSensorRangeDiscreteUint32ML *>(range),
                    XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_UINT32_ML,
                    distinct<uint32_t>(modes, [type](const Mode &mode) { return numberOf(mode, type); }));
    });
}

} // namespace ml2sim::xr
