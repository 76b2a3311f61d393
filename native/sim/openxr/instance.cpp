// The instance: extensions, system, paths and events.
#include <algorithm>
#include <cstdio>
#include <cstring>

#include <openxr/openxr_reflection.h>

#include "../clock.h"
#include "entry_points.h"
#include "runtime.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

constexpr XrSystemId kSystem = 2;

/** Extensions, and what each needs. */
constexpr std::pair<const char *, const char *> kDependencies[] = {
    {XR_ML_PIXEL_SENSOR_EXTENSION_NAME, XR_EXT_FUTURE_EXTENSION_NAME},
    {XR_ML_LOCALIZATION_MAP_EXTENSION_NAME, XR_EXT_UUID_EXTENSION_NAME},
};

std::vector<std::string> offeredExtensions() {
    std::vector<std::string> offered;
    for (const char *extension : kExtensions)
        if (runtime().keys.text("fault.extension.missing") != extension)
            offered.emplace_back(extension);
    return offered;
}

void enable(const XrInstanceCreateInfo &info) {
    std::set<std::string> enabled;
    const auto offered = offeredExtensions();
    for (uint32_t i = 0; i < info.enabledExtensionCount; i++) {
        if (std::find(offered.begin(), offered.end(), info.enabledExtensionNames[i]) == offered.end())
            throw Refusal{XR_ERROR_EXTENSION_NOT_PRESENT};
        enabled.insert(info.enabledExtensionNames[i]);
    }
    for (const auto &[extension, needed] : kDependencies)
        if (enabled.count(extension) != 0 && enabled.count(needed) == 0)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, std::string(extension) + " needs " + needed);
    runtime().extensions = enabled;
}

bool hasInstance() {
    for (const auto &[handle, object] : runtime().objects)
        if (dynamic_cast<const Instance *>(object.get()) != nullptr)
            return true;
    return false;
}

void checkSystem(XrSystemId system) {
    if (system != kSystem)
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_SYSTEM_INVALID, "no such system");
}

// clang-format off
#define ROW(name, ...) {name, #name},
constexpr std::pair<XrResult, const char *> kNames[] = {
    XR_LIST_ENUM_XrResult(ROW)
    // Lists of older headers lack these.
    ROW(XR_ERROR_FUTURE_PENDING_EXT) ROW(XR_ERROR_FUTURE_INVALID_EXT) ROW(XR_ERROR_PERMISSION_INSUFFICIENT)
    ROW(XR_ERROR_MARKER_DETECTOR_PERMISSION_DENIED_ML) ROW(XR_ERROR_MARKER_DETECTOR_LOCATE_FAILED_ML)
    ROW(XR_ERROR_MARKER_DETECTOR_INVALID_DATA_QUERY_ML) ROW(XR_ERROR_MARKER_DETECTOR_INVALID_CREATE_INFO_ML)
    ROW(XR_ERROR_MARKER_INVALID_ML) ROW(XR_ERROR_LOCALIZATION_MAP_UNAVAILABLE_ML)
    ROW(XR_ERROR_LOCALIZATION_MAP_FAIL_ML) ROW(XR_ERROR_LOCALIZATION_MAP_IMPORT_EXPORT_PERMISSION_DENIED_ML)
    ROW(XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML)
};
#undef ROW
// clang-format on

} // namespace

XrResult xrEnumerateInstanceExtensionProperties(const char *layer, uint32_t capacity, uint32_t *count,
                                                XrExtensionProperties *properties) {
    return entry([&](auto &) {
        if (layer != nullptr && *layer != '\0')
            return XR_ERROR_API_LAYER_NOT_PRESENT;
        const auto offered = offeredExtensions();
        requireNonNull(count, "count") = static_cast<uint32_t>(offered.size());
        if (capacity == 0)
            return XR_SUCCESS;
        if (capacity < offered.size())
            return XR_ERROR_SIZE_INSUFFICIENT;
        for (size_t i = 0; i < offered.size(); i++) {
            auto &out = requireType(&properties[i], XR_TYPE_EXTENSION_PROPERTIES, "XrExtensionProperties");
            std::strcpy(out.extensionName, offered[i].c_str());
            out.extensionVersion = 1;
        }
        return XR_SUCCESS;
    });
}

