/**
 * The operations of a sensor with one backend, called by the functions of handles.c.
 *
 * handles.c checks arguments, thread and state first. All calls come from the thread that opened the sensor. A sensor
 * is open at most once per backend, so a source keeps its state in static memory. settings are always the current ones.
 * An operation that a sensor does not have is null.
 */
#pragma once

#include "../sdk/ml2s.h"
#include "frameset.h"

enum { SOURCE_MAX_FRAMES = 4 }; /**< Frames of one poll: four eye cameras. */

/** The memory for the readings of one poll. It belongs to the caller, whose structures can be larger. */
struct readings {
    uint8_t *memory;
    uint32_t struct_size, capacity, count;
};

/** Adds a reading with all fields except struct_size, if there is room. */
void readings_add(struct readings *readings, const ml2s_reading *reading);

struct source_ops {
    /** Checks that libraries and symbols exist. Called before open, and alone. Thread-safe. Null: the SDK's areas. */
    ml2s_result (*require)(ml2s_error *error);

    uint32_t areas; /**< The areas of the vendor's SDK that the source needs. */

    /** Starts the streams. After a failure nothing is open. */
    ml2s_result (*open)(const ml2s_settings *settings, ml2s_error *error);

    /**
     * Applies settings. After a failure the streams continue unchanged, or else each poll fails until close. Null if
     * only polls use the settings.
     */
    ml2s_result (*configure)(const ml2s_settings *settings, ml2s_error *error);

    /** Adds the frames of one capture to an empty set. After a failure the caller releases them. */
    ml2s_result (*poll)(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set, ml2s_error *error);

    /** Adds the current readings. After a failure the caller uses none. */
    ml2s_result (*poll_readings)(const ml2s_settings *settings, struct readings *readings, ml2s_error *error);

    /** Returns the rates of the streams, for sensors where they depend on the place. */
    ml2s_result (*list_rates)(const ml2s_settings *settings, uint32_t *rates_hz, uint32_t capacity, uint32_t *count,
                              ml2s_error *error);

    ml2s_result (*color_pose)(const ml2s_settings *settings, int64_t device_nanos, ml2s_reading *pose,
                              ml2s_error *error);

    /** Closes the source. It is closed afterwards, also after a failure. */
    ml2s_result (*close)(const ml2s_settings *settings, ml2s_error *error);
};

extern const struct source_ops source_depth, source_world, source_eye, source_head, source_color_pose, source_gaze,
    source_hands, source_controller, source_controller_input;

/** Sources of ML2S_BACKEND_OPENXR: pixels are depth, world, eye and color, action_pose is gaze and controller. */
extern const struct source_ops openxr_pixels, openxr_head, openxr_action_pose, openxr_hands, openxr_controller_input,
    openxr_markers, openxr_map;
