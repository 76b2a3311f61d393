// The events of the map and of how the headset is worn. Keys say what they tell; a change of a key is a new event.
#include "../clock.h"
#include "entry_points.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

void postLocalization(XrSession session, const Told &told) {
    XrEventDataLocalizationChangedML event{};
    event.type = XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML;
    event.session = session;
    event.state = static_cast<XrLocalizationMapStateML>(told[0]);
    event.confidence = static_cast<XrLocalizationMapConfidenceML>(told[1]);
    event.errorFlags = static_cast<XrLocalizationMapErrorFlagsML>(told[2]);
    event.map.type = XR_TYPE_LOCALIZATION_MAP_ML;
    if (event.state == XR_LOCALIZATION_MAP_STATE_LOCALIZED_ML)
        event.map = describe(maps().at(static_cast<size_t>(told[3])));
    post(event);
}

void postFit(const Told &told) {
    post(XrEventDataHeadsetFitChangedML{XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML, nullptr,
                                        static_cast<XrHeadsetFitStatusML>(told[0]), mlTimeNow()});
}

void postCalibration(const Told &told) {
    post(XrEventDataEyeCalibrationChangedML{XR_TYPE_EVENT_DATA_EYE_CALIBRATION_CHANGED_ML, nullptr,
                                            static_cast<XrEyeCalibrationStatusML>(told[0])});
}

Told valuesOf(std::initializer_list<const char *> keys) {
    Told values;
    for (const char *key : keys)
        values.push_back(runtime().keys.whole(key));
    return values;
}

/** Tells news once: if they differ from what was told before. */
template <class Post> void tell(Listening &listening, const Told &news, Post post) {
    if (!listening.isEnabled || listening.told == news)
        return;
    listening.told = news;
    post(news);
}

} // namespace

void tellUserEvents(XrSession handle, Session &session) {
    if (!session.isFocused())
        return;
    auto localization = valuesOf({"map.confidence", "map.errors"});
    localization.insert(localization.begin(), mapState(session));
    localization.push_back(static_cast<int64_t>(session.map));
    if (runtime().keys.whole("fault.map.silent") == 0)
        tell(session.localization, localization, [&](const Told &told) { postLocalization(handle, told); });
    if (runtime().keys.whole("fault.calibration.silent") != 0)
        return;
    tell(session.fit, valuesOf({"headset.fit"}), postFit);
    tell(session.calibration, valuesOf({"eyes.calibration"}), postCalibration);
}

XrResult xrEnableLocalizationEventsML(XrSession session, const XrLocalizationEnableEventsInfoML *enableInfo) {
    return entry([&](auto &) {
        auto &state = find<Session>(session, "session");
        const auto &info =
            requireType(enableInfo, XR_TYPE_LOCALIZATION_ENABLE_EVENTS_INFO_ML, "XrLocalizationEnableEventsInfoML");
        refuseIf("fault.map.denied", XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML);
        // Enabled before the session runs, the first event never comes.
        state.localization = {info.enabled != 0 && state.isRunning, {}};
    });
}

XrResult xrEnableUserCalibrationEventsML(XrInstance instance, const XrUserCalibrationEnableEventsInfoML *enableInfo) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &info = requireType(enableInfo, XR_TYPE_USER_CALIBRATION_ENABLE_EVENTS_INFO_ML,
                                       "XrUserCalibrationEnableEventsInfoML");
        refuseIf("fault.calibration.refused", XR_ERROR_RUNTIME_FAILURE);
        for (auto &[handle, object] : runtime().objects)
            if (auto *session = dynamic_cast<Session *>(object.get()))
                session->fit = session->calibration = {info.enabled != 0 && session->isRunning, {}};
    });
}

} // namespace ml2sim::xr
