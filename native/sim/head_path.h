// The path of the simulated head. All images, poses and inertial measurements derive from it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "scene/cameras.h"
#include "scene/scene.h"
#include "scene/trajectory.h"

namespace ml2sim {

/** A path of the head through the scene, over MLTime. Immutable except for its start. */
class HeadPath {
  public:
    /** Makes the path that the keys describe. Throws TrajectoryError. */
    static std::shared_ptr<HeadPath> fromKeys();

    /** Returns the current path. Thread-safe. */
    static std::shared_ptr<HeadPath> current();

    /** Replaces the current path by that of the keys. Returns an empty text, or why there is no such path. */
    static std::string refresh();

    /** Returns the motion of the head in the scene. */
    Motion at(int64_t mltime) const;

    /** Returns where on the path the head is at a time: the seconds since its beginning. */
    double secondsAt(int64_t mltime) const;

    /** Returns after how many seconds the path repeats, or 0 if it does not. */
    double periodSeconds() const { return isLoop_ ? trajectory_.durationSeconds() : 0; }

    /** Starts a path that does not loop at the next whole second. Later calls have no effect. */
    void start();

    /** Returns the number of frames that a camera shows along the path. */
    size_t frameCount(uint32_t rate_hz) const;
    /** Returns which of these frames capture number `index` of a camera shows. */
    size_t frameIndex(int64_t index, uint32_t rate_hz) const;
    /** Returns the motion of the head at the capture of one of these frames. */
    Motion atFrame(size_t index, uint32_t rate_hz) const;

    /** Returns all parameters that the path depends on. */
    const std::string &inputs() const { return inputs_; }

    /** Returns the scene, which the first call builds. */
    static std::shared_ptr<const Scene> scene();

  private:
    HeadPath(Trajectory trajectory, bool isLoop, std::string inputs);

    Trajectory trajectory_;
    bool isLoop_;
    bool isStill_;
    int64_t loopNanos_;
    std::string inputs_;
    std::atomic<int64_t> start_;
};

/** Returns the MLTime of capture number `index`. The captures of all rates coincide at whole seconds. */
int64_t captureTime(int64_t index, uint32_t rate_hz);

/** Returns the number of the newest capture at or before an MLTime. */
int64_t captureIndex(int64_t mltime, uint32_t rate_hz);

} // namespace ml2sim
