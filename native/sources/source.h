/**
 * What stands behind ml2s_open: the operations of one backend's sensor.
 *
 * handles.c checks arguments, owner and state before it calls one: all come from the thread that opened, never while
 * paused (except resume, with the settings that came in the meantime, and close), and a sensor is open at most once per
 * backend, so a source keeps its state in static memory. settings are always those in force, and name the sensor. A
 * null operation is one that the sensor does not have.
 */
#pragma once

#include "../sdk/ml2s.h"
#include "frameset.h"

enum {
    SOURCE_MAX_FRAMES = 4, /**< Of one poll: the eye cameras. */
    SOURCE_MAX_POSES = 52, /**< Of one poll: 26 joints of two hands. */
};

struct source_ops {
    /** Whether the libraries and symbols that it calls are there; before open, and on its own. Any thread. */
    ml2s_result (*require)(ml2s_error *error);

    /** Begins the streams; a failure leaves nothing open. */
    ml2s_result (*open)(const ml2s_settings *settings, ml2s_error *error);

    /** Goes over to settings; after a failure the streams go on as they were. Null when only polls look at them. */
    ml2s_result (*configure)(const ml2s_settings *settings, ml2s_error *error);

    /** Adds the frames of one moment to an empty set; after a failure the caller gives them up. */
    ml2s_result (*poll)(const ml2s_settings *settings, uint64_t timeout_nanos, struct frameset *set, ml2s_error *error);

    /** Up to SOURCE_MAX_POSES poses, all fields but struct_size set. */
    ml2s_result (*poll_poses)(const ml2s_settings *settings, ml2s_pose *poses, uint32_t *count, ml2s_error *error);

    /** The rates that the device has for the streams here, where they depend on more than the device. */
    ml2s_result (*list_rates)(const ml2s_settings *settings, uint32_t *rates_hz, uint32_t capacity, uint32_t *count,
                              ml2s_error *error);

    ml2s_result (*color_pose)(const ml2s_settings *settings, int64_t device_nanos, ml2s_pose *pose, ml2s_error *error);

    /** Gives the device back; whatever it answers, the source is paused then. */
    ml2s_result (*pause)(const ml2s_settings *settings, ml2s_error *error);

    /** Begins the streams again; after a failure it is still paused. */
    ml2s_result (*resume)(const ml2s_settings *settings, ml2s_error *error);

    /** Ends everything, of a paused source too; whatever it answers, it is closed then. */
    ml2s_result (*close)(const ml2s_settings *settings, ml2s_error *error);
};

extern const struct source_ops source_depth, source_world, source_eye, source_head, source_color_pose, source_gaze,
    source_hands;

/** Of ML2S_BACKEND_OPENXR; pixels are depth, world, eye and color. */
extern const struct source_ops openxr_pixels, openxr_head, openxr_gaze, openxr_hands;
