// The map in which the headset is localized, one at a time.
#include <string.h>

#include "../sdk/error.h"
#include "../sources/source.h"
#include "events.h"
#include "poses.h"
#include "runtime.h"

enum { MOST_MAPS = 64, UUID_LENGTH = 36 };

/** The map that settings ask for. */
static struct {
    bool is_any; /**< True without a wish. */
    bool was_asked_for;
    XrUuidEXT uuid;
} wanted;
static XrSpace origin;

/** Writes 8-4-4-4-12 digits and a zero. */
static void write_uuid(const XrUuidEXT *uuid, char text[UUID_LENGTH + 1]) {
    for (uint32_t i = 0; i < sizeof uuid->data; i++) {
        if (i == 4 || i == 6 || i == 8 || i == 10) {
            *text++ = '-';
        }
        *text++ = "0123456789abcdef"[uuid->data[i] >> 4];
        *text++ = "0123456789abcdef"[uuid->data[i] & 15];
    }
    *text = 0;
}

/** Returns true if both texts are equal but for the case of their letters. */
static bool is_same_uuid(const char *one, const char *other) {
    while (*one && (*one | 0x20) == (*other | 0x20)) {
        one++, other++;
    }
    return !*one && !*other;
}

static bool is_called(const XrLocalizationMapML *map, const char *wanted_name) {
    char uuid[UUID_LENGTH + 1];
    write_uuid(&map->mapUuid, uuid);
    return !strcmp(map->name, wanted_name) || is_same_uuid(uuid, wanted_name);
}

/** Reports that the map asked for is not one of the headset's, or several of them, and lists those. */
static ml2s_result refuse(const char *name, const XrLocalizationMapML *maps, uint32_t count, uint32_t found,
                          ml2s_error *error) {
    char list[sizeof error->message] = "";
    size_t length = 0;
    for (uint32_t i = 0; i < count; i++) {
        size_t name_length = strlen(maps[i].name);
        bool is_listed = !found || is_called(&maps[i], name);
        if (is_listed && length + name_length + UUID_LENGTH + 4 < sizeof list) {
            list[length] = length ? ',' : ':';
            list[length + 1] = ' ';
            length += 2;
            write_uuid(&maps[i].mapUuid, list + length);
            length += UUID_LENGTH;
            if (!found) {
                list[length++] = ' ';
                memcpy(list + length, maps[i].name, name_length + 1);
                length += name_length;
            }
        }
    }
    return found ? error_set(error, ML2S_INVALID_ARGUMENT, 0, "%u maps are called \"%s\", expected the UUID of one%s",
                             found, name, list)
                 : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: map \"%s\"; the headset has %u%s", name,
                             count, list);
}

/** Takes over the wish of the settings. After a failure the one before stays. */
static ml2s_result find_map(const ml2s_settings *settings, ml2s_error *error) {
    static XrLocalizationMapML maps[MOST_MAPS];
    const char *name = settings->map;
    if (!name[0]) {
        wanted.is_any = true;
        return ML2S_OK;
    }
    if (name[sizeof settings->map - 1]) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "ml2s_settings.map: expected at most 63 bytes");
    }
    for (uint32_t i = 0; i < MOST_MAPS; i++) {
        maps[i] = (XrLocalizationMapML){.type = XR_TYPE_LOCALIZATION_MAP_ML};
    }
    uint32_t count = 0, found = 0, last = 0;
    ml2s_result result = XR_CALL(error, map, xrQueryLocalizationMapsML, xr.session, NULL, MOST_MAPS, &count, maps);
    for (uint32_t i = 0; i < count && !result; i++) {
        maps[i].name[sizeof maps[i].name - 1] = 0; // whatever the runtime wrote
        if (is_called(&maps[i], name)) {
            last = i;
            found++;
        }
    }
    if (result || found != 1) {
        return result ? result : refuse(name, maps, count, found, error);
    }
    wanted.is_any = wanted.was_asked_for = false;
    wanted.uuid = maps[last].mapUuid;
    return ML2S_OK;
}

static ml2s_result prepare(const ml2s_settings *settings, ml2s_error *error) {
    if (xr.is_borrowed) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0,
                         "not available: the map in an OpenXR session of the app, which gets the events of it");
    }
    ml2s_result result = find_map(settings, error);
    XrReferenceSpaceCreateInfo info = {XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       NULL,
                                       XR_REFERENCE_SPACE_TYPE_LOCALIZATION_MAP_ML,
                                       {{0, 0, 0, 1}, {0, 0, 0}}};
    return result ? result : XR_CALL(error, core, xrCreateReferenceSpace, xr.session, &info, &origin);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_MAP), prepare, settings, error);
}

static ml2s_result ask(ml2s_error *error) {
    XrMapLocalizationRequestInfoML info = {XR_TYPE_MAP_LOCALIZATION_REQUEST_INFO_ML, NULL, wanted.uuid};
    wanted.was_asked_for = true;
    return XR_CALL(error, map, xrRequestMapLocalizationML, xr.session, &info);
}

/** Returns true if poses in the map are those that the settings ask for. */
static bool is_trusted(const XrEventDataLocalizationChangedML *event, const ml2s_settings *settings) {
    return event->state == XR_LOCALIZATION_MAP_STATE_LOCALIZED_ML &&
           (uint32_t)event->confidence >= settings->map_confidence &&
           (wanted.is_any || !memcmp(&event->map.mapUuid, &wanted.uuid, sizeof wanted.uuid));
}

static void write_state(XrEventDataLocalizationChangedML *event, ml2s_reading *reading) {
    event->map.name[sizeof event->map.name - 1] = 0; // whatever the runtime wrote
    reading->values[ML2S_MAP_STATE] = (float)event->state;
    reading->values[ML2S_MAP_CONFIDENCE] = (float)event->confidence;
    reading->values[ML2S_MAP_ERRORS] = (float)event->errorFlags;
    reading->values[ML2S_MAP_TYPE] = (float)event->map.mapType;
    if (event->map.name[0]) {
        size_t length = strlen(event->map.name);
        write_uuid(&event->map.mapUuid, reading->name);
        reading->name[UUID_LENGTH] = ' ';
        memcpy(reading->name + UUID_LENGTH + 1, event->map.name, length + 1);
    }
}

static ml2s_result poll_readings(const ml2s_settings *settings, struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    XrPosef pose;
    bool is_tracked;
    latest_event latest;
    ml2s_result result = poses_now(&now, error);
    // The events that come after the pose tell of another map before its origin is taken for that of this one.
    if (result || (result = poses_locate(origin, now.time, &pose, &is_tracked, error)) ||
        (result = xr_handle_events(error))) {
        return result;
    }
    result = events_latest(XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML, &latest, error);
    bool has_event = !result;
    if (has_event && !wanted.is_any && !wanted.was_asked_for) {
        result = ask(error);
    }
    if (result && result != ML2S_TIMEOUT) {
        return result;
    }
    ml2s_reading reading;
    poses_fill(&reading, ML2S_STREAM_MAP, &now, &pose,
               is_tracked && has_event && is_trusted(&latest.localization, settings));
    reading.values[ML2S_MAP_STATE] = -1;
    if (has_event) {
        write_state(&latest.localization, &reading);
    }
    readings_add(readings, &reading);
    return ML2S_OK;
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    ml2s_result result = XR_CALL(error, core, xrDestroySpace, origin);
    origin = XR_NULL_HANDLE;
    return xr_end(result, error);
}

const struct source_ops openxr_map = {
    .require = xr_require, .open = begin, .configure = find_map, .poll_readings = poll_readings, .close = end};
