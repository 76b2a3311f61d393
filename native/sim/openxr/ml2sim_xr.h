/**
 * Control and books of the OpenXR runtime in the simulated headset: libperception.magicleap.so is a runtime as well,
 * which the Khronos loader finds by the manifest openxr_runtime.json.
 *
 * It shows the head, the cameras and the pictures of ml2sim.h: XrTime is MLTime, and LOCAL is the world of the current
 * head tracking session.
 *
 * **Strict.** A wrong structure type, a handle that is not alive, a call out of order, a function whose extension is
 * not enabled: refused with the error that OpenXR names for it, told on stderr and counted. **Threads**: any.
 */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ML2SIM_XR_API __attribute__((visibility("default")))

/**
 * Sets a key of ml2sim_xr_describe_keys, at any time. The variable ML2SIM_XR of the environment, "key=value,key=value",
 * is read so when the library is loaded; a mistake in it aborts. Returns null, or what is wrong and what is allowed.
 */
ML2SIM_XR_API const char *ml2sim_xr_set(const char *key, const char *value);

/** One line for each key, with the columns of ml2sim_describe_keys. Valid until this thread's next call. */
ML2SIM_XR_API const char *ml2sim_xr_describe_keys(void);

/** All keys as at the start, everything that is open forgotten, books empty. */
ML2SIM_XR_API void ml2sim_xr_reset(void);

typedef enum ml2sim_xr_misuse {
    ML2SIM_XR_MISUSE_TYPE = 0,      /**< A structure with another type than the call takes, or chained wrongly. */
    ML2SIM_XR_MISUSE_HANDLE = 1,    /**< A handle that was never given or is destroyed. */
    ML2SIM_XR_MISUSE_ORDER = 2,     /**< Data before start, configured while running, destroyed while running. */
    ML2SIM_XR_MISUSE_FUTURE = 3,    /**< A future that is unknown, of another call, or completed before. */
    ML2SIM_XR_MISUSE_CHILDREN = 4,  /**< Destroyed while something made from it lives. */
    ML2SIM_XR_MISUSE_ARGUMENT = 5,  /**< Null, a value that is not offered, a path that does not exist. */
    ML2SIM_XR_MISUSE_EXTENSION = 6, /**< Asked for a function of an extension that is not enabled. */
    ML2SIM_XR_MISUSE_THREAD = 7,    /**< Data of one sensor fetched by two threads at once. */
    ML2SIM_XR_MISUSE_COUNT = 8,
} ml2sim_xr_misuse;

/** What lives and what was done wrong. No object alive and no misuse is a perfect program's end. */
typedef struct ml2sim_xr_book {
    uint32_t instances_created;
    uint32_t sessions_created;
    uint32_t live_objects; /**< Instances, sessions, spaces, sensors, futures, action sets, actions, hand trackers. */
    uint32_t frames_delivered;
    uint32_t misuses[ML2SIM_XR_MISUSE_COUNT]; /**< By ml2sim_xr_misuse. */
    char last_misuse[240];                    /**< Empty when there was none. */
} ml2sim_xr_book;

ML2SIM_XR_API void ml2sim_xr_books(ml2sim_xr_book *out);

#ifdef __cplusplus
}
#endif
