// The start of the perception system, which affects the whole process.
#include "perception.h"

#include <atomic>

#include "camera_connection.h"
#include "clock.h"
#include "counters.h"

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

bool stopPerception() {
    hadSnapshot = false;
    return isStarted.exchange(false);
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLPerceptionInitSettings(MLPerceptionSettings *out_settings) {
    passHold(__func__);
    if (out_settings == nullptr)
        return refuseArgument(__func__, "out_settings is null");
    *out_settings = {};
    return MLResult_Ok;
}

MLResult MLPerceptionStartup(MLPerceptionSettings *settings) {
    passHold(__func__);
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
