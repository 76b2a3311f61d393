// The state of the simulated runtime, and the checks that its entry points share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "keys.h"
#include "ml2sim_xr.h"
#include "openxr_headers.h"

namespace ml2sim::xr {

/// An object with a handle. It exists until its handle is destroyed; its parent is the handle it was created from.
struct Object {
    uint64_t parent = 0;
    bool diesWithParent = false; ///< Its end with the parent is no misuse.
    virtual ~Object() = default;
};

/// Ends an entry point with an error; thrown and caught inside the runtime only.
struct Refusal {
    XrResult result;
};

/// The one runtime of the process. Everything in it is guarded by `mutex`, which every entry point holds.
struct Runtime {
    Runtime() { resetKeys(keys); }

    std::mutex mutex;
    KeyTable keys = declareKeys();
    ml2sim_xr_counters counters{};
    std::map<uint64_t, std::unique_ptr<Object>> objects;
    std::set<std::string> extensions;
    std::vector<std::string> paths;
    std::deque<XrEventDataBuffer> events;
    uint64_t nextHandle = 0x10001;
};

Runtime &runtime();

/// Adds an event to the runtime's queue.
template <class Event> void post(const Event &event) {
    XrEventDataBuffer buffer{};
    static_assert(sizeof event <= sizeof buffer);
    std::memcpy(&buffer, &event, sizeof event);
    runtime().events.push_back(buffer);
}

/// Counts and logs a misuse, then refuses the call.
[[noreturn]] void misuse(ml2sim_xr_misuse kind, XrResult result, const std::string &what);

/// Refuses when the fault `key` is set.
void refuseIf(const char *key, XrResult result);

/// Runs the body of an entry point under the runtime's mutex. A body that returns nothing succeeds.
template <class Body> XrResult entry(Body body) {
    std::unique_lock<std::mutex> lock(runtime().mutex);
    try {
        if constexpr (std::is_void_v<decltype(body(lock))>)
            return body(lock), XR_SUCCESS;
        else
            return body(lock);
    } catch (const Refusal &refusal) {
        return refusal.result;
    }
}

template <class Structure>
const Structure &requireType(const Structure *structure, XrStructureType type, const char *name) {
    if (structure == nullptr) {
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, std::string(name) + " is null");
    }
    if (structure->type != type) {
        misuse(ML2SIM_XR_MISUSE_TYPE, XR_ERROR_VALIDATION_FAILURE,
               std::string(name) + " has type " + std::to_string(structure->type) + ", expected " +
                   std::to_string(type));
    }
    return *structure;
}

template <class Structure> Structure &requireType(Structure *structure, XrStructureType type, const char *name) {
    return const_cast<Structure &>(requireType(static_cast<const Structure *>(structure), type, name));
}

template <class Pointer> Pointer &requireNonNull(Pointer *pointer, const char *name) {
    if (pointer == nullptr) {
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, std::string(name) + " is null");
    }
    return *pointer;
}

template <class Handle> uint64_t number(Handle handle) { return reinterpret_cast<uint64_t>(handle); }

template <class Kind, class Handle> Kind &find(Handle handle, const char *name) {
    const auto found = runtime().objects.find(number(handle));
    auto *object = found == runtime().objects.end() ? nullptr : dynamic_cast<Kind *>(found->second.get());
    if (object == nullptr) {
        misuse(ML2SIM_XR_MISUSE_HANDLE, XR_ERROR_HANDLE_INVALID, std::string("no such ") + name);
    }
    return *object;
}

/// Registers an object and returns its handle.
template <class Handle> Handle registerObject(uint64_t parent, std::unique_ptr<Object> object) {
    object->parent = parent;
    const uint64_t handle = runtime().nextHandle++;
    runtime().objects[handle] = std::move(object);
    return reinterpret_cast<Handle>(handle);
}

/// Destroys an object and its children. Children that do not die with their parent are a misuse.
void destroy(uint64_t handle, const char *name);

/// Destroys the object of a handle if it is a Kind; a whole entry point.
template <class Kind, class Handle> XrResult destroyHandle(Handle handle, const char *name) {
    return entry([&](auto &) {
        find<Kind>(handle, name);
        destroy(number(handle), name);
    });
}

/// Implements OpenXR's two-call idiom: writes the count, and the values if capacity suffices.
template <class Value>
XrResult enumerate(const std::vector<Value> &from, uint32_t capacity, uint32_t *count, Value *values) {
    requireNonNull(count, "count") = static_cast<uint32_t>(from.size());
    if (capacity == 0) {
        return XR_SUCCESS;
    }
    if (capacity < from.size()) {
        return XR_ERROR_SIZE_INSUFFICIENT;
    }
    std::copy(from.begin(), from.end(), &requireNonNull(values, "values"));
    return XR_SUCCESS;
}

XrPath pathOf(const std::string &text);
const std::string &textOf(XrPath path);

struct Instance : Object {};

} // namespace ml2sim::xr
