// The one headset that all pictures, poses and motions are of: its path through the room, and its tracking.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "scene/cameras.h"
#include "scene/scene.h"
#include "scene/trajectory.h"

namespace ml2sim {

/** A path through the room and when it is walked. Immutable but for its start. */
class Stage {
  public:
    /** The path of the keys. Throws TrajectoryError. */
    static std::shared_ptr<Stage> fromKeys();

    /** The stage of now. Any thread. */
    static std::shared_ptr<Stage> current();

    /** Makes a stage from the keys the current one; empty, or why it could not be. */
    static std::string refresh();

    /** The head in the room. */
    Motion at(int64_t mltime) const;

    /** A path that does not loop is walked from the first whole second after this; only the first call counts. */
    void begin();

    /** How many frames a film of it has, at a rate. */
    size_t filmFrames(uint32_t rate_hz) const;
    /** Which of them shows capture number index of a camera. */
    size_t filmIndex(int64_t index, uint32_t rate_hz) const;
    /** The head when frame index of a film is captured. */
    Motion atFilm(size_t index, uint32_t rate_hz) const;

    /** All that the path depends on. */
    const std::string &inputs() const { return inputs_; }

    /** The room, built when first asked for. */
    static std::shared_ptr<const Scene> room();

  private:
    Stage(Trajectory trajectory, bool isLoop, std::string inputs);

    Trajectory trajectory_;
    bool isLoop_;
    int64_t loopNanos_;
    std::string inputs_;
    std::atomic<int64_t> start_;
};

/** Capture number index of a camera at a rate: MLTime. The grids of all rates meet at whole seconds. */
int64_t captureTime(int64_t index, uint32_t rate_hz);

/** The newest capture at or before an MLTime. */
int64_t captureIndex(int64_t mltime, uint32_t rate_hz);

} // namespace ml2sim
