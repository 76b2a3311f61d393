/**
 * The vendor's libperception.magicleap.so, reached without linking to it. Any thread.
 */
#pragma once

#include "ml2s.h"
#include "ml_depth_camera.h"
#include "ml_eye_camera.h"
#include "ml_eye_tracking.h"
#include "ml_hand_tracking.h"
#include "ml_perception.h"
#include "ml_time.h"
#include "ml_world_camera.h"
#include "result.h"

/** A(identifier, table, functions): what can be there or missing as one. */
#define SDK_AREAS(A)                                                                                                   \
    A(SDK_DEPTH, depth, ML_DEPTH_CAMERA_FUNCTIONS)                                                                     \
    A(SDK_DEPTH_CAPABILITIES, depth_capabilities, ML_DEPTH_CAMERA_CAPABILITIES_FUNCTIONS)                              \
    A(SDK_WORLD, world, ML_WORLD_CAMERA_FUNCTIONS)                                                                     \
    A(SDK_EYE, eye, ML_EYE_CAMERA_FUNCTIONS)                                                                           \
    A(SDK_CV, cv, ML_CV_CAMERA_FUNCTIONS)                                                                              \
    A(SDK_HEAD, head, ML_HEAD_TRACKING_FUNCTIONS)                                                                      \
    A(SDK_EYE_TRACKING, eye_tracking, ML_EYE_TRACKING_FUNCTIONS)                                                       \
    A(SDK_HAND_TRACKING, hand_tracking, ML_HAND_TRACKING_FUNCTIONS)                                                    \
    A(SDK_PERCEPTION, perception, ML_PERCEPTION_FUNCTIONS)                                                             \
    A(SDK_SNAPSHOT, snapshot, ML_SNAPSHOT_FUNCTIONS)                                                                   \
    A(SDK_TIME, time, ML_TIME_FUNCTIONS)

#define SDK_IDENTIFIER(identifier, table, functions) identifier,
enum sdk_area { SDK_AREAS(SDK_IDENTIFIER) SDK_AREA_COUNT };

#define SDK_POINTER(name, parameters) MLResult(*name) parameters;
#define SDK_TABLE(identifier, table, functions)                                                                        \
    struct {                                                                                                           \
        functions(SDK_POINTER)                                                                                         \
    } table;
/** Tables of areas that sdk_require has answered with ML2S_OK. */
extern struct sdk { SDK_AREAS(SDK_TABLE) } sdk;

/** The result of a function of the tables, in words. */
#define SDK_CALL(error, table, name, ...) result_of(sdk.table.name(__VA_ARGS__), #name, error)

/**
 * Fills the tables of areas, a mask of 1 << sdk_area. ML2S_NOT_AVAILABLE names the library, or the first symbol, that
 * is missing; asked again, it looks again.
 */
ml2s_result sdk_require(uint32_t areas, ml2s_error *error);

/**
 * The first start starts the perception system and waits up to 2 s for its first snapshot, before which trackers fail;
 * the last stop stops it. Both act on the whole process: a system that the app runs is neither started nor stopped.
 * Needs the area SDK_PERCEPTION.
 */
ml2s_result perception_start(ml2s_error *error);

/** After a start: result is how the connection went that it was for. A failure empties handle and stops again. */
ml2s_result perception_stop_on_failure(ml2s_result result, MLHandle *handle);

/** Empties handle, which was disconnected with result, and stops; answers the first failure. */
ml2s_result perception_stop_after(ml2s_result result, MLHandle *handle, ml2s_error *error);
