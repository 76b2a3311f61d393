// The perception system as its parts see it: whether it runs, and who has handles of it.
#pragma once

#include <map>
#include <mutex>
#include <optional>

#include "ml_perception.h"
#include "scene/geometry.h"

namespace ml2sim {

bool isPerceptionStarted();

/** Whether snapshots can be had, which takes a moment after the start. */
bool hasSnapshots();

/** A first snapshot was got: trackers can be created from now on. */
void enterFirstSnapshot();

/** Why a tracker cannot be created now, or Ok. */
MLResult canCreateTracker();

/** Open handles of one kind, with what each has. Any thread. */
template <typename T> class Handles {
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
/** Whether some tracker is done initializing and the headset knows where it is. */
bool isHeadPoseKnown();
extern const MLCoordinateFrameUID kHeadFrame;

/** What a coordinate frame of an open tracker is of, in the head; none when it is no such frame, or not seen. */
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
