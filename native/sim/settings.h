// The keys of ml2sim_set: one table, read by everything in this folder.
#pragma once

#include <cstdint>
#include <string>

namespace ml2sim {

enum class Key {
    Seed,
    LoopSeconds,
    Trajectory,
    Tangential,
    ImageNoise,
    DepthNoise,
    ImuBias,
    ImuNoise,
    MlTimeOffset,
    MlTimeSkew,
    ControllerTracked,
    HandsVisible,
    HiddenKeyPoint,
    StridePadding,
    AbortOnMisuse,
    Clock,
    Cache,
    AppPerception,
    Mains,
    PerceptionStartup,
    FaultColorPermission,
    FaultColorPose,
    FaultGazePermission,
    FaultGazeClosed,
    FaultHandsPermission,
    FaultPerceptionStartup,
    FaultTimeConvert,
    FaultHeadCreate,
    FaultHeadTracking,
    FaultHeadNewSession,
    FaultSnapshotGet,
    FaultSnapshotPredicted,
    FaultPoseUnusable,
    FaultCameras, // the first of kCameraFaults keys for each CameraKind
};

/** The cameras that share their faults: fault.<camera>.<what>. */
enum class CameraKind { Depth, World, Eye };

enum class Fault {
    Permission,
    Connect,
    Stalled,
    Get,
    Disconnected,
    DropEvery,
    FrameCount,
    Size,
    Stride,
    Width,
    BytesPerPixel,
    NullData,
    NullFrames,
    Version,
    Id,
    NotFinite,
    OddEvery,
};

/** Values of Key::FaultHeadTracking. */
enum Tracking { kTracked = 0, kRelocalizing = 1, kLost = 2 };

/** The value of a key of numbers; for Fault::FrameCount to BytesPerPixel -1 is "as it should be". Any thread. */
double number(Key key);
double fault(CameraKind camera, Fault what);
inline bool isOn(Key key) { return number(key) != 0; }
inline bool hasFault(CameraKind camera, Fault what) { return fault(camera, what) > 0; }

/** The value of a key of text. Any thread. */
std::string text(Key key);

/** The value of a key, as setKey takes it; empty when there is no such key. */
std::string keyValue(const std::string &name);

/** Whether name is a key that pictures and poses depend on, which therefore rests while a camera is open. */
bool shapesTheScene(const std::string &name);

/** Sets a key; empty, or what is wrong with it. */
std::string setKey(const std::string &name, const std::string &value);

/** One line per key, as ml2sim_describe_keys gives it. */
std::string describeKeys();

/** Defaults, then ML2SIM of the environment; empty, or what is wrong with that. */
std::string resetKeys();

} // namespace ml2sim
