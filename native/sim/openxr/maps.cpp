// The maps of the headset, and in which of them it is localized.
#include <algorithm>
#include <cstring>

#include "../clock.h"
#include "../head_path.h"
#include "../tracking.h"
#include "entry_points.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

constexpr char kRoom[] = "Simulated room";

Pose turned(double yaw_rad, Vec3 position) { return {Quaternion::about({0, 1, 0}, yaw_rad), position}; }

bool hasUuid(const Map &map, const XrUuidEXT &uuid) {
    return std::all_of(std::begin(uuid.data), std::end(uuid.data), [&](uint8_t byte) { return byte == map.digit; });
}

} // namespace

std::vector<Map> maps() {
    std::vector<Map> all = {{kRoom, 0x07, turned(0.7, {1.5, 0.2, -0.8})},
                            {"Second room", 0x28, turned(-2, {-1, 0.1, 1})},
                            {kRoom, 0xab, turned(1, {0, 0, 2})}};
    all.resize(static_cast<size_t>(runtime().keys.whole("map.count")));
    return all;
}

XrLocalizationMapML describe(const Map &map) {
    XrLocalizationMapML out{};
    out.type = XR_TYPE_LOCALIZATION_MAP_ML;
    std::strcpy(out.name, map.name);
    std::fill(std::begin(out.mapUuid.data), std::end(out.mapUuid.data), map.digit);
    out.mapType = XR_LOCALIZATION_MAP_TYPE_ON_DEVICE_ML;
    return out;
}

XrLocalizationMapStateML mapState(const Session &session) {
    if (session.map >= maps().size())
        return XR_LOCALIZATION_MAP_STATE_NOT_LOCALIZED_ML;
    return mlTimeNow() < session.mapReadyAt ? XR_LOCALIZATION_MAP_STATE_LOCALIZATION_PENDING_ML
                                            : static_cast<XrLocalizationMapStateML>(runtime().keys.whole("map.state"));
}

std::optional<Pose> mapOrigin(XrSession handle, XrTime time) {
    const auto &session = find<Session>(handle, "session");
    if (mapState(session) != XR_LOCALIZATION_MAP_STATE_LOCALIZED_ML)
        return {};
    Pose origin = maps()[session.map].origin;
    origin.position.x += static_cast<double>(runtime().keys.whole("map.moved_mm")) / 1000;
    origin.rotation = origin.rotation * aboutX(ml2sim::number(Key::AssumeMapAxes));
    const auto head = HeadPath::current()->at(time).head;
    return compose(reportedHead(time), compose(inverse(head), origin));
}

XrResult xrQueryLocalizationMapsML(XrSession session, const XrLocalizationMapQueryInfoBaseHeaderML *queryInfo,
                                   uint32_t capacity, uint32_t *count, XrLocalizationMapML *out) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        if (queryInfo != nullptr)
            misuse(ML2SIM_XR_MISUSE_TYPE, XR_ERROR_VALIDATION_FAILURE, "a filter of maps, of which there is none");
        refuseIf("fault.map.denied", XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML);
        std::vector<XrLocalizationMapML> described;
        for (const auto &map : maps())
            described.push_back(describe(map));
        for (uint32_t i = 0; i < std::min<size_t>(capacity, described.size()); i++)
            requireType(&out[i], XR_TYPE_LOCALIZATION_MAP_ML, "XrLocalizationMapML");
        return enumerate(described, capacity, count, out);
    });
}

XrResult xrRequestMapLocalizationML(XrSession session, const XrMapLocalizationRequestInfoML *requestInfo) {
    return entry([&](auto &) {
        auto &state = find<Session>(session, "session");
        const auto &info =
            requireType(requestInfo, XR_TYPE_MAP_LOCALIZATION_REQUEST_INFO_ML, "XrMapLocalizationRequestInfoML");
        refuseIf("fault.map.denied", XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML);
        const auto all = maps();
        const auto found =
            std::find_if(all.begin(), all.end(), [&](const Map &map) { return hasUuid(map, info.mapUuid); });
        if (found == all.end())
            return XR_ERROR_LOCALIZATION_MAP_UNAVAILABLE_ML;
        refuseIf("fault.map.fails", XR_ERROR_LOCALIZATION_MAP_FAIL_ML);
        const auto index = static_cast<size_t>(found - all.begin());
        if (index != state.map)
            postSpaceChange(session, XR_REFERENCE_SPACE_TYPE_LOCALIZATION_MAP_ML);
        state.map = index;
        state.mapReadyAt = mlTimeNow() + runtime().keys.whole("map.delay_ms") * 1000000;
        return XR_SUCCESS;
    });
}

} // namespace ml2sim::xr
