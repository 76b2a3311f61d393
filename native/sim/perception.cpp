// MLPerceptionStartup and MLPerceptionShutdown, which affect the whole process.
#include "perception.h"

#include <atomic>

#include "camera_connection.h"
#include "clock.h"
#include "counters.h"
#include "ml_unused.h"

namespace ml2sim {
namespace {

/** True if the caller has started the system. The simulated app can run it, too. */
std::atomic<bool> isStarted{false};
std::atomic<int64_t> startedAt{0}; ///< MLTime
std::atomic<bool> hadSnapshot{false};

bool isAppRunningIt() { return isOn(Key::AppPerception); }

} // namespace

bool isPerceptionStarted() { return isStarted || isAppRunningIt(); }

bool hasSnapshots() {
    const auto delay = static_cast<int64_t>(number(Key::PerceptionStartup) * kSecond);
    return isAppRunningIt() || (isStarted && mlTimeNow() >= startedAt + delay);
}

void markFirstSnapshot() { hadSnapshot = true; }

MLResult canCreateTracker() {
    if (!isPerceptionStarted())
        return MLResult_PerceptionSystemNotStarted;
    return isAppRunningIt() || hadSnapshot ? MLResult_Ok : MLResult_UnspecifiedFailure;
}

void resetPerception() {
    isStarted = false;
    hadSnapshot = false;
    resetHeadTracking();
    resetColorTracking();
    resetEyeTracking();
    resetHandTracking();
    resetControllerTracking();
    resetSnapshots();
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLPerceptionInitSettings(MLPerceptionSettings *out_settings) {
    if (out_settings == nullptr)
        return refuseArgument(__func__, "out_settings is null");
    *out_settings = {};
    return MLResult_Ok;
}

MLResult MLPerceptionStartup(MLPerceptionSettings *settings) {
    if (settings == nullptr)
        return refuseArgument(__func__, "settings are null");
    if (isOn(Key::FaultPerceptionStartup))
        return MLResult_UnspecifiedFailure;
    if (isPerceptionStarted())
        misuse(ML2SIM_MISUSE_CLIENTS, "%s: it runs already, for the whole process", __func__);
    hadSnapshot = false;
    startedAt = mlTimeNow();
    isStarted = true;
    setPerceptionStarted(true);
    return MLResult_Ok;
}

MLResult MLPerceptionShutdown(void) {
    if (!isStarted) {
        misuse(ML2SIM_MISUSE_RELEASE, "%s: %s", __func__, isAppRunningIt() ? "the app started it" : "not started");
        return isAppRunningIt() ? MLResult_Ok : MLResult_PerceptionSystemNotStarted;
    }
    isStarted = false;
    const auto state = [](bool isOpen) { return isOpen ? "open" : "closed"; };
    if (anyHeadTracker() || anyColorTracker() || anyEyeTracker() || anyHandTracker() || anyControllerTracker() ||
        openSnapshots() > 0)
        misuse(ML2SIM_MISUSE_UNRELEASED,
               "%s: trackers of head %s, colour camera %s, eyes %s, hands %s, controller %s, %u snapshots", __func__,
               state(anyHeadTracker()), state(anyColorTracker()), state(anyEyeTracker()), state(anyHandTracker()),
               state(anyControllerTracker()), openSnapshots());
    setPerceptionStarted(false);
    return MLResult_Ok;
}
