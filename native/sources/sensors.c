// The table of sensors.
#include <stddef.h>

#include "../sdk/error.h"
#include "../sdk/tables.h"
#include "sensors.h"

#define BIT(stream) ML2S_STREAM_BIT(ML2S_STREAM_##stream)
const struct sensor sensors[1 << SENSOR_BITS] = {
    [ML2S_SENSOR_DEPTH] = {"depth", BIT(DEPTH) | BIT(INFRA), &source_depth, &openxr_pixels},
    [ML2S_SENSOR_WORLD] = {"world", BIT(WORLD_CENTER) | BIT(WORLD_LEFT) | BIT(WORLD_RIGHT), &source_world,
                           &openxr_pixels},
    [ML2S_SENSOR_EYE] = {"eye",
                         BIT(EYE_NASAL_LEFT) | BIT(EYE_NASAL_RIGHT) | BIT(EYE_TEMPLE_LEFT) | BIT(EYE_TEMPLE_RIGHT),
                         &source_eye, &openxr_pixels},
    [ML2S_SENSOR_HEAD] = {"head", BIT(HEAD_POSE), &source_head, &openxr_head},
    [ML2S_SENSOR_COLOR] = {"color", BIT(COLOR) | BIT(MIXED_REALITY), &source_color_pose, &openxr_pixels},
    [ML2S_SENSOR_GAZE] = {"gaze", BIT(GAZE), &source_gaze, &openxr_action_pose},
    [ML2S_SENSOR_HANDS] = {"hands", BIT(HAND_LEFT) | BIT(HAND_RIGHT), &source_hands, &openxr_hands},
    [ML2S_SENSOR_CONTROLLER] = {"controller", BIT(CONTROLLER), &source_controller, &openxr_action_pose},
    [ML2S_SENSOR_CONTROLLER_INPUT] = {"controller input", BIT(CONTROLLER_JOY), &source_controller_input,
                                      &openxr_controller_input},
    [ML2S_SENSOR_MARKERS] = {"markers", BIT(MARKERS), NULL, &openxr_markers},
    [ML2S_SENSOR_MAP] = {"map", BIT(MAP), NULL, &openxr_map},
};

ml2s_result sensor_find_ops(uint32_t sensor, uint32_t backend, const struct source_ops **ops, ml2s_error *error) {
    if (sensor >= sizeof sensors / sizeof *sensors || !sensors[sensor].name) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "unknown sensor %u", sensor);
    }
    if (backend > ML2S_BACKEND_OPENXR) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: unknown backend %u", sensors[sensor].name, backend);
    }
    *ops = backend == ML2S_BACKEND_SDK ? sensors[sensor].sdk : sensors[sensor].openxr;
    return *ops ? ML2S_OK
                : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s (the backend is openxr)",
                            sensors[sensor].name);
}

ml2s_result source_require(const struct source_ops *ops, ml2s_error *error) {
    return ops->require ? ops->require(error) : sdk_require(ops->areas, error);
}

ml2s_result ml2s_check(uint32_t sensor, uint32_t backend, ml2s_error *error) {
    const struct source_ops *ops;
    ml2s_result result = error_is_valid(error) ? sensor_find_ops(sensor, backend, &ops, error) : ML2S_INVALID_ARGUMENT;
    return result ? result : source_require(ops, error);
}
