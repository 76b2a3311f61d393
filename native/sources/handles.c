// Handles, and the checks that all calls with a handle share.
#define _GNU_SOURCE
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#include "../sdk/clock.h"
#include "../sdk/error.h"
#include "frame.h"
#include "sensors.h"

enum { INDEX_BITS = SENSOR_BITS + 1 };

/** One handle per sensor and backend. Only id, owner and is_taken are used by other threads than the owner. */
static struct handle {
    _Atomic ml2s_handle id; /**< 0: closed. */
    _Atomic pid_t owner;
    atomic_bool is_taken;
    const struct source_ops *ops;
    ml2s_settings settings;
    uint32_t unusable_captures; /**< Captures in a row without a usable frame. */
    ml2s_error last_failure;    /**< The failure of the last of them. */
} handles[1 << INDEX_BITS];

static _Atomic uint64_t generation;

uint32_t ml2s_abi_version(void) { return ML2S_ABI_VERSION; }

static ml2s_result find(ml2s_handle id, struct handle **out, ml2s_error *error) {
    if (!error_is_valid(error)) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct handle *handle = &handles[id % (1 << INDEX_BITS)];
    if (!id || atomic_load(&handle->id) != id) {
        return error_set(error, ML2S_CLOSED, 0, "the handle is closed");
    }
    if (atomic_load(&handle->owner) != gettid()) {
        return error_set(error, ML2S_WRONG_THREAD, 0, "the handle was opened by thread %d, but used by thread %d",
                         atomic_load(&handle->owner), gettid());
    }
    *out = handle;
    return ML2S_OK;
}

/** Checks settings, and copies them with 0 for what an older caller does not know. */
static ml2s_result check(const ml2s_settings *given, ml2s_settings *settings, const struct source_ops **ops,
                         ml2s_error *error) {
    if (!error_is_valid(error) || !given || given->struct_size < offsetof(ml2s_settings, marker_type)) {
        return error_set(error_is_valid(error) ? error : NULL, ML2S_INVALID_ARGUMENT, 0,
                         "settings: struct_size is smaller than the structure, or settings is null");
    }
    *settings = (ml2s_settings){0};
    memcpy(settings, given, given->struct_size < sizeof *settings ? given->struct_size : sizeof *settings);
    ml2s_result result = sensor_find_ops(settings->sensor, settings->backend, ops, error);
    if (result) {
        return result;
    }
    const struct sensor *sensor = &sensors[settings->sensor];
    if (!settings->streams || settings->streams & ~sensor->streams || settings->second_streams & ~settings->streams) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "%s: streams 0x%x or second_streams 0x%x are not of this sensor", sensor->name,
                         (uint32_t)settings->streams, (uint32_t)settings->second_streams);
    }
    return ML2S_OK;
}

ml2s_result ml2s_open(const ml2s_settings *given, ml2s_handle *out, ml2s_error *error) {
    const struct source_ops *ops;
    ml2s_settings settings;
    ml2s_result result = check(given, &settings, &ops, error);
    if (result || !out) {
        return result ? result : error_set(error, ML2S_INVALID_ARGUMENT, 0, "ml2s_open: out is null");
    }
    if ((result = source_require(ops, error))) {
        return result;
    }
    const struct sensor *sensor = &sensors[settings.sensor];
    uint32_t index = settings.backend << SENSOR_BITS | settings.sensor;
    struct handle *handle = &handles[index];
    if (atomic_exchange(&handle->is_taken, true)) {
        return error_set(error, ML2S_BUSY, 0, "the sensor %s is open already: close it first", sensor->name);
    }
    handle->ops = ops;
    handle->settings = settings;
    handle->unusable_captures = 0;
    handle->last_failure = (ml2s_error){.struct_size = sizeof(ml2s_error)};
    clock_resample();
    frameset_forget_sizes(settings.streams);
    result = handle->ops->open(&handle->settings, error);
    if (result) {
        atomic_store(&handle->is_taken, false);
        return result;
    }
    *out = (atomic_fetch_add(&generation, 1) + 1) << INDEX_BITS | index;
    atomic_store(&handle->owner, gettid());
    atomic_store(&handle->id, *out);
    return ML2S_OK;
}

ml2s_result ml2s_configure(ml2s_handle id, const ml2s_settings *given, ml2s_error *error) {
    struct handle *handle;
    const struct source_ops *ops;
    ml2s_settings settings;
    ml2s_result result = find(id, &handle, error);
    if (result || (result = check(given, &settings, &ops, error))) {
        return result;
    }
    if (settings.sensor != handle->settings.sensor || settings.backend != handle->settings.backend) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_configure: the sensor or backend differs from that of the handle; open another one");
    }
    result = handle->ops->configure ? handle->ops->configure(&settings, error) : ML2S_OK;
    if (!result) {
        handle->settings = settings;
    }
    return result;
}

