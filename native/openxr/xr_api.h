/**
 * The OpenXR functions, loaded at run time, with their instance and session. runtime.c writes them while the first
 * sensor opens and the last one closes; all threads of sensors read them.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <time.h>

#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include "xr_pixel_sensor.h"
#include <openxr/openxr_platform.h>

#include "../sdk/lock.h"
#include "../sdk/ml2s.h"

#define XR_CORE_FUNCTIONS(F)                                                                                           \
    F(xrPollEvent)                                                                                                     \
    F(xrGetSystem)                                                                                                     \
    F(xrGetSystemProperties)                                                                                           \
    F(xrCreateSession)                                                                                                 \
    F(xrDestroySession)                                                                                                \
    F(xrBeginSession)                                                                                                  \
    F(xrEndSession)                                                                                                    \
    F(xrCreateReferenceSpace)                                                                                          \
    F(xrDestroySpace)                                                                                                  \
    F(xrLocateSpace)                                                                                                   \
    F(xrStringToPath)                                                                                                  \
    F(xrResultToString)                                                                                                \
    F(xrDestroyInstance)                                                                                               \
    F(xrCreateActionSet)                                                                                               \
    F(xrDestroyActionSet)                                                                                              \
    F(xrCreateAction)                                                                                                  \
    F(xrDestroyAction)                                                                                                 \
    F(xrSuggestInteractionProfileBindings)                                                                             \
    F(xrAttachSessionActionSets)                                                                                       \
    F(xrCreateActionSpace)                                                                                             \
    F(xrSyncActions)                                                                                                   \
    F(xrGetActionStateBoolean)                                                                                         \
    F(xrGetActionStateFloat)

#define XR_TIME_FUNCTIONS(F) F(xrConvertTimespecTimeToTimeKHR) F(xrConvertTimeToTimespecTimeKHR)

#define XR_FUTURE_FUNCTIONS(F) F(xrPollFutureEXT) F(xrCancelFutureEXT)

#define XR_PIXEL_FUNCTIONS(F)                                                                                          \
    F(xrEnumeratePixelSensorsML)                                                                                       \
    F(xrCreatePixelSensorML)                                                                                           \
    F(xrDestroyPixelSensorML)                                                                                          \
    F(xrGetPixelSensorStreamCountML)                                                                                   \
    F(xrEnumeratePixelSensorCapabilitiesML)                                                                            \
    F(xrQueryPixelSensorCapabilityRangeML)                                                                             \
    F(xrConfigurePixelSensorAsyncML)                                                                                   \
    F(xrConfigurePixelSensorCompleteML)                                                                                \
    F(xrEnumeratePixelSensorMetadataML)                                                                                \
    F(xrStartPixelSensorAsyncML)                                                                                       \
    F(xrStartPixelSensorCompleteML)                                                                                    \
    F(xrStopPixelSensorAsyncML)                                                                                        \
    F(xrStopPixelSensorCompleteML)                                                                                     \
    F(xrGetPixelSensorBufferPropertiesML)                                                                              \
    F(xrGetPixelSensorDataML)                                                                                          \
    F(xrCreatePixelSensorSpaceML)

/** An extension that adds only an interaction profile or structures has a function of the core that uses them. */
#define XR_PROFILE_FUNCTIONS(F) F(xrSuggestInteractionProfileBindings)

#define XR_HANDS_FUNCTIONS(F) F(xrCreateHandTrackerEXT) F(xrDestroyHandTrackerEXT) F(xrLocateHandJointsEXT)

#define XR_MARKER_FUNCTIONS(F)                                                                                         \
    F(xrCreateMarkerDetectorML)                                                                                        \
    F(xrDestroyMarkerDetectorML)                                                                                       \
    F(xrSnapshotMarkerDetectorML)                                                                                      \
    F(xrGetMarkerDetectorStateML)                                                                                      \
    F(xrGetMarkersML)                                                                                                  \
    F(xrGetMarkerReprojectionErrorML)                                                                                  \
    F(xrGetMarkerLengthML)                                                                                             \
    F(xrGetMarkerNumberML)                                                                                             \
    F(xrGetMarkerStringML)                                                                                             \
    F(xrCreateMarkerSpaceML)

