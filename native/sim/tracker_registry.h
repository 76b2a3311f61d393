// The open trackers of one kind: creation, destruction and checks that all kinds share.
#pragma once

#include <map>
#include <mutex>
#include <optional>

#include "camera_connection.h"
#include "counters.h"
#include "perception.h"

namespace ml2sim {

/** A value of type T for each open tracker. Thread-safe. */
template <typename T> class TrackerRegistry {
  public:
    /** Creates a tracker. Returns `denied` if the fault is on, or why no tracker can be created now. */
    MLResult create(const char *function, MLHandle *out, Key fault, MLResult denied, T value = {}) {
        if (out != nullptr)
            *out = ML_INVALID_HANDLE;
        if (const auto result = out == nullptr ? MLResult_Ok : canCreateTracker())
            return result;
        return createAnytime(function, out, fault, denied, value);
    }

    /** As create, of a tracker that does not need the perception system. */
    MLResult createAnytime(const char *function, MLHandle *out, Key fault, MLResult denied, T value = {}) {
        passHold(function);
        if (out == nullptr)
            return refuseArgument(function, "the pointer to the handle is null");
        *out = ML_INVALID_HANDLE;
        if (isOn(fault))
            return denied;
        *out = newHandle();
        const std::lock_guard lock(mutex_);
        open_.emplace(*out, value);
        adjust(Counter::Handles, 1);
        return MLResult_Ok;
    }

    MLResult destroy(const char *function, MLHandle handle) {
        const auto value = find(function, handle);
        const std::lock_guard lock(mutex_);
        if (open_.erase(handle) == 1)
            adjust(Counter::Handles, -1);
        return value ? MLResult_Ok : MLResult_InvalidParam;
    }

    /** Returns the value of an open tracker; counts a misuse if the handle is not open. */
    std::optional<T> find(const char *function, MLHandle handle) const {
        passHold(function);
        std::unique_lock lock(mutex_);
        const auto found = open_.find(handle);
        if (found != open_.end())
            return found->second;
        lock.unlock();
        misuse(ML2SIM_MISUSE_HANDLE, "%s: handle %#lx is not open", function, handle);
        return std::nullopt;
    }

    MLResult check(const char *function, MLHandle handle) const {
        return find(function, handle) ? MLResult_Ok : MLResult_InvalidParam;
    }

    void set(MLHandle handle, T value) {
        const std::lock_guard lock(mutex_);
        if (const auto found = open_.find(handle); found != open_.end())
            found->second = value;
    }

    template <typename Predicate> bool any(Predicate is) const {
        const std::lock_guard lock(mutex_);
        for (const auto &[handle, value] : open_)
            if (is(value))
                return true;
        return false;
    }

    size_t count() const {
        const std::lock_guard lock(mutex_);
        return open_.size();
    }

    bool isEmpty() const { return count() == 0; }

    void clear() {
        const std::lock_guard lock(mutex_);
        open_.clear();
    }

  private:
    mutable std::mutex mutex_;
    std::map<MLHandle, T> open_;
};

/** The value of a tracker that has no state. */
struct NoState {};

} // namespace ml2sim
