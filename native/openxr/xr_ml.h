/**
 * Declarations of the extensions XR_EXT_future, XR_EXT_uuid, XR_ML_marker_understanding, XR_ML_localization_map and
 * XR_ML_user_calibration, for headers of Khronos that are older than them. Only what the library uses, or a structure
 * needs, is declared. native/tests/sdk/test_openxr_declarations.py compares each number and offset with another
 * binding.
 */
#pragma once

#include <openxr/openxr.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef XR_EXT_future
#define XR_EXT_future 1
#define XR_EXT_FUTURE_EXTENSION_NAME "XR_EXT_future"
#define XR_TYPE_FUTURE_CANCEL_INFO_EXT ((XrStructureType)1000469000)
#define XR_TYPE_FUTURE_POLL_INFO_EXT ((XrStructureType)1000469001)
#define XR_TYPE_FUTURE_POLL_RESULT_EXT ((XrStructureType)1000469003)
#define XR_ERROR_FUTURE_PENDING_EXT ((XrResult)-1000469001)
#define XR_ERROR_FUTURE_INVALID_EXT ((XrResult)-1000469002)

XR_DEFINE_HANDLE(XrFutureEXT)

typedef enum XrFutureStateEXT {
    XR_FUTURE_STATE_PENDING_EXT = 1,
    XR_FUTURE_STATE_READY_EXT = 2,
    XR_FUTURE_STATE_MAX_ENUM_EXT = 0x7FFFFFFF
} XrFutureStateEXT;

typedef struct XrFutureCancelInfoEXT {
    XrStructureType type;
    const void *next;
    XrFutureEXT future;
} XrFutureCancelInfoEXT;

typedef struct XrFuturePollInfoEXT {
    XrStructureType type;
    const void *next;
    XrFutureEXT future;
} XrFuturePollInfoEXT;

typedef struct XrFuturePollResultEXT {
    XrStructureType type;
    void *next;
    XrFutureStateEXT state;
} XrFuturePollResultEXT;

typedef XrResult(XRAPI_PTR *PFN_xrPollFutureEXT)(XrInstance instance, const XrFuturePollInfoEXT *pollInfo,
                                                 XrFuturePollResultEXT *pollResult);
typedef XrResult(XRAPI_PTR *PFN_xrCancelFutureEXT)(XrInstance instance, const XrFutureCancelInfoEXT *cancelInfo);
#endif

#ifndef XR_EXT_uuid
#define XR_EXT_uuid 1
#define XR_EXT_UUID_EXTENSION_NAME "XR_EXT_uuid"

typedef struct XrUuidEXT {
    uint8_t data[16];
} XrUuidEXT;
#endif

#ifndef XR_ML_marker_understanding
#define XR_ML_marker_understanding 1
#define XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME "XR_ML_marker_understanding"
#define XR_TYPE_SYSTEM_MARKER_UNDERSTANDING_PROPERTIES_ML ((XrStructureType)1000138000)
#define XR_TYPE_MARKER_DETECTOR_CREATE_INFO_ML ((XrStructureType)1000138001)
#define XR_TYPE_MARKER_DETECTOR_ARUCO_INFO_ML ((XrStructureType)1000138002)
#define XR_TYPE_MARKER_DETECTOR_SIZE_INFO_ML ((XrStructureType)1000138003)
#define XR_TYPE_MARKER_DETECTOR_APRIL_TAG_INFO_ML ((XrStructureType)1000138004)
#define XR_TYPE_MARKER_DETECTOR_CUSTOM_PROFILE_INFO_ML ((XrStructureType)1000138005)
#define XR_TYPE_MARKER_DETECTOR_SNAPSHOT_INFO_ML ((XrStructureType)1000138006)
#define XR_TYPE_MARKER_DETECTOR_STATE_ML ((XrStructureType)1000138007)
#define XR_TYPE_MARKER_SPACE_CREATE_INFO_ML ((XrStructureType)1000138008)
#define XR_ERROR_MARKER_DETECTOR_PERMISSION_DENIED_ML ((XrResult)-1000138000)
#define XR_ERROR_MARKER_DETECTOR_LOCATE_FAILED_ML ((XrResult)-1000138001)
#define XR_ERROR_MARKER_DETECTOR_INVALID_DATA_QUERY_ML ((XrResult)-1000138002)
#define XR_ERROR_MARKER_DETECTOR_INVALID_CREATE_INFO_ML ((XrResult)-1000138003)
#define XR_ERROR_MARKER_INVALID_ML ((XrResult)-1000138004)

XR_DEFINE_ATOM(XrMarkerML)
XR_DEFINE_HANDLE(XrMarkerDetectorML)

