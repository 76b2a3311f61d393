// The functions of the runtime: X(name, extension); the extension of core functions is empty.
#pragma once

#include "openxr_headers.h"

#define XR_ENTRY_POINTS(X)                                                                                             \
    X(xrGetInstanceProcAddr, "")                                                                                       \
    X(xrEnumerateInstanceExtensionProperties, "")                                                                      \
    X(xrCreateInstance, "")                                                                                            \
    X(xrDestroyInstance, "")                                                                                           \
    X(xrPollEvent, "")                                                                                                 \
    X(xrResultToString, "")                                                                                            \
    X(xrStringToPath, "")                                                                                              \
    X(xrPathToString, "")                                                                                              \
    X(xrGetSystem, "")                                                                                                 \
    X(xrGetSystemProperties, "")                                                                                       \
    X(xrCreateSession, "")                                                                                             \
    X(xrDestroySession, "")                                                                                            \
    X(xrBeginSession, "")                                                                                              \
    X(xrEndSession, "")                                                                                                \
    X(xrCreateReferenceSpace, "")                                                                                      \
    X(xrDestroySpace, "")                                                                                              \
    X(xrLocateSpace, "")                                                                                               \
    X(xrCreateActionSet, "")                                                                                           \
    X(xrDestroyActionSet, "")                                                                                          \
    X(xrCreateAction, "")                                                                                              \
    X(xrDestroyAction, "")                                                                                             \
    X(xrSuggestInteractionProfileBindings, "")                                                                         \
    X(xrAttachSessionActionSets, "")                                                                                   \
    X(xrCreateActionSpace, "")                                                                                         \
    X(xrSyncActions, "")                                                                                               \
    X(xrGetActionStateBoolean, "")                                                                                     \
    X(xrGetActionStateFloat, "")                                                                                       \
    X(xrConvertTimespecTimeToTimeKHR, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME)                                     \
    X(xrConvertTimeToTimespecTimeKHR, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME)                                     \
    X(xrCreateHandTrackerEXT, XR_EXT_HAND_TRACKING_EXTENSION_NAME)                                                     \
    X(xrDestroyHandTrackerEXT, XR_EXT_HAND_TRACKING_EXTENSION_NAME)                                                    \
    X(xrLocateHandJointsEXT, XR_EXT_HAND_TRACKING_EXTENSION_NAME)                                                      \
    X(xrPollFutureEXT, XR_EXT_FUTURE_EXTENSION_NAME)                                                                   \
    X(xrCancelFutureEXT, XR_EXT_FUTURE_EXTENSION_NAME)                                                                 \
    X(xrCreateMarkerDetectorML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                             \
    X(xrDestroyMarkerDetectorML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                            \
    X(xrSnapshotMarkerDetectorML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                           \
    X(xrGetMarkerDetectorStateML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                           \
    X(xrGetMarkersML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                                       \
    X(xrGetMarkerReprojectionErrorML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                       \
    X(xrGetMarkerLengthML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                                  \
    X(xrGetMarkerNumberML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                                  \
    X(xrGetMarkerStringML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                                  \
    X(xrCreateMarkerSpaceML, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME)                                                \
    X(xrEnableLocalizationEventsML, XR_ML_LOCALIZATION_MAP_EXTENSION_NAME)                                             \
    X(xrQueryLocalizationMapsML, XR_ML_LOCALIZATION_MAP_EXTENSION_NAME)                                                \
    X(xrRequestMapLocalizationML, XR_ML_LOCALIZATION_MAP_EXTENSION_NAME)                                               \
    X(xrEnableUserCalibrationEventsML, XR_ML_USER_CALIBRATION_EXTENSION_NAME)                                          \
    X(xrEnumeratePixelSensorsML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                    \
    X(xrCreatePixelSensorML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                        \
    X(xrDestroyPixelSensorML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                       \
    X(xrGetPixelSensorStreamCountML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                \
    X(xrEnumeratePixelSensorCapabilitiesML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                         \
    X(xrQueryPixelSensorCapabilityRangeML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                          \
    X(xrConfigurePixelSensorAsyncML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                \
    X(xrConfigurePixelSensorCompleteML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                             \
    X(xrEnumeratePixelSensorMetadataML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                             \
    X(xrStartPixelSensorAsyncML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                    \
    X(xrStartPixelSensorCompleteML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                 \
    X(xrStopPixelSensorAsyncML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                     \
    X(xrStopPixelSensorCompleteML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                  \
    X(xrGetPixelSensorBufferPropertiesML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                           \
    X(xrGetPixelSensorDataML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)                                                       \
    X(xrCreatePixelSensorSpaceML, XR_ML_PIXEL_SENSOR_EXTENSION_NAME)

namespace ml2sim::xr {

/** The extensions that the runtime offers. */
constexpr const char *kExtensions[] = {
    XR_MND_HEADLESS_EXTENSION_NAME,
    XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
    XR_EXT_FUTURE_EXTENSION_NAME,
    XR_ML_PIXEL_SENSOR_EXTENSION_NAME,
    XR_EXT_HAND_TRACKING_EXTENSION_NAME,
    XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME,
    XR_ML_ML2_CONTROLLER_INTERACTION_EXTENSION_NAME,
    XR_EXT_UUID_EXTENSION_NAME,
    XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME,
    XR_ML_LOCALIZATION_MAP_EXTENSION_NAME,
    XR_ML_USER_CALIBRATION_EXTENSION_NAME,
};

/** The entry points. */
template <class Function> struct EntryPoint;
template <class... Arguments> struct EntryPoint<XrResult (*)(Arguments...)> { using Type = XrResult(Arguments...); };
#define XR_DECLARE(name, extension) EntryPoint<PFN_##name>::Type name;
XR_ENTRY_POINTS(XR_DECLARE)

} // namespace ml2sim::xr
