#include "tracking.h"

#include <cmath>
#include <limits>
#include <mutex>

#include "clock.h"
#include "head_path.h"
#include "imperfections.h"
#include "ml_perception.h"

namespace ml2sim {
namespace {

struct State {
    Tracking tracking = kTracked;
    int64_t lostSince = 0; ///< MLTime
    double sessionKey = 0;
    uint64_t session = 0;
    Pose worldFromScene;
    MapEvents events;
};

std::mutex mutex;
State state;

State stateNow() {
    const std::lock_guard lock(mutex);
    return state;
}

/** Returns a gravity aligned world at a head, with its position and its rotation about the vertical. */
Pose originAt(const Pose &head) {
    const Vec3 forward = rotate(head.rotation, {0, 0, -1});
    return {Quaternion::about({0, 1, 0}, std::atan2(-forward.x, -forward.z)), head.position};
}

} // namespace

Pose inWorld(const Pose &inScene) { return compose(stateNow().worldFromScene, inScene); }

Vec3 pointInWorld(Vec3 inScene) { return transform(stateNow().worldFromScene, inScene); }

Pose trueHead(int64_t mltime) { return inWorld(HeadPath::current()->at(mltime).head); }

Pose reportedHead(int64_t mltime) {
    const State now = stateNow();
    const bool isStale = now.tracking != kTracked && mltime > now.lostSince;
    const int64_t time = isStale ? now.lostSince : mltime;
    return compose(now.worldFromScene, withTrackingErrors(HeadPath::current()->at(time).head, time));
}

MLTransform reportedCamera(Camera camera, int64_t mltime) {
    Pose pose = compose(reportedHead(mltime), mount(camera));
    if (camera != Camera::Color)
        pose.rotation = pose.rotation * aboutX(number(Key::AssumeCameraAxes));
    return toTransform(pose);
}

Quaternion aboutX(double degrees) { return Quaternion::about({1, 0, 0}, degrees / 180 * 3.14159265358979323846); }

MLTransform toTransform(const Pose &pose) {
    const auto f = [](double value) { return static_cast<float>(value); };
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    switch (static_cast<int>(number(Key::FaultPoseUnusable))) {
    case 1:
        return {};
    case 2:
        return {{kNaN, kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}};
    case 3:
        return {{0, 0, 0, 0.5f}, {f(pose.position.x), f(pose.position.y), f(pose.position.z)}};
    }
    return {{f(pose.rotation.x), f(pose.rotation.y), f(pose.rotation.z), f(pose.rotation.w)},
            {f(pose.position.x), f(pose.position.y), f(pose.position.z)}};
}

Tracking trackingNow() { return stateNow().tracking; }

uint64_t sessionNumber() { return stateNow().session; }

MapEvents mapEventsSoFar() { return stateNow().events; }

uint64_t mapEventsBetween(const MapEvents &before, const MapEvents &after) {
    const auto bit = [](bool isSet, uint64_t value) { return isSet ? value : 0; };
    return bit(after.lost != before.lost, MLHeadTrackingMapEvent_Lost) |
           bit(after.recovered != before.recovered, MLHeadTrackingMapEvent_Recovered) |
           bit(after.recoveryFailed != before.recoveryFailed, MLHeadTrackingMapEvent_RecoveryFailed) |
           bit(after.newSession != before.newSession, MLHeadTrackingMapEvent_NewSession);
}

void refreshTracking() {
    const auto tracking = static_cast<Tracking>(number(Key::FaultHeadTracking));
    const double sessionKey = number(Key::FaultHeadNewSession);
    const int64_t now = mlTimeNow();
    const auto head = HeadPath::current()->at(now).head;
    const std::lock_guard lock(mutex);
    if (state.sessionKey != sessionKey) {
        state.worldFromScene = inverse(originAt(head));
        state.session++;
        state.events.newSession++;
        if (state.tracking != kTracked)
            state.events.recoveryFailed++;
    } else if (state.tracking != kTracked && tracking == kTracked) {
        state.events.recovered++;
    }
    if (state.tracking == kTracked && tracking != kTracked) {
        state.events.lost++;
        state.lostSince = now;
    }
    state.tracking = tracking;
    state.sessionKey = sessionKey;
}

void resetTracking() {
    {
        const std::lock_guard lock(mutex);
        state = {};
        state.sessionKey = number(Key::FaultHeadNewSession);
    }
    refreshTracking();
}

} // namespace ml2sim
