// MLPerceptionShutdown. It is apart from MLPerceptionStartup, since it asks trackers, and trackers ask perception.cpp.
#include "counters.h"
#include "ml_unused.h"
#include "perception.h"
#include "trackers.h"

using namespace ml2sim;

MLResult MLPerceptionShutdown(void) {
    if (!stopPerception()) {
        const bool isOfApp = isPerceptionStarted();
        misuse(ML2SIM_MISUSE_RELEASE, "%s: %s", __func__, isOfApp ? "the app started it" : "not started");
        return isOfApp ? MLResult_Ok : MLResult_PerceptionSystemNotStarted;
    }
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
