/**
 * The functions of the vendor's libraries, loaded at run time. Thread-safe.
 */
#pragma once

#include "ml2s.h"
#include "ml_controller.h"
#include "ml_depth_camera.h"
#include "ml_eye_camera.h"
#include "ml_eye_tracking.h"
#include "ml_hand_tracking.h"
#include "ml_perception.h"
#include "ml_time.h"
#include "ml_world_camera.h"
#include "result.h"

enum sdk_library { SDK_LIBPERCEPTION, SDK_LIBINPUT, SDK_LIBRARY_COUNT };

/** A(identifier, table, functions, library): groups of functions that a device has or lacks as a whole. */
#define SDK_AREAS(A)                                                                                                   \
    A(SDK_DEPTH, depth, ML_DEPTH_CAMERA_FUNCTIONS, SDK_LIBPERCEPTION)                                                  \
    A(SDK_DEPTH_CAPABILITIES, depth_capabilities, ML_DEPTH_CAMERA_CAPABILITIES_FUNCTIONS, SDK_LIBPERCEPTION)           \
    A(SDK_WORLD, world, ML_WORLD_CAMERA_FUNCTIONS, SDK_LIBPERCEPTION)                                                  \
    A(SDK_EYE, eye, ML_EYE_CAMERA_FUNCTIONS, SDK_LIBPERCEPTION)                                                        \
    A(SDK_CV, cv, ML_CV_CAMERA_FUNCTIONS, SDK_LIBPERCEPTION)                                                           \
    A(SDK_HEAD, head, ML_HEAD_TRACKING_FUNCTIONS, SDK_LIBPERCEPTION)                                                   \
    A(SDK_EYE_TRACKING, eye_tracking, ML_EYE_TRACKING_FUNCTIONS, SDK_LIBPERCEPTION)                                    \
    A(SDK_HAND_TRACKING, hand_tracking, ML_HAND_TRACKING_FUNCTIONS, SDK_LIBPERCEPTION)                                 \
    A(SDK_CONTROLLER, controller, ML_CONTROLLER_FUNCTIONS, SDK_LIBPERCEPTION)                                          \
    A(SDK_PERCEPTION, perception, ML_PERCEPTION_FUNCTIONS, SDK_LIBPERCEPTION)                                          \
    A(SDK_SNAPSHOT, snapshot, ML_SNAPSHOT_FUNCTIONS, SDK_LIBPERCEPTION)                                                \
    A(SDK_TIME, time, ML_TIME_FUNCTIONS, SDK_LIBPERCEPTION)                                                            \
    A(SDK_INPUT, input, ML_INPUT_FUNCTIONS, SDK_LIBINPUT)

#define SDK_IDENTIFIER(identifier, table, functions, library) identifier,
enum sdk_area { SDK_AREAS(SDK_IDENTIFIER) SDK_AREA_COUNT };

#define SDK_POINTER(name, parameters) MLResult(*name) parameters;
#define SDK_TABLE(identifier, table, functions, library)                                                               \
    struct {                                                                                                           \
        functions(SDK_POINTER)                                                                                         \
    } table;
/** The function tables. A table is valid after sdk_require has returned ML2S_OK for its area. */
extern struct sdk { SDK_AREAS(SDK_TABLE) } sdk;

/** Calls a function of a table and converts its result. */
#define SDK_CALL(error, table, name, ...) result_of(sdk.table.name(__VA_ARGS__), #name, error)

/**
 * Fills the tables of areas, a mask of 1 << sdk_area. Returns ML2S_NOT_AVAILABLE with the name of the missing library
 * or symbol; the next call searches again.
 */
ml2s_result sdk_require(uint32_t areas, ml2s_error *error);
