/**
 * Controls the OpenXR runtime of the simulated headset. libperception.magicleap.so is the runtime; the Khronos loader
 * finds it by the manifest openxr_runtime.json. Head, cameras and images are those of ml2sim.h. XrTime is MLTime. LOCAL
 * is the world of the current head tracking session.
 *
 * **Strict.** The runtime refuses a wrong structure type, an invalid handle, a call out of order, and a function whose
 * extension is not enabled. It returns the error that OpenXR specifies, logs the misuse to stderr and counts it.
 *
 * **Threads.** Every function is thread-safe.
 */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ML2SIM_XR_API __attribute__((visibility("default")))

/**
 * Sets a key of ml2sim_xr_describe_keys. Returns null, or an error that names the allowed values. Keys can be set at
 * any time. The environment variable ML2SIM_XR, "key=value,key=value", is read when the library is loaded; the process
 * aborts if it has a mistake.
 */
ML2SIM_XR_API const char *ml2sim_xr_set(const char *key, const char *value);

/** One line for each key, with the columns of ml2sim_describe_keys. Valid until this thread's next call. */
ML2SIM_XR_API const char *ml2sim_xr_describe_keys(void);

/** Resets all keys and counters, and destroys all objects. */
ML2SIM_XR_API void ml2sim_xr_reset(void);

typedef enum ml2sim_xr_misuse {
    ML2SIM_XR_MISUSE_TYPE = 0,      /**< A structure with another type than the call takes, or chained wrongly. */
    ML2SIM_XR_MISUSE_HANDLE = 1,    /**< A handle that does not exist or is destroyed. */
    ML2SIM_XR_MISUSE_ORDER = 2,     /**< Data before start, configured while running, destroyed while running. */
    ML2SIM_XR_MISUSE_FUTURE = 3,    /**< A future that is unknown, of another call, or completed before. */
    ML2SIM_XR_MISUSE_CHILDREN = 4,  /**< Destroyed before its children. */
    ML2SIM_XR_MISUSE_ARGUMENT = 5,  /**< Null, a value that is not offered, a path that does not exist. */
    ML2SIM_XR_MISUSE_EXTENSION = 6, /**< A function of an extension that is not enabled. */
    ML2SIM_XR_MISUSE_THREAD = 7,    /**< Data of one sensor fetched by two threads at once. */
    ML2SIM_XR_MISUSE_COUNT = 8,
} ml2sim_xr_misuse;

/** Objects that exist, and misuses. A correct program ends with no object and no misuse. */
typedef struct ml2sim_xr_counters {
    uint32_t instances_created;
    uint32_t sessions_created;
    uint32_t live_objects; /**< Instances, sessions, spaces, sensors, futures, action sets, actions, hand trackers. */
    uint32_t frames_delivered;
    uint32_t futures_cancelled;
    uint32_t misuses[ML2SIM_XR_MISUSE_COUNT]; /**< By ml2sim_xr_misuse. */
    char last_misuse[240];                    /**< Empty when there was none. */
} ml2sim_xr_counters;

ML2SIM_XR_API void ml2sim_xr_get_counters(ml2sim_xr_counters *out);

#ifdef __cplusplus
}
#endif
