// MLPerceptionGet*Snapshot, MLSnapshot*: the poses at one instant.
#include <unistd.h>

#include <mutex>
#include <set>

#include "camera_connection.h"
#include "clock.h"
#include "counters.h"
#include "head_path.h"
#include "ml_unused.h"
#include "perception.h"
#include "trackers.h"
#include "tracking.h"

/** A snapshot stores its time; poses are computed when they are read. Immutable. */
struct MLSnapshot {
    MLTime time;
    MLTime madeAt;
    uint64_t session;
    bool isHeadKnown;
    pid_t owner;
};

namespace ml2sim {
namespace {

constexpr int64_t kMostAhead = kSecond / 10;
/** The vendor does not state how old a snapshot can be. */
constexpr int64_t kMostBehind = kSecond / 2;
constexpr uint32_t kDisplay_hz = 60;

std::mutex mutex;
std::set<const MLSnapshot *> snapshots;

MLResult make(const char *function, MLTime time, MLSnapshot **out) {
    passHold(function);
    if (out == nullptr)
        return refuseArgument(function, "out_snapshot is null");
    *out = nullptr;
    if (!hasSnapshots())
        return MLResult_PerceptionSystemNotStarted;
    if (isOn(Key::FaultSnapshotGet))
        return MLResult_UnspecifiedFailure;
    const int64_t now = mlTimeNow();
    if (time > now + kMostAhead || time < now - kMostBehind)
        return MLResult_InvalidTimestamp;
    *out = new MLSnapshot{time, now, sessionNumber(), isHeadPoseKnown(), gettid()};
    markFirstSnapshot();
    adjust(Counter::Snapshots, 1);
    const std::lock_guard lock(mutex);
    for (const auto *other : snapshots)
        if (other->owner != gettid())
            misuse(ML2SIM_MISUSE_THREAD, "%s: thread %d has a snapshot, this is %d", function, other->owner, gettid());
    snapshots.insert(*out);
    return MLResult_Ok;
}

MLResult checkOpen(const char *function, const MLSnapshot *snapshot) {
    passHold(function);
    const std::lock_guard lock(mutex);
    if (snapshots.count(snapshot) == 1)
        return MLResult_Ok;
    misuse(ML2SIM_MISUSE_RELEASE, "%s: snapshot %p was not got, or is released already", function,
           static_cast<const void *>(snapshot));
    return MLResult_InvalidParam;
}

bool isSame(const MLCoordinateFrameUID &a, const MLCoordinateFrameUID &b) {
    return a.data[0] == b.data[0] && a.data[1] == b.data[1];
}

/** Returns the coordinate frame of the origin of a session. */
MLCoordinateFrameUID originOf(uint64_t session) { return {{0x4f524947494e0000, session}}; }

/** Returns the pose of a coordinate frame in the world. */
MLResult find(const MLSnapshot &snapshot, const MLCoordinateFrameUID &id, Pose *out) {
    *out = {};
    if (isSame(id, originOf(snapshot.session)))
        return MLResult_Ok;
    if (!snapshot.isHeadKnown)
        return MLResult_PoseNotFound;
    auto inHead = isSame(id, kHeadFrame) ? std::optional<Pose>(Pose{}) : eyesInHead(id, snapshot.time);
    if (!inHead)
        inHead = handsInHead(id);
    if (!inHead)
        inHead = controllerInHead(id, snapshot.time);
    if (!inHead)
        return MLResult_PoseNotFound;
    *out = compose(reportedHead(snapshot.time), *inHead);
    return MLResult_Ok;
}

MLVec3f toVector(Vec3 v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

struct Derivatives {
    MLVec3f velocity, acceleration, angularVelocity, angularAcceleration;
};

/** Returns the derivatives of the head pose in world axes. */
Derivatives derivativesAt(MLTime time) {
    constexpr int64_t kStep = kSecond / 1000;
    const auto motion = HeadPath::current()->at(time);
    const Vec3 moved = trueHead(time + kStep).position - trueHead(time - kStep).position;
    const Quaternion ofWorld = inWorld({}).rotation;
    const Quaternion head = ofWorld * motion.head.rotation;
    return {toVector(0.5 * kSecond / kStep * moved), toVector(rotate(ofWorld, motion.acceleration)),
            toVector(rotate(head, motion.angular_velocity)), toVector(rotate(head, motion.angular_acceleration))};
}

} // namespace

uint32_t openSnapshots() {
    const std::lock_guard lock(mutex);
    return static_cast<uint32_t>(snapshots.size());
}

void resetSnapshots() {
    const std::lock_guard lock(mutex);
    for (const auto *snapshot : snapshots)
        delete snapshot;
    snapshots.clear();
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLPerceptionGetSnapshot(MLSnapshot **out_snapshot) {
    const int64_t nextFrame = captureIndex(mlTimeNow(), kDisplay_hz) + 1;
    return make(__func__, captureTime(nextFrame, kDisplay_hz), out_snapshot);
}

MLResult MLPerceptionGetPredictedSnapshot(MLTime time, MLSnapshot **out_snapshot) {
    if (isOn(Key::FaultSnapshotPredicted) && hasSnapshots())
        return MLResult_InvalidTimestamp;
    return make(__func__, time, out_snapshot);
}

MLResult MLPerceptionReleaseSnapshot(MLSnapshot *snapshot) {
    if (const auto result = checkOpen(__func__, snapshot))
        return result;
    {
        const std::lock_guard lock(mutex);
        snapshots.erase(snapshot);
    }
    delete snapshot;
    adjust(Counter::Snapshots, -1);
    return MLResult_Ok;
}

MLResult MLSnapshotGetTransform(const MLSnapshot *snapshot, const MLCoordinateFrameUID *id,
                                MLTransform *out_transform) {
    if (id == nullptr || out_transform == nullptr)
        return refuseArgument(__func__, "id or out_transform is null");
    if (const auto result = checkOpen(__func__, snapshot))
        return result;
    Pose pose;
    if (const auto result = find(*snapshot, *id, &pose))
        return result;
    *out_transform = toTransform(pose);
    return MLResult_Ok;
}

MLResult MLSnapshotGetTransformWithDerivatives(const MLSnapshot *snapshot, const MLCoordinateFrameUID *id,
                                               MLTransform *out_transform, MLTransformDerivatives *out_derivatives) {
    if (const auto result = checkStructure(__func__, out_derivatives, 1))
        return result;
    if (const auto result = MLSnapshotGetTransform(snapshot, id, out_transform))
        return result;
    if (!isSame(*id, kHeadFrame))
        return MLSnapshotResult_DerivativesNotCalculated;
    const auto d = derivativesAt(snapshot->time);
    *out_derivatives = {1, d.velocity, d.acceleration, d.angularVelocity, d.angularAcceleration};
    return MLResult_Ok;
}

MLResult MLSnapshotGetStaticData(MLSnapshotStaticData *out_data) {
    if (const auto result = checkStructure(__func__, out_data, 1))
        return result;
    if (!isPerceptionStarted())
        return MLResult_PerceptionSystemNotStarted;
    out_data->coord_world_origin = originOf(sessionNumber());
    return MLResult_Ok;
}

MLResult MLSnapshotGetPoseInBase(const MLSnapshot *snapshot, const MLCoordinateFrameUID *base,
                                 const MLCoordinateFrameUID *id, MLPose *out_pose) {
    if (base == nullptr || id == nullptr || out_pose == nullptr)
        return refuseArgument(__func__, "base, id or out_pose is null");
    if (const auto result = checkOpen(__func__, snapshot))
        return result;
    Pose inWorldOfBase, inWorldOfId;
    if (const auto result = find(*snapshot, *base, &inWorldOfBase))
        return result;
    if (const auto result = find(*snapshot, *id, &inWorldOfId))
        return result;
    *out_pose = {};
    out_pose->transform = toTransform(compose(inverse(inWorldOfBase), inWorldOfId));
    out_pose->origin_time_ns = snapshot->madeAt;
    out_pose->predict_time_ns = snapshot->time;
    return MLResult_Ok;
}
