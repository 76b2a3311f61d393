// A vendor's library that does exactly what a test says and remembers what it was asked. For what the simulated headset
// cannot do: pixels known one by one, any answer of any call, and the order of calls.
#pragma once

#include <atomic>
#include <map>
#include <semaphore.h>
#include <string>
#include <vector>

#include "../../sdk/tables.h"

namespace scripted {

/** MLTime minus CLOCK_MONOTONIC. */
constexpr int64_t kOffsetNanos = 7777777777777777;

struct Script {
    /** Answers other than Ok, by function. */
    std::map<std::string, MLResult> results;
    /** The functions called, in order, except conversions of time. */
    std::vector<std::string> calls;

    MLDepthCameraSettings depthSettings = {};
    MLWorldCameraSettings worldSettings = {};
    MLEyeCameraSettings eyeSettings = {};
    uint64_t timeout_ms = 0;

    /** The frames that the next gets return. */
    std::vector<MLDepthCameraFrame> depthFrames;
    std::vector<MLWorldCameraFrame> worldFrames;
    std::vector<MLEyeCameraFrame> eyeFrames;
    int frameCount = -1; ///< Claimed instead of the true one.

    /** By the library or, when a test says so, by the app. */
    bool isPerceptionStarted = false;
    int snapshotsRefused = 0; ///< So many fail before the first.

    uint32_t headStatus = MLHeadTrackingStatus_Valid;
    uint64_t mapEvents = 0;
    MLTransform transform = {{0, 0, 0, 1}, {0, 0, 0}};
    MLTime snapshotTime = 0;
    MLTime cameraPoseTime = 0;

    int countOf(const std::string &function) const;
};

extern Script script;

/** A function that does not return, while this is not "". Set while nothing is called. */
extern std::string blocking;
/** True once a thread is in the function that does not return; the next one returns. */
extern std::atomic<bool> isBlocked;
/** Posted with it. */
extern sem_t blocked;
/** Lets it return when posted. */
extern sem_t released;

} // namespace scripted
