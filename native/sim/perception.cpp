// MLPerceptionStartup, MLPerceptionShutdown: everything that knows poses runs between them.
#include "perception.h"

#include <atomic>

#include "books.h"
#include "connection.h"
#include "sensors.h"

namespace ml2sim {
namespace {

/** An app and a library in it may each start the system; it runs until both have shut it down. */
std::atomic<int> starts{0};

} // namespace

bool isPerceptionStarted() { return starts > 0; }

void resetPerception() {
    starts = 0;
    resetHeadTracking();
    resetColorTracking();
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
    starts++;
    enterPerception(true);
    return MLResult_Ok;
}

MLResult MLPerceptionShutdown(void) {
    if (!isPerceptionStarted()) {
        misuse(ML2SIM_MISUSE_RELEASE, "%s: not started", __func__);
        return MLResult_PerceptionSystemNotStarted;
    }
    if (--starts > 0)
        return MLResult_Ok;
    if (anyHeadTracker() || anyColorTracker() || openSnapshots() > 0)
        misuse(ML2SIM_MISUSE_UNRELEASED, "%s: head tracker %s, colour camera tracker %s, %u snapshots open", __func__,
               anyHeadTracker() ? "open" : "closed", anyColorTracker() ? "open" : "closed", openSnapshots());
    enterPerception(false);
    return MLResult_Ok;
}
