// Draws the frames of captures that are to come.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "frame_cache.h"

namespace ml2sim {

/** Returns the frames of a capture. */
using CaptureFrames = std::function<std::vector<FrameCache::Place>(int64_t index)>;

/** Returns true if time goes on while frames are drawn, so that a capture whose frames are not drawn is late. */
bool drawsAhead();

/** Draws the frames of one capture at a time in a thread of its own. Used by one thread. */
class Drawer {
  public:
    /**
     * Begins to draw the first capture that is not drawn, among the next that can be ready when they are delivered;
     * nothing if it still draws. Wakes the waiters of the clock when it is ready.
     */
    void begin(const CaptureFrames &frames, uint32_t rate_hz, int64_t delayNanos);

    /** Waits until a capture is drawn, if it is the one that is being drawn. */
    void await(int64_t index) const;

    /** Returns the capture that is being drawn, or was last. */
    int64_t index() const { return index_; }

  private:
    struct State {
        std::atomic<bool> isDrawing{false};
    };
    std::shared_ptr<State> state_ = std::make_shared<State>();
    int64_t index_ = 0;
};

} // namespace ml2sim
