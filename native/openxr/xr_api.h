/**
 * The OpenXR functions of an instance, reached without linking to a loader, and the instance and session they are
 * called with. Written while the first sensor opens and the last one closes (runtime.c), read by every owner thread.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <time.h>

#define XR_USE_TIMESPEC
#define XR_NO_PROTOTYPES
#include "xr_pixel_sensor.h"
#include <openxr/openxr_platform.h>

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
    F(xrDestroyInstance)

#define XR_TIME_FUNCTIONS(F) F(xrConvertTimespecTimeToTimeKHR) F(xrConvertTimeToTimespecTimeKHR)

#define XR_FUTURE_FUNCTIONS(F) F(xrPollFutureEXT)

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

#define XR_GAZE_FUNCTIONS(F)                                                                                           \
    F(xrCreateActionSet)                                                                                               \
    F(xrDestroyActionSet)                                                                                              \
    F(xrCreateAction)                                                                                                  \
    F(xrDestroyAction)                                                                                                 \
    F(xrSuggestInteractionProfileBindings)                                                                             \
    F(xrAttachSessionActionSets)                                                                                       \
    F(xrCreateActionSpace)                                                                                             \
    F(xrSyncActions)

#define XR_HANDS_FUNCTIONS(F) F(xrCreateHandTrackerEXT) F(xrDestroyHandTrackerEXT) F(xrLocateHandJointsEXT)

/** A(identifier, table, functions, extension): what can be there or missing as one. */
#define XR_AREAS(A)                                                                                                    \
    A(XR_CORE, core, XR_CORE_FUNCTIONS, "OpenXR 1.0")                                                                  \
    A(XR_TIME, time, XR_TIME_FUNCTIONS, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME)                                   \
    A(XR_FUTURE, future, XR_FUTURE_FUNCTIONS, XR_EXT_FUTURE_EXTENSION_NAME)                                            \
    A(XR_PIXEL, pixel, XR_PIXEL_FUNCTIONS, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                          \
    A(XR_GAZE, gaze, XR_GAZE_FUNCTIONS, XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME)                                    \
    A(XR_HANDS, hands, XR_HANDS_FUNCTIONS, XR_EXT_HAND_TRACKING_EXTENSION_NAME)

#define XR_IDENTIFIER(identifier, table, functions, extension) identifier,
enum xr_area { XR_AREAS(XR_IDENTIFIER) XR_AREA_COUNT };

#define XR_POINTER(name) PFN_##name name;
#define XR_TABLE(identifier, table, functions, extension)                                                              \
    struct {                                                                                                           \
        functions(XR_POINTER)                                                                                          \
    } table;
/** Tables of areas that xr_acquire has answered with ML2S_OK. */
extern struct xr {
    XrInstance instance;
    XrSession session;
    XrSystemId system;
    XrSpace world; /**< LOCAL: every pose is in it. */
    bool is_borrowed;
    XR_AREAS(XR_TABLE)
} xr;

/** The result of a call in words, ML2S_TIMEOUT for XR_TIMEOUT_EXPIRED. */
ml2s_result xr_result_of(XrResult result, const char *call, ml2s_error *error);

/** The result of a function of the tables, in words. */
#define XR_CALL(error, table, name, ...) xr_result_of(xr.table.name(__VA_ARGS__), #name, error)
