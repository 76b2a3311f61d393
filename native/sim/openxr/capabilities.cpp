// The capabilities of a stream, given the values selected so far.
#include <algorithm>

#include "entry_points.h"
#include "modes.h"
#include "pixel_sensor.h"

namespace ml2sim::xr {
namespace {

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
