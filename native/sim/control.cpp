// ml2sim_set, ml2sim_reset and the control of the clock.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "camera_connection.h"
#include "clock.h"
#include "counters.h"
#include "head_path.h"
#include "ml2sim.h"
#include "perception.h"
#include "settings.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

bool anyCameraOpen() { return isDepthCameraOpen() || isWorldCameraOpen() || isEyeCameraOpen(); }

/** Resets the keys and all state that depends on them. */
std::string resetAll() {
    auto problem = keys().reset("ML2SIM");
    resetClock();
    if (problem.empty())
        problem = HeadPath::refresh();
    if (problem.empty())
        resetTracking();
    return problem;
}

/** Runs when the library is loaded. */
struct Start {
    Start() {
        const auto problem = resetAll();
        if (problem.empty())
            return;
        std::fprintf(stderr, "ML2SIM: %s\n", problem.c_str());
        std::abort();
    }
} start;

std::string set(const std::string &name, const std::string &value) {
    const size_t index = keys().indexOf(name);
    if (index == keys().rows().size() || !keys().rows()[index].shapesTheScene)
        return keys().set(name, value);
    if (anyCameraOpen())
        return name + ": cannot change while a camera is open";
    const auto before = keys().value(index);
    auto problem = keys().set(name, value);
    if (problem.empty())
        problem = HeadPath::refresh();
    if (!problem.empty())
        keys().set(name, before);
    return problem;
}

} // namespace
} // namespace ml2sim

using namespace ml2sim;

const char *ml2sim_set(const char *key, const char *value) {
    thread_local std::string problem;
    problem = set(key, value);
    if (!problem.empty())
        return problem.c_str();
    refreshTracking();
    wakeWaiters();
    return nullptr;
}

const char *ml2sim_describe_keys(void) {
    thread_local std::string text;
    text = keys().describe();
    return text.c_str();
}

void ml2sim_reset(void) {
    resetDepthCamera();
    resetWorldCamera();
    resetEyeCamera();
    stopPerception();
    resetHeadTracking();
    resetColorTracking();
    resetEyeTracking();
    resetHandTracking();
    resetController();
    resetSnapshots();
    resetCounters();
    resetAll();
    wakeWaiters();
}

int64_t ml2sim_now_mltime(void) { return mlTimeNow(); }

int64_t ml2sim_now_boottime(void) { return boottimeOfMlTime(mlTimeNow()); }

int64_t ml2sim_mltime_of_boottime(int64_t boottime_nanos) { return mlTimeOfBoottime(boottime_nanos); }

int64_t ml2sim_boottime_of_mltime(int64_t mltime_nanos) { return boottimeOfMlTime(mltime_nanos); }

void ml2sim_advance(int64_t nanos) { advanceClock(nanos); }