#define XR_EVENT_FUNCTIONS(F) F(xrPollEvent)

#define XR_MAP_FUNCTIONS(F) F(xrEnableLocalizationEventsML) F(xrQueryLocalizationMapsML) F(xrRequestMapLocalizationML)

#define XR_CALIBRATION_FUNCTIONS(F) F(xrEnableUserCalibrationEventsML)

/**
 * A(identifier, table, functions, extension, needs): groups of functions that a runtime has or lacks as a whole. needs
 * is the extension without which a runtime can refuse an instance that enables this one, or NULL.
 */
#define XR_AREAS(A)                                                                                                    \
    A(XR_CORE, core, XR_CORE_FUNCTIONS, "OpenXR 1.0", NULL)                                                            \
    A(XR_TIME, time, XR_TIME_FUNCTIONS, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, NULL)                             \
    A(XR_FUTURE, future, XR_FUTURE_FUNCTIONS, XR_EXT_FUTURE_EXTENSION_NAME, NULL)                                      \
    A(XR_PIXEL, pixel, XR_PIXEL_FUNCTIONS, XR_ML_PIXEL_SENSOR_EXTENSION_NAME, XR_EXT_FUTURE_EXTENSION_NAME)            \
    A(XR_GAZE, gaze, XR_PROFILE_FUNCTIONS, XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME, NULL)                           \
    A(XR_CONTROLLER, controller, XR_PROFILE_FUNCTIONS, XR_ML_ML2_CONTROLLER_INTERACTION_EXTENSION_NAME, NULL)          \
    A(XR_HANDS, hands, XR_HANDS_FUNCTIONS, XR_EXT_HAND_TRACKING_EXTENSION_NAME, NULL)                                  \
    A(XR_MARKER, marker, XR_MARKER_FUNCTIONS, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME, NULL)                         \
    A(XR_UUID, uuid, XR_EVENT_FUNCTIONS, XR_EXT_UUID_EXTENSION_NAME, NULL)                                             \
    A(XR_MAP, map, XR_MAP_FUNCTIONS, XR_ML_LOCALIZATION_MAP_EXTENSION_NAME, XR_EXT_UUID_EXTENSION_NAME)                \
    A(XR_CALIBRATION, calibration, XR_CALIBRATION_FUNCTIONS, XR_ML_USER_CALIBRATION_EXTENSION_NAME, NULL)

#define XR_IDENTIFIER(identifier, table, functions, extension, needs) identifier,
enum xr_area { XR_AREAS(XR_IDENTIFIER) XR_AREA_COUNT };
#define XR_AREA_BIT(area) (1u << (area))

#define XR_POINTER(name) PFN_##name name;
#define XR_TABLE(identifier, table, functions, extension, needs)                                                       \
    struct {                                                                                                           \
        functions(XR_POINTER)                                                                                          \
    } table;
/** The function tables. A table is valid after xr_begin has returned ML2S_OK for its area. */
extern struct xr {
    XrInstance instance;
    XrSession session;
    XrSystemId system;
    XrSpace world; /**< The LOCAL space. All poses are relative to it. */
    bool is_borrowed;
    uint32_t areas; /**< XR_AREA_BITs of the areas that instance and session have. */
    XR_AREAS(XR_TABLE)
} xr;

/** Converts a result code and sets error after a failure. XR_TIMEOUT_EXPIRED is ML2S_TIMEOUT. */
ml2s_result xr_result_of(XrResult result, const char *call, ml2s_error *error);

/** As turn_take, for up to 6 s; returns 0 with an error if the runtime has not returned to another thread. */
uint32_t xr_take_turn(turn_t *turn, ml2s_error *error);

/** Sleeps 1 ms. */
static inline void sleep_millisecond(void) { nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL); }

/** Calls a function of a table and converts its result. */
#define XR_CALL(error, table, name, ...) xr_result_of(xr.table.name(__VA_ARGS__), #name, error)