typedef enum XrMarkerDetectorProfileML {
    XR_MARKER_DETECTOR_PROFILE_DEFAULT_ML = 0,
    XR_MARKER_DETECTOR_PROFILE_SPEED_ML = 1,
    XR_MARKER_DETECTOR_PROFILE_ACCURACY_ML = 2,
    XR_MARKER_DETECTOR_PROFILE_SMALL_TARGETS_ML = 3,
    XR_MARKER_DETECTOR_PROFILE_LARGE_FOV_ML = 4,
    XR_MARKER_DETECTOR_PROFILE_CUSTOM_ML = 5,
    XR_MARKER_DETECTOR_PROFILE_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorProfileML;

typedef enum XrMarkerTypeML {
    XR_MARKER_TYPE_ARUCO_ML = 0,
    XR_MARKER_TYPE_APRIL_TAG_ML = 1,
    XR_MARKER_TYPE_QR_ML = 2,
    XR_MARKER_TYPE_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerTypeML;

typedef enum XrMarkerArucoDictML {
    XR_MARKER_ARUCO_DICT_4X4_50_ML = 0,
    XR_MARKER_ARUCO_DICT_4X4_100_ML = 1,
    XR_MARKER_ARUCO_DICT_4X4_250_ML = 2,
    XR_MARKER_ARUCO_DICT_4X4_1000_ML = 3,
    XR_MARKER_ARUCO_DICT_5X5_50_ML = 4,
    XR_MARKER_ARUCO_DICT_5X5_100_ML = 5,
    XR_MARKER_ARUCO_DICT_5X5_250_ML = 6,
    XR_MARKER_ARUCO_DICT_5X5_1000_ML = 7,
    XR_MARKER_ARUCO_DICT_6X6_50_ML = 8,
    XR_MARKER_ARUCO_DICT_6X6_100_ML = 9,
    XR_MARKER_ARUCO_DICT_6X6_250_ML = 10,
    XR_MARKER_ARUCO_DICT_6X6_1000_ML = 11,
    XR_MARKER_ARUCO_DICT_7X7_50_ML = 12,
    XR_MARKER_ARUCO_DICT_7X7_100_ML = 13,
    XR_MARKER_ARUCO_DICT_7X7_250_ML = 14,
    XR_MARKER_ARUCO_DICT_7X7_1000_ML = 15,
    XR_MARKER_ARUCO_DICT_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerArucoDictML;

typedef enum XrMarkerAprilTagDictML {
    XR_MARKER_APRIL_TAG_DICT_16H5_ML = 0,
    XR_MARKER_APRIL_TAG_DICT_25H9_ML = 1,
    XR_MARKER_APRIL_TAG_DICT_36H10_ML = 2,
    XR_MARKER_APRIL_TAG_DICT_36H11_ML = 3,
    XR_MARKER_APRIL_TAG_DICT_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerAprilTagDictML;

typedef enum XrMarkerDetectorFpsML {
    XR_MARKER_DETECTOR_FPS_LOW_ML = 0,
    XR_MARKER_DETECTOR_FPS_MEDIUM_ML = 1,
    XR_MARKER_DETECTOR_FPS_HIGH_ML = 2,
    XR_MARKER_DETECTOR_FPS_MAX_ML = 3,
    XR_MARKER_DETECTOR_FPS_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorFpsML;

typedef enum XrMarkerDetectorResolutionML {
    XR_MARKER_DETECTOR_RESOLUTION_LOW_ML = 0,
    XR_MARKER_DETECTOR_RESOLUTION_MEDIUM_ML = 1,
    XR_MARKER_DETECTOR_RESOLUTION_HIGH_ML = 2,
    XR_MARKER_DETECTOR_RESOLUTION_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorResolutionML;

typedef enum XrMarkerDetectorCameraML {
    XR_MARKER_DETECTOR_CAMERA_RGB_CAMERA_ML = 0,
    XR_MARKER_DETECTOR_CAMERA_WORLD_CAMERAS_ML = 1,
    XR_MARKER_DETECTOR_CAMERA_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorCameraML;

typedef enum XrMarkerDetectorCornerRefineMethodML {
    XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_NONE_ML = 0,
    XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_SUBPIX_ML = 1,
    XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_CONTOUR_ML = 2,
    XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_APRIL_TAG_ML = 3,
    XR_MARKER_DETECTOR_CORNER_REFINE_METHOD_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorCornerRefineMethodML;

typedef enum XrMarkerDetectorFullAnalysisIntervalML {
    XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_MAX_ML = 0,
    XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_FAST_ML = 1,
    XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_MEDIUM_ML = 2,
    XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_SLOW_ML = 3,
    XR_MARKER_DETECTOR_FULL_ANALYSIS_INTERVAL_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorFullAnalysisIntervalML;

typedef enum XrMarkerDetectorStatusML {
    XR_MARKER_DETECTOR_STATUS_PENDING_ML = 0,
    XR_MARKER_DETECTOR_STATUS_READY_ML = 1,
    XR_MARKER_DETECTOR_STATUS_ERROR_ML = 2,
    XR_MARKER_DETECTOR_STATUS_MAX_ENUM_ML = 0x7FFFFFFF
} XrMarkerDetectorStatusML;

typedef struct XrSystemMarkerUnderstandingPropertiesML {
    XrStructureType type;
    void *next;
    XrBool32 supportsMarkerUnderstanding;
} XrSystemMarkerUnderstandingPropertiesML;

typedef struct XrMarkerDetectorCreateInfoML {
    XrStructureType type;
    const void *next;
    XrMarkerDetectorProfileML profile;
    XrMarkerTypeML markerType;
} XrMarkerDetectorCreateInfoML;

typedef struct XrMarkerDetectorArucoInfoML {
    XrStructureType type;
    const void *next;
    XrMarkerArucoDictML arucoDict;
} XrMarkerDetectorArucoInfoML;

typedef struct XrMarkerDetectorSizeInfoML {
    XrStructureType type;
    const void *next;
    float markerLength;
} XrMarkerDetectorSizeInfoML;

typedef struct XrMarkerDetectorAprilTagInfoML {
    XrStructureType type;
    const void *next;
    XrMarkerAprilTagDictML aprilTagDict;
} XrMarkerDetectorAprilTagInfoML;

typedef struct XrMarkerDetectorCustomProfileInfoML {
    XrStructureType type;
    const void *next;
    XrMarkerDetectorFpsML fpsHint;
    XrMarkerDetectorResolutionML resolutionHint;
    XrMarkerDetectorCameraML cameraHint;
    XrMarkerDetectorCornerRefineMethodML cornerRefineMethod;
    XrBool32 useEdgeRefinement;
    XrMarkerDetectorFullAnalysisIntervalML fullAnalysisIntervalHint;
} XrMarkerDetectorCustomProfileInfoML;

typedef struct XrMarkerDetectorSnapshotInfoML {
    XrStructureType type;
    const void *next;
} XrMarkerDetectorSnapshotInfoML;

typedef struct XrMarkerDetectorStateML {
    XrStructureType type;
    void *next;
    XrMarkerDetectorStatusML state;
} XrMarkerDetectorStateML;

typedef struct XrMarkerSpaceCreateInfoML {
    XrStructureType type;
    const void *next;
    XrMarkerDetectorML markerDetector;
    XrMarkerML marker;
    XrPosef poseInMarkerSpace;
} XrMarkerSpaceCreateInfoML;

typedef XrResult(XRAPI_PTR *PFN_xrCreateMarkerDetectorML)(XrSession session,
                                                          const XrMarkerDetectorCreateInfoML *createInfo,
                                                          XrMarkerDetectorML *markerDetector);
typedef XrResult(XRAPI_PTR *PFN_xrDestroyMarkerDetectorML)(XrMarkerDetectorML markerDetector);
typedef XrResult(XRAPI_PTR *PFN_xrSnapshotMarkerDetectorML)(XrMarkerDetectorML markerDetector,
                                                            XrMarkerDetectorSnapshotInfoML *snapshotInfo);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkerDetectorStateML)(XrMarkerDetectorML markerDetector,
                                                            XrMarkerDetectorStateML *state);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkersML)(XrMarkerDetectorML markerDetector, uint32_t markerCapacityInput,
                                                uint32_t *markerCountOutput, XrMarkerML *markers);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkerReprojectionErrorML)(XrMarkerDetectorML markerDetector, XrMarkerML marker,
                                                                float *reprojectionErrorMeters);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkerLengthML)(XrMarkerDetectorML markerDetector, XrMarkerML marker,
                                                     float *meters);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkerNumberML)(XrMarkerDetectorML markerDetector, XrMarkerML marker,
                                                     uint64_t *number);
typedef XrResult(XRAPI_PTR *PFN_xrGetMarkerStringML)(XrMarkerDetectorML markerDetector, XrMarkerML marker,
                                                     uint32_t bufferCapacityInput, uint32_t *bufferCountOutput,
                                                     char *buffer);
typedef XrResult(XRAPI_PTR *PFN_xrCreateMarkerSpaceML)(XrSession session, const XrMarkerSpaceCreateInfoML *createInfo,
                                                       XrSpace *space);
#endif

#ifndef XR_ML_localization_map
#define XR_ML_localization_map 1
#define XR_ML_LOCALIZATION_MAP_EXTENSION_NAME "XR_ML_localization_map"
#define XR_MAX_LOCALIZATION_MAP_NAME_LENGTH_ML 64
#define XR_TYPE_LOCALIZATION_MAP_ML ((XrStructureType)1000139000)
#define XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML ((XrStructureType)1000139001)
#define XR_TYPE_MAP_LOCALIZATION_REQUEST_INFO_ML ((XrStructureType)1000139002)
#define XR_TYPE_LOCALIZATION_ENABLE_EVENTS_INFO_ML ((XrStructureType)1000139004)
#define XR_REFERENCE_SPACE_TYPE_LOCALIZATION_MAP_ML ((XrReferenceSpaceType)1000139000)
#define XR_ERROR_LOCALIZATION_MAP_UNAVAILABLE_ML ((XrResult)-1000139001)
#define XR_ERROR_LOCALIZATION_MAP_FAIL_ML ((XrResult)-1000139002)
#define XR_ERROR_LOCALIZATION_MAP_IMPORT_EXPORT_PERMISSION_DENIED_ML ((XrResult)-1000139003)
#define XR_ERROR_LOCALIZATION_MAP_PERMISSION_DENIED_ML ((XrResult)-1000139004)

typedef enum XrLocalizationMapStateML {
    XR_LOCALIZATION_MAP_STATE_NOT_LOCALIZED_ML = 0,
    XR_LOCALIZATION_MAP_STATE_LOCALIZED_ML = 1,
    XR_LOCALIZATION_MAP_STATE_LOCALIZATION_PENDING_ML = 2,
    XR_LOCALIZATION_MAP_STATE_LOCALIZATION_SLEEPING_BEFORE_RETRY_ML = 3,
    XR_LOCALIZATION_MAP_STATE_MAX_ENUM_ML = 0x7FFFFFFF
} XrLocalizationMapStateML;

typedef enum XrLocalizationMapTypeML {
    XR_LOCALIZATION_MAP_TYPE_ON_DEVICE_ML = 0,
    XR_LOCALIZATION_MAP_TYPE_CLOUD_ML = 1,
    XR_LOCALIZATION_MAP_TYPE_MAX_ENUM_ML = 0x7FFFFFFF
} XrLocalizationMapTypeML;

typedef enum XrLocalizationMapConfidenceML {
    XR_LOCALIZATION_MAP_CONFIDENCE_POOR_ML = 0,
    XR_LOCALIZATION_MAP_CONFIDENCE_FAIR_ML = 1,
    XR_LOCALIZATION_MAP_CONFIDENCE_GOOD_ML = 2,
    XR_LOCALIZATION_MAP_CONFIDENCE_EXCELLENT_ML = 3,
    XR_LOCALIZATION_MAP_CONFIDENCE_MAX_ENUM_ML = 0x7FFFFFFF
} XrLocalizationMapConfidenceML;

typedef XrFlags64 XrLocalizationMapErrorFlagsML;
#define XR_LOCALIZATION_MAP_ERROR_UNKNOWN_BIT_ML 1
#define XR_LOCALIZATION_MAP_ERROR_OUT_OF_MAPPED_AREA_BIT_ML 2
#define XR_LOCALIZATION_MAP_ERROR_LOW_FEATURE_COUNT_BIT_ML 4
#define XR_LOCALIZATION_MAP_ERROR_EXCESSIVE_MOTION_BIT_ML 8
#define XR_LOCALIZATION_MAP_ERROR_LOW_LIGHT_BIT_ML 16
#define XR_LOCALIZATION_MAP_ERROR_HEADPOSE_BIT_ML 32

typedef struct XrLocalizationMapML {
    XrStructureType type;
    void *next;
    char name[XR_MAX_LOCALIZATION_MAP_NAME_LENGTH_ML];
    XrUuidEXT mapUuid;
    XrLocalizationMapTypeML mapType;
} XrLocalizationMapML;

typedef struct XrEventDataLocalizationChangedML {
    XrStructureType type;
    const void *next;
    XrSession session;
    XrLocalizationMapStateML state;
    XrLocalizationMapML map;
    XrLocalizationMapConfidenceML confidence;
    XrLocalizationMapErrorFlagsML errorFlags;
} XrEventDataLocalizationChangedML;

typedef struct XrLocalizationEnableEventsInfoML {
    XrStructureType type;
    const void *next;
    XrBool32 enabled;
} XrLocalizationEnableEventsInfoML;

typedef struct XrLocalizationMapQueryInfoBaseHeaderML {
    XrStructureType type;
    const void *next;
} XrLocalizationMapQueryInfoBaseHeaderML;

typedef struct XrMapLocalizationRequestInfoML {
    XrStructureType type;
    const void *next;
    XrUuidEXT mapUuid;
} XrMapLocalizationRequestInfoML;

typedef XrResult(XRAPI_PTR *PFN_xrEnableLocalizationEventsML)(XrSession session,
                                                              const XrLocalizationEnableEventsInfoML *info);
typedef XrResult(XRAPI_PTR *PFN_xrQueryLocalizationMapsML)(XrSession session,
                                                           const XrLocalizationMapQueryInfoBaseHeaderML *queryInfo,
                                                           uint32_t mapCapacityInput, uint32_t *mapCountOutput,
                                                           XrLocalizationMapML *maps);
typedef XrResult(XRAPI_PTR *PFN_xrRequestMapLocalizationML)(XrSession session,
                                                            const XrMapLocalizationRequestInfoML *requestInfo);
#endif

#ifndef XR_ML_user_calibration
#define XR_ML_user_calibration 1
#define XR_ML_USER_CALIBRATION_EXTENSION_NAME "XR_ML_user_calibration"
#define XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML ((XrStructureType)1000472000)
#define XR_TYPE_EVENT_DATA_EYE_CALIBRATION_CHANGED_ML ((XrStructureType)1000472001)
#define XR_TYPE_USER_CALIBRATION_ENABLE_EVENTS_INFO_ML ((XrStructureType)1000472002)

typedef enum XrHeadsetFitStatusML {
    XR_HEADSET_FIT_STATUS_UNKNOWN_ML = 0,
    XR_HEADSET_FIT_STATUS_NOT_WORN_ML = 1,
    XR_HEADSET_FIT_STATUS_GOOD_FIT_ML = 2,
    XR_HEADSET_FIT_STATUS_BAD_FIT_ML = 3,
    XR_HEADSET_FIT_STATUS_MAX_ENUM_ML = 0x7FFFFFFF
} XrHeadsetFitStatusML;

typedef enum XrEyeCalibrationStatusML {
    XR_EYE_CALIBRATION_STATUS_UNKNOWN_ML = 0,
    XR_EYE_CALIBRATION_STATUS_NONE_ML = 1,
    XR_EYE_CALIBRATION_STATUS_COARSE_ML = 2,
    XR_EYE_CALIBRATION_STATUS_FINE_ML = 3,
    XR_EYE_CALIBRATION_STATUS_MAX_ENUM_ML = 0x7FFFFFFF
} XrEyeCalibrationStatusML;

typedef struct XrEventDataHeadsetFitChangedML {
    XrStructureType type;
    const void *next;
    XrHeadsetFitStatusML status;
    XrTime time;
} XrEventDataHeadsetFitChangedML;

typedef struct XrEventDataEyeCalibrationChangedML {
    XrStructureType type;
    const void *next;
    XrEyeCalibrationStatusML status;
} XrEventDataEyeCalibrationChangedML;

typedef struct XrUserCalibrationEnableEventsInfoML {
    XrStructureType type;
    const void *next;
    XrBool32 enabled;
} XrUserCalibrationEnableEventsInfoML;

typedef XrResult(XRAPI_PTR *PFN_xrEnableUserCalibrationEventsML)(XrInstance instance,
                                                                 const XrUserCalibrationEnableEventsInfoML *enableInfo);
#endif

/** Results of extensions without other declarations here. */
#ifndef XR_ML_spatial_anchors
#define XR_ERROR_SPATIAL_ANCHORS_PERMISSION_DENIED_ML ((XrResult)-1000140000)
#define XR_ERROR_SPATIAL_ANCHORS_SPACE_NOT_LOCATABLE_ML ((XrResult)-1000140003)
#endif
#ifndef XR_ML_world_mesh_detection
#define XR_ERROR_WORLD_MESH_DETECTOR_PERMISSION_DENIED_ML ((XrResult)-1000474000)
#define XR_ERROR_WORLD_MESH_DETECTOR_SPACE_NOT_LOCATABLE_ML ((XrResult)-1000474001)
#endif
#ifndef XR_ML_facial_expression
/** Positive, so XR_SUCCEEDED takes it for a success. */
#define XR_ERROR_FACIAL_EXPRESSION_PERMISSION_DENIED_ML ((XrResult)1000482000)
#endif

#ifdef __cplusplus
}
#endif