void readings_add(struct readings *readings, const ml2s_reading *reading) {
    if (readings->count < readings->capacity) {
        uint8_t *structure = readings->memory + (size_t)readings->count++ * readings->struct_size;
        memcpy(structure, reading, sizeof *reading);
        memcpy(structure, &readings->struct_size, sizeof readings->struct_size);
    }
}

/** Copies count structures of size bytes into those of the caller, which can be larger. */
static void copy_out(void *to, const void *from, uint32_t size, uint32_t count) {
    uint32_t caller_size = *(const uint32_t *)to;
    for (uint32_t i = 0; i < count; i++) {
        uint8_t *structure = (uint8_t *)to + (size_t)i * caller_size;
        memcpy(structure, (const uint8_t *)from + (size_t)i * size, size);
        memcpy(structure, &caller_size, sizeof caller_size);
    }
}

ml2s_result ml2s_poll(ml2s_handle id, uint64_t timeout_nanos, ml2s_frame *frames, uint32_t capacity, uint32_t *count,
                      ml2s_error *error) {
    struct handle *handle;
    ml2s_result result = find(id, &handle, error);
    if (result) {
        return result;
    }
    if (!handle->ops->poll || !frames || !capacity || !count || frames->struct_size < sizeof *frames) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_poll: the sensor gives no frames, or frames, capacity or count is 0");
    }
    *count = 0;
    if (handle->unusable_captures == ML2S_MOST_UNUSABLE_CAPTURES) {
        handle->unusable_captures = 0;
        return error_set(error, ML2S_VENDOR_FAILURE, handle->last_failure.vendor_code,
                         "%u captures in a row without a usable frame, the last: %s", ML2S_MOST_UNUSABLE_CAPTURES,
                         handle->last_failure.message);
    }
    ml2s_frame captured[SOURCE_MAX_FRAMES];
    struct frameset set = {.frames = captured, .streams = handle->settings.streams};
    result = handle->ops->poll(&handle->settings, timeout_nanos, &set, &handle->last_failure);
    if (result) {
        frames_release(captured, set.count);
        return result == ML2S_TIMEOUT
                   ? result
                   : error_set(error, result, handle->last_failure.vendor_code, "%s", handle->last_failure.message);
    }
    bool any_usable = frameset_finish(&set);
    handle->unusable_captures = any_usable ? 0 : handle->unusable_captures + (set.count != 0);
    *count = set.count < capacity ? set.count : capacity;
    copy_out(frames, captured, sizeof *captured, *count);
    frames_release(captured + *count, set.count - *count);
    return set.count ? ML2S_OK : ML2S_TIMEOUT;
}

ml2s_result ml2s_poll_readings(ml2s_handle id, ml2s_reading *readings, uint32_t capacity, uint32_t *count,
                               ml2s_error *error) {
    struct handle *handle;
    ml2s_result result = find(id, &handle, error);
    if (result) {
        return result;
    }
    if (!handle->ops->poll_readings || !readings || !capacity || !count || readings->struct_size < sizeof *readings) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_poll_readings: the sensor gives frames, or readings, capacity or count is 0");
    }
    struct readings found = {(uint8_t *)readings, readings->struct_size, capacity, 0};
    result = handle->ops->poll_readings(&handle->settings, &found, error);
    *count = result ? 0 : found.count;
    return result;
}

ml2s_result ml2s_color_pose(ml2s_handle id, int64_t device_nanos, ml2s_reading *pose, ml2s_error *error) {
    struct handle *handle;
    ml2s_result result = find(id, &handle, error);
    if (result) {
        return result;
    }
    if (!handle->ops->color_pose || !pose || pose->struct_size < sizeof *pose) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_color_pose: the sensor gives no colour pose, or pose is null");
    }
    ml2s_reading found;
    result = handle->ops->color_pose(&handle->settings, device_nanos, &found, error);
    if (!result) {
        readings_add(&(struct readings){(uint8_t *)pose, pose->struct_size, 1, 0}, &found);
    }
    return result;
}

ml2s_result ml2s_list_rates(ml2s_handle id, uint32_t *rates_hz, uint32_t capacity, uint32_t *count, ml2s_error *error) {
    struct handle *handle;
    ml2s_result result = find(id, &handle, error);
    if (result) {
        return result;
    }
    if (!handle->ops->list_rates || !rates_hz || !count) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_list_rates: the sensor lists no rates, or rates_hz or count is null");
    }
    *count = 0;
    return handle->ops->list_rates(&handle->settings, rates_hz, capacity, count, error);
}

ml2s_result ml2s_close(ml2s_handle id, ml2s_error *error) {
    struct handle *handle;
    ml2s_result result = find(id, &handle, error);
    if (result) {
        return result;
    }
    atomic_store(&handle->id, 0);
    result = handle->ops->close(&handle->settings, error);
    atomic_store(&handle->is_taken, false);
    return result;
}