XrResult xrCreateInstance(const XrInstanceCreateInfo *createInfo, XrInstance *instance) {
    return entry([&](auto &) {
        const auto &info = requireType(createInfo, XR_TYPE_INSTANCE_CREATE_INFO, "XrInstanceCreateInfo");
        refuseIf("fault.instance.fails", XR_ERROR_RUNTIME_FAILURE);
        if (hasInstance())
            return XR_ERROR_LIMIT_REACHED;
        enable(info);
        runtime().events.clear();
        ++runtime().counters.instances_created;
        requireNonNull(instance, "instance") = registerObject<XrInstance>(0, std::make_unique<Instance>());
        return XR_SUCCESS;
    });
}

XrResult xrDestroyInstance(XrInstance instance) { return destroyHandle<Instance>(instance, "instance"); }

XrResult xrPollEvent(XrInstance instance, XrEventDataBuffer *event) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        requireType(event, XR_TYPE_EVENT_DATA_BUFFER, "XrEventDataBuffer");
        applySessionFaults();
        auto &events = runtime().events;
        if (events.empty())
            return XR_EVENT_UNAVAILABLE;
        *event = events.front();
        events.pop_front();
        return XR_SUCCESS;
    });
}

XrResult xrResultToString(XrInstance instance, XrResult value, char buffer[XR_MAX_RESULT_STRING_SIZE]) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto name =
            std::find_if(std::begin(kNames), std::end(kNames), [&](auto &it) { return it.first == value; });
        if (name != std::end(kNames))
            std::strcpy(buffer, name->second);
        else
            std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "XR_UNKNOWN_%s_%d", value < 0 ? "FAILURE" : "SUCCESS",
                          value);
    });
}

XrResult xrStringToPath(XrInstance instance, const char *text, XrPath *path) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        if (*text != '/')
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_PATH_FORMAT_INVALID, std::string("no path: ") + text);
        requireNonNull(path, "path") = pathOf(text);
    });
}

XrResult xrPathToString(XrInstance instance, XrPath path, uint32_t capacity, uint32_t *count, char *buffer) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &text = textOf(path);
        return enumerate(std::vector<char>(text.c_str(), text.c_str() + text.size() + 1), capacity, count, buffer);
    });
}

XrResult xrGetSystem(XrInstance instance, const XrSystemGetInfo *info, XrSystemId *system) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        if (requireType(info, XR_TYPE_SYSTEM_GET_INFO, "XrSystemGetInfo").formFactor !=
            XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY)
            return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
        requireNonNull(system, "system") = kSystem;
        return XR_SUCCESS;
    });
}

XrResult xrGetSystemProperties(XrInstance instance, XrSystemId system, XrSystemProperties *properties) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        checkSystem(system);
        auto &out = requireType(properties, XR_TYPE_SYSTEM_PROPERTIES, "XrSystemProperties");
        out.systemId = system;
        std::strcpy(out.systemName, "Simulated headset");
        const auto &keys = runtime().keys;
        for (auto *next = static_cast<XrBaseOutStructure *>(out.next); next != nullptr; next = next->next) {
            if (next->type == XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT)
                reinterpret_cast<XrSystemEyeGazeInteractionPropertiesEXT *>(next)->supportsEyeGazeInteraction =
                    keys.whole("fault.gaze.unsupported") == 0;
            else if (next->type == XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT)
                reinterpret_cast<XrSystemHandTrackingPropertiesEXT *>(next)->supportsHandTracking =
                    keys.whole("fault.hands.unsupported") == 0;
            else if (next->type == XR_TYPE_SYSTEM_MARKER_UNDERSTANDING_PROPERTIES_ML)
                reinterpret_cast<XrSystemMarkerUnderstandingPropertiesML *>(next)->supportsMarkerUnderstanding =
                    keys.whole("fault.markers.unsupported") == 0;
            else
                misuse(ML2SIM_XR_MISUSE_TYPE, XR_ERROR_VALIDATION_FAILURE, "unknown system properties are chained");
        }
    });
}

XrResult xrConvertTimespecTimeToTimeKHR(XrInstance instance, const timespec *monotonic, XrTime *time) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        requireNonNull(time, "time") = mlTimeOfMonotonic(monotonic->tv_sec * kSecond + monotonic->tv_nsec);
    });
}

XrResult xrConvertTimeToTimespecTimeKHR(XrInstance instance, XrTime time, timespec *monotonic) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        if (time <= 0)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_TIME_INVALID, "times are positive");
        const int64_t nanos = monotonicOfMlTime(time);
        requireNonNull(monotonic, "timespec") = {static_cast<time_t>(nanos / kSecond),
                                                 static_cast<long>(nanos % kSecond)};
    });
}

} // namespace ml2sim::xr
