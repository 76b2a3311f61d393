/**
 * The vendor's interfaces of the hand-held controller (API level 21). MLController* tracks it: snapshots hold the poses
 * of its coordinate frames. MLInput*, in libinput.magicleap.so, has its buttons, trigger and touchpad.
 */
#pragma once

#include "ml_types.h"

enum { MLController_MaxActive = 1 };

/** Tracking modes to use. Only the last one is not deprecated. */
typedef struct MLControllerConfiguration {
    bool deprecated_mode_0, deprecated_mode_1;
    bool enable_fused6dof;
} MLControllerConfiguration;

enum {
    MLControllerStatus_NotActive = 0,
    MLControllerStatus_Active_Rotation_Only = 1,
    MLControllerStatus_Active = 2,
};

/** The two frames have the same pose, one filtered and one as measured. There is no time of measurement. */
typedef struct MLControllerStateEx {
    uint8_t controller_id;
    MLCoordinateFrameUID coord_frame_controller, raw_coord_frame_controller;
    uint32_t status; /**< MLControllerStatus_* */
} MLControllerStateEx;

typedef struct MLControllerSystemStateEx {
    uint32_t version;
    MLControllerStateEx controller_state[MLController_MaxActive];
} MLControllerSystemStateEx;

static inline void MLControllerSystemStateExInit(MLControllerSystemStateEx *state) {
    memset(state, 0, sizeof *state);
    state->version = 1;
}

#define ML_CONTROLLER_FUNCTIONS(F)                                                                                     \
    F(MLControllerCreateEx, (const MLControllerConfiguration *modes, MLHandle *out_tracker))                           \
    F(MLControllerDestroy, (MLHandle tracker))                                                                         \
    F(MLControllerGetStateEx, (MLHandle tracker, MLControllerSystemStateEx * inout_state))

ML_CONTROLLER_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLControllerConfiguration, 3);
ML_SIZE(MLControllerStateEx, 48);
ML_OFFSET(MLControllerStateEx, coord_frame_controller, 8);
ML_OFFSET(MLControllerStateEx, raw_coord_frame_controller, 24);
ML_OFFSET(MLControllerStateEx, status, 40);
ML_SIZE(MLControllerSystemStateEx, 56);
ML_OFFSET(MLControllerSystemStateEx, controller_state, 8);

enum {
    MLInput_MaxControllers = 1,
    MLInput_MaxControllerTouchpadTouches = 2,
};

enum {
    MLInputControllerType_None = 0,
    MLInputControllerType_Device = 1,
};

/** Indices of button_state. */
enum {
    MLInputControllerButton_None = 0,
    MLInputControllerButton_Bumper = 1,
    MLInputControllerButton_Menu = 2,
    MLInputControllerButton_Count = 3,
};

typedef struct MLInputControllerTouchpadGesture {
    MLVec3f pos_and_force;
    uint32_t type, direction;
    float speed, distance, radius, angle;
} MLInputControllerTouchpadGesture;

/** The state now. It has no time. */
typedef struct MLInputControllerStateEx {
    uint32_t version;
    uint32_t type; /**< MLInputControllerType_* */
    uint32_t hand; /**< 0: unknown, 1: left, 2: right, 3: both. */
    /** x and y are -1 to 1, the force z is 0 to 1. */
    MLVec3f touch_pos_and_force[MLInput_MaxControllerTouchpadTouches];
    float trigger_normalized; /**< 0 to 1. */
    bool button_state[MLInputControllerButton_Count];
    bool is_touch_active[MLInput_MaxControllerTouchpadTouches];
    bool is_connected;
    MLInputControllerTouchpadGesture touchpad_gesture;
    uint32_t touchpad_gesture_state;
    uint8_t hardware_index;
} MLInputControllerStateEx;

static inline void MLInputControllerStateExInit(MLInputControllerStateEx states[MLInput_MaxControllers]) {
    memset(states, 0, MLInput_MaxControllers * sizeof *states);
    for (int i = 0; i < MLInput_MaxControllers; i++) {
        states[i].version = 1;
    }
}

#define ML_INPUT_FUNCTIONS(F)                                                                                          \
    F(MLInputCreate, (MLHandle * out_tracker))                                                                         \
    F(MLInputDestroy, (MLHandle tracker))                                                                              \
    F(MLInputGetControllerStateEx, (MLHandle tracker, MLInputControllerStateEx out_states[MLInput_MaxControllers]))

ML_INPUT_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLInputControllerTouchpadGesture, 36);
ML_SIZE(MLInputControllerStateEx, 92);
ML_OFFSET(MLInputControllerStateEx, touch_pos_and_force, 12);
ML_OFFSET(MLInputControllerStateEx, trigger_normalized, 36);
ML_OFFSET(MLInputControllerStateEx, button_state, 40);
ML_OFFSET(MLInputControllerStateEx, is_touch_active, 43);
ML_OFFSET(MLInputControllerStateEx, is_connected, 45);
ML_OFFSET(MLInputControllerStateEx, touchpad_gesture, 48);
ML_OFFSET(MLInputControllerStateEx, touchpad_gesture_state, 84);
ML_OFFSET(MLInputControllerStateEx, hardware_index, 88);
