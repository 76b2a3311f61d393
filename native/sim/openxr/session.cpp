#include "session.h"

#include "../clock.h"
#include "../settings.h"
#include "../tracking.h"
#include "entry_points.h"

namespace ml2sim::xr {
namespace {

/** The history of poses, and the longest prediction. */
constexpr int64_t kMemoryNanos = 2 * kSecond;
constexpr int64_t kForesightNanos = kSecond / 10;

void enterState(XrSession handle, Session &session, XrSessionState state) {
    session.state = state;
    post(XrEventDataSessionStateChanged{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr, handle, state, mlTimeNow()});
}

void noticeNewWorld(XrSession handle, Session &session) {
    if (session.world == sessionNumber())
        return;
    session.world = sessionNumber();
    postSpaceChange(handle, XR_REFERENCE_SPACE_TYPE_LOCAL);
}

void follow(XrSession handle, Session &session) {
    const auto &keys = runtime().keys;
    const bool shallStop = keys.whole("fault.session.stopping") != 0;
    if (keys.whole("fault.session.lost") != 0) {
        if (session.state != XR_SESSION_STATE_LOSS_PENDING)
            enterState(handle, session, XR_SESSION_STATE_LOSS_PENDING);
    } else if (shallStop && session.isFocused()) {
        enterState(handle, session, XR_SESSION_STATE_STOPPING);
    } else if (!shallStop && session.state == XR_SESSION_STATE_IDLE && keys.whole("fault.session.idle") == 0) {
        enterState(handle, session, XR_SESSION_STATE_READY);
    }
}

Space &located(XrSpace space) { return find<Space>(space, "space"); }

} // namespace

void applySessionFaults() {
    for (auto &[handle, object] : runtime().objects)
        if (auto *session = dynamic_cast<Session *>(object.get())) {
            noticeNewWorld(reinterpret_cast<XrSession>(handle), *session);
            follow(reinterpret_cast<XrSession>(handle), *session);
            tellUserEvents(reinterpret_cast<XrSession>(handle), *session);
        }
}

void postSpaceChange(XrSession handle, XrReferenceSpaceType space) {
    post(XrEventDataReferenceSpaceChangePending{
        XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, nullptr, handle, space, mlTimeNow(), false, {}});
}

void checkTime(XrTime time) {
    if (time <= 0)
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_TIME_INVALID, "times are positive");
    const int64_t now = mlTimeNow();
    if (time < now)
        refuseIf("fault.pose.time_invalid", XR_ERROR_TIME_INVALID);
    if (time < now - kMemoryNanos || time > now + kForesightNanos)
        throw Refusal{XR_ERROR_TIME_INVALID};
}

Pose headAt(XrTime time) { return reportedHead(time); }

bool isTracked() { return trackingNow() == ml2sim::kTracked; }

XrPosef toXr(const Pose &pose) {
    const auto f = [](double value) { return static_cast<float>(value); };
    const auto &q = pose.rotation;
    return {{f(q.x), f(q.y), f(q.z), f(q.w)}, {f(pose.position.x), f(pose.position.y), f(pose.position.z)}};
}

XrResult xrCreateSession(XrInstance instance, const XrSessionCreateInfo *createInfo, XrSession *session) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &info = requireType(createInfo, XR_TYPE_SESSION_CREATE_INFO, "XrSessionCreateInfo");
        if (info.next == nullptr && runtime().extensions.count(XR_MND_HEADLESS_EXTENSION_NAME) == 0)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_GRAPHICS_DEVICE_INVALID, "no graphics, and not headless");
        auto created = std::make_unique<Session>();
        auto &state = *created;
        state.world = sessionNumber();
        requireNonNull(session, "session") = registerObject<XrSession>(number(instance), std::move(created));
        ++runtime().counters.sessions_created;
        enterState(*session, state, XR_SESSION_STATE_IDLE);
    });
}

XrResult xrDestroySession(XrSession session) { return destroyHandle<Session>(session, "session"); }

XrResult xrBeginSession(XrSession session, const XrSessionBeginInfo *beginInfo) {
    return entry([&](auto &) {
        auto &state = find<Session>(session, "session");
        requireType(beginInfo, XR_TYPE_SESSION_BEGIN_INFO, "XrSessionBeginInfo");
        if (state.isRunning || state.state != XR_SESSION_STATE_READY)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_SESSION_NOT_READY, "a session begun that was not ready");
        state.isRunning = true;
        for (const auto next : {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
            enterState(session, state, next);
    });
}

XrResult xrEndSession(XrSession session) {
    return entry([&](auto &) {
        auto &state = find<Session>(session, "session");
        if (!state.isRunning || state.state != XR_SESSION_STATE_STOPPING)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_SESSION_NOT_STOPPING, "a session ended that was not stopping");
        state.isRunning = false;
        enterState(session, state, XR_SESSION_STATE_IDLE);
    });
}

XrResult xrCreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo *createInfo, XrSpace *space) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(createInfo, XR_TYPE_REFERENCE_SPACE_CREATE_INFO, "XrReferenceSpaceCreateInfo");
        auto created = std::make_unique<Space>();
        if (info.referenceSpaceType == XR_REFERENCE_SPACE_TYPE_VIEW)
            created->at = [](XrTime time) { return std::optional<Pose>(headAt(time)); };
        else if (info.referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL)
            created->at = [](XrTime) {
                return std::optional<Pose>(Pose{{}, {0, ml2sim::number(Key::AssumeLocalSpace), 0}});
            };
        else if (info.referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCALIZATION_MAP_ML &&
                 runtime().extensions.count(XR_ML_LOCALIZATION_MAP_EXTENSION_NAME) != 0)
            created->at = [session](XrTime time) { return mapOrigin(session, time); };
        else
            return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
        requireNonNull(space, "space") = registerObject<XrSpace>(number(session), std::move(created));
        return XR_SUCCESS;
    });
}

XrResult xrDestroySpace(XrSpace space) { return destroyHandle<Space>(space, "space"); }

XrResult xrLocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation *location) {
    return entry([&](auto &) {
        const auto &what = located(space), &where = located(base);
        auto &out = requireType(location, XR_TYPE_SPACE_LOCATION, "XrSpaceLocation");
        checkTime(time);
        const auto pose = what.at(time), from = where.at(time);
        out.locationFlags = pose && from && isTracked() ? kLocated : 0;
        if (out.locationFlags != 0)
            out.pose = toXr(compose(inverse(*from), *pose));
    });
}

} // namespace ml2sim::xr
