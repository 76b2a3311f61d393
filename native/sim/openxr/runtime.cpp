#include "runtime.h"

#include "../clock.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace ml2sim::xr {

Runtime &runtime() {
    static Runtime *one = new Runtime; // never destroyed: the loader may call during exit
    return *one;
}

void misuse(ml2sim_xr_misuse kind, XrResult result, const std::string &what) {
    ml2sim_xr_counters &counters = runtime().counters;
    ++counters.misuses[kind];
    std::snprintf(counters.last_misuse, sizeof counters.last_misuse, "%s", what.c_str());
    std::fprintf(stderr, "simulated OpenXR runtime: misuse: %s\n", what.c_str());
    throw Refusal{result};
}

void refuseIf(const char *key, XrResult result) {
    if (runtime().keys.whole(key) != 0) {
        throw Refusal{result};
    }
}

static void forget(uint64_t handle) {
    auto &objects = runtime().objects;
    std::vector<uint64_t> children;
    for (const auto &[other, object] : objects) {
        if (object->parent == handle)
            children.push_back(other);
    }
    for (const uint64_t child : children) {
        forget(child);
    }
    objects.erase(handle);
}

void destroy(uint64_t handle, const char *name) {
    const auto &objects = runtime().objects;
    const auto children = std::count_if(objects.begin(), objects.end(), [&](const auto &entry) {
        return entry.second->parent == handle && !entry.second->diesWithParent;
    });
    forget(handle);
    if (children != 0)
        misuse(ML2SIM_XR_MISUSE_CHILDREN, XR_ERROR_VALIDATION_FAILURE,
               std::string(name) + " destroyed while " + std::to_string(children) + " made from it live");
}

XrPath pathOf(const std::string &text) {
    auto &paths = runtime().paths;
    const auto found = std::find(paths.begin(), paths.end(), text);
    if (found != paths.end()) {
        return static_cast<XrPath>(found - paths.begin()) + 1;
    }
    paths.push_back(text);
    return paths.size();
}

const std::string &textOf(XrPath path) {
    if (path == XR_NULL_PATH || path > runtime().paths.size()) {
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_PATH_INVALID, "no such path");
    }
    return runtime().paths[path - 1];
}

} // namespace ml2sim::xr

using ml2sim::xr::runtime;

extern "C" const char *ml2sim_xr_set(const char *key, const char *value) {
    thread_local std::string wrong;
    std::lock_guard<std::mutex> lock(runtime().mutex);
    wrong = runtime().keys.set(key, value);
    ml2sim::wakeWaiters();
    return wrong.empty() ? nullptr : wrong.c_str();
}

extern "C" const char *ml2sim_xr_describe_keys(void) {
    thread_local std::string lines;
    std::lock_guard<std::mutex> lock(runtime().mutex);
    lines = runtime().keys.describe();
    return lines.c_str();
}

extern "C" void ml2sim_xr_reset(void) {
    std::lock_guard<std::mutex> lock(runtime().mutex);
    ml2sim::xr::resetKeys(runtime().keys);
    runtime().objects.clear();
    runtime().extensions.clear();
    runtime().events.clear();
    runtime().counters = {};
    ml2sim::wakeWaiters();
}

extern "C" void ml2sim_xr_get_counters(ml2sim_xr_counters *out) {
    std::lock_guard<std::mutex> lock(runtime().mutex);
    *out = runtime().counters;
    out->live_objects = static_cast<uint32_t>(runtime().objects.size());
}
