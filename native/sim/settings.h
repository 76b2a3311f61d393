// The keys of ml2sim_set.
#pragma once

#include <cstdint>
#include <string>

#include "key_table.h"

namespace ml2sim {

enum class Key {
    Seed,
    LoopSeconds,
    StillImages,
    Trajectory,
    Tags,
    Tangential,
    ImageNoise,
    DepthNoise,
    DepthNoiseOfSquare,
    ImuBias,
    Noise,
    Mounts,
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
    Held,
    AssumeNormalExposure,
    AssumeFrameNumbers,
    AssumeRadialDepth,
    AssumeNullBuffers,
    AssumeKeyPoints,
    AssumeMagneticField,
    AssumeLocalSpace,
    AssumeVendorStructs,
    AssumeTrackerLayouts,
    AssumeHeadTrackers,
    AssumeConfidence,
    AssumeCameraAxes,
    AssumeMarkerAxes,
    AssumeMarkerLimit,
    AssumeMapAxes,
    FaultColorPermission,
    FaultColorPose,
    FaultGazePermission,
    FaultGazeClosed,
    FaultHandsPermission,
    FaultControllerPermission,
    FaultControllerTracking,
    FaultInputCreate,
    FaultInputDisconnected,
    FaultInputUnusable,
    FaultPerceptionStartup,
    FaultTimeConvert,
    FaultHeadCreate,
    FaultHeadTracking,
    FaultHeadConfidence,
    FaultHeadErrors,
    FaultHeadNewSession,
    FaultSnapshotGet,
    FaultSnapshotPredicted,
    FaultPoseUnusable,
    FaultCameras, // the first of kCameraFaults keys for each CameraKind
};

/** The cameras with the faults fault.<camera>.<what>. */
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

/** Return the value of a number. Fault::FrameCount to BytesPerPixel are off at -1, other faults at 0. Thread-safe. */
double number(Key key);
double fault(CameraKind camera, Fault what);
inline bool isOn(Key key) { return number(key) != 0; }
inline bool hasFault(CameraKind camera, Fault what) { return fault(camera, what) > 0; }

/** Returns the value of a text. Thread-safe. */
std::string text(Key key);

KeyTable &keys();

} // namespace ml2sim
