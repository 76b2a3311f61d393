#include "perception.h"

#include <dlfcn.h>

#include "error.h"
#include "lock.h"
#include "snapshot.h"

#define NAME(name, parameters) #name,
#define NAMES(identifier, table, functions, library) static const char *const table##_names[] = {functions(NAME)};
SDK_AREAS(NAMES)

static struct {
    const char *name;
    void *loaded;
} libraries[SDK_LIBRARY_COUNT] = {
    [SDK_LIBPERCEPTION] = {"libperception.magicleap.so", NULL},
    [SDK_LIBINPUT] = {"libinput.magicleap.so", NULL},
};

static const struct area {
    enum sdk_library library;
    uint32_t offset_bytes;
    uint32_t count;
    const char *const *names;
} areas_known[SDK_AREA_COUNT] = {
#define AREA(identifier, table, functions, library)                                                                    \
    [identifier] = {library, offsetof(struct sdk, table), sizeof sdk.table / sizeof(void *), table##_names},
    SDK_AREAS(AREA)};

struct sdk sdk;
static lock_t loading = ATOMIC_FLAG_INIT;
static uint32_t loaded;

static ml2s_result load_library(enum sdk_library library, ml2s_error *error) {
    const char *name = libraries[library].name;
    if (!libraries[library].loaded && !(libraries[library].loaded = dlopen(name, RTLD_NOW | RTLD_LOCAL))) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s (%s)", name, dlerror());
    }
    return ML2S_OK;
}

static ml2s_result load_area(const struct area *area, ml2s_error *error) {
    ml2s_result result = load_library(area->library, error);
    for (uint32_t i = 0; i < area->count && !result; i++) {
        void *address = dlsym(libraries[area->library].loaded, area->names[i]);
        if (!address) {
            return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s/%s", libraries[area->library].name,
                             area->names[i]);
        }
        memcpy((char *)&sdk + area->offset_bytes + i * sizeof address, &address, sizeof address);
    }
    return result;
}

static ml2s_result load(uint32_t areas, ml2s_error *error) {
    for (uint32_t i = 0; i < SDK_AREA_COUNT; i++) {
        if (areas & ~loaded & (1u << i)) {
            ml2s_result result = load_area(&areas_known[i], error);
            if (result) {
                return result;
            }
            loaded |= 1u << i;
        }
    }
    return ML2S_OK;
}

ml2s_result sdk_require(uint32_t areas, ml2s_error *error) {
    lock(&loading);
    ml2s_result result = load(areas, error);
    unlock(&loading);
    return result;
}

static lock_t starting = ATOMIC_FLAG_INIT;
static uint32_t users;
static bool is_ours;

static void await_snapshot(void) {
    enum { MOST_WAITS = 200 };
    const struct timespec wait = {.tv_nsec = 10000000};
    for (int i = 0; i < MOST_WAITS && snapshot_touch() != MLResult_Ok; i++) {
        nanosleep(&wait, NULL);
    }
}

static ml2s_result start_ours(ml2s_error *error) {
    MLPerceptionSettings settings;
    ml2s_result result;
    if ((result = SDK_CALL(error, perception, MLPerceptionInitSettings, &settings)) ||
        (result = SDK_CALL(error, perception, MLPerceptionStartup, &settings))) {
        return result;
    }
    is_ours = true;
    await_snapshot();
    return ML2S_OK;
}

/** Checks each time, since an app that started the system may have shut it down. */
static ml2s_result start(ml2s_error *error) {
    MLResult running = snapshot_touch();
    return running == MLResult_PerceptionSystemNotStarted ? start_ours(error)
                                                          : result_of(running, "MLPerceptionGetSnapshot", error);
}

static ml2s_result shut_down(ml2s_error *error) {
    bool is_stopped_here = is_ours;
    is_ours = false;
    return is_stopped_here ? SDK_CALL(error, perception, MLPerceptionShutdown) : ML2S_OK;
}

ml2s_result perception_start(ml2s_error *error) {
    lock(&starting);
    ml2s_result result = start(error);
    if (!result) {
        users++;
    }
    unlock(&starting);
    return result;
}

static ml2s_result stop(ml2s_error *error) {
    lock(&starting);
    ml2s_result result = --users ? ML2S_OK : shut_down(error);
    unlock(&starting);
    return result;
}

ml2s_result perception_stop_on_failure(ml2s_result result, MLHandle *handle) {
    if (result) {
        *handle = ML_INVALID_HANDLE;
        stop(NULL);
    }
    return result;
}

ml2s_result perception_stop_after(ml2s_result result, MLHandle *handle, ml2s_error *error) {
    *handle = ML_INVALID_HANDLE;
    ml2s_result stopped = stop(result ? NULL : error);
    return result ? result : stopped;
}
