#include "drawer.h"

#include <algorithm>
#include <thread>

#include "clock.h"
#include "head_path.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** Returns the time that frames like these take at most: a quarter more than the last, for it varies. */
int64_t expectedNanos(const std::vector<FrameCache::Place> &places) {
    int64_t last = 0;
    for (const auto &place : places)
        last = std::max(last, place.cache->drawingNanos());
    return last + last / 4;
}

} // namespace

bool drawsAhead() { return text(Key::Clock) != "manual"; }

void Drawer::await(int64_t index) const {
    constexpr int64_t kRecheck = kSecond;
    for (uint64_t seen = wakeCount(); index == index_ && state_->isDrawing; seen = wakeCount())
        waitUntil(mlTimeNow() + kRecheck, seen);
}

void Drawer::begin(const CaptureFrames &frames, uint32_t rate_hz, int64_t delayNanos) {
    /** More would not be reached before the next capture. */
    constexpr int64_t kMostAhead = 64;
    if (state_->isDrawing)
        return;
    const int64_t due = mlTimeNow() - delayNanos;
    const auto soonest = frames(captureIndex(due, rate_hz) + 1);
    const int64_t first = captureIndex(due + expectedNanos(soonest), rate_hz) + 1;
    for (int64_t index = first; index < first + kMostAhead; index++) {
        const auto places = frames(index);
        if (FrameCache::areDrawn(places))
            continue;
        index_ = index;
        state_->isDrawing = true;
        // It may outlive this object; frames live as long as the process.
        std::thread([state = state_, places] {
            FrameCache::draw(places);
            state->isDrawing = false;
            wakeWaiters();
        }).detach();
        return;
    }
}

} // namespace ml2sim
