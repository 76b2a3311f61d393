// State of the perception system that the tracking functions share.
#pragma once

#include <map>
#include <mutex>
#include <optional>

#include "ml_perception.h"
#include "scene/geometry.h"

namespace ml2sim {

bool isPerceptionStarted();

/** Returns true once the vendor's functions give snapshots, some time after the start. */
bool hasSnapshots();

/** Records the first snapshot. Trackers can be created from then on. */
void markFirstSnapshot();

/** Returns Ok, or why a tracker cannot be created now. */
MLResult canCreateTracker();

/** The open handles of one kind, each with a value. Thread-safe. */
template <typename T> class HandleRegistry {
  public:
    void add(MLHandle handle, T value) {
        const std::lock_guard lock(mutex_);
        open_.emplace(handle, value);
    }
    bool remove(MLHandle handle) {
        const std::lock_guard lock(mutex_);
        return open_.erase(handle) == 1;
    }
    std::optional<T> find(MLHandle handle) const {
        const std::lock_guard lock(mutex_);
        const auto found = open_.find(handle);
        return found == open_.end() ? std::nullopt : std::optional<T>(found->second);
    }
    void set(MLHandle handle, T value) {
        const std::lock_guard lock(mutex_);
        const auto found = open_.find(handle);
        if (found != open_.end())
            found->second = value;
    }
    template <typename Predicate> bool any(Predicate is) const {
        const std::lock_guard lock(mutex_);
        for (const auto &[handle, value] : open_)
            if (is(value))
                return true;
        return false;
    }
    void clear() {
        const std::lock_guard lock(mutex_);
        open_.clear();
    }

  private:
    mutable std::mutex mutex_;
    std::map<MLHandle, T> open_;
};

bool isHeadTrackerOpen(MLHandle tracker);
/** Returns true if a head tracker is initialized and tracking is not lost. */
bool isHeadPoseKnown();
extern const MLCoordinateFrameUID kHeadFrame;

/** Return the pose of a coordinate frame in the head, or none if no open tracker has the frame or it is not visible. */
std::optional<Pose> eyesInHead(const MLCoordinateFrameUID &id, int64_t mltime);
std::optional<Pose> handsInHead(const MLCoordinateFrameUID &id);

bool anyHeadTracker();
bool anyColorTracker();
bool anyEyeTracker();
bool anyHandTracker();
uint32_t openSnapshots();

void resetHeadTracking();
void resetColorTracking();
void resetEyeTracking();
void resetHandTracking();
void resetSnapshots();

} // namespace ml2sim
