/**
 * Declarations of XR_ML_pixel_sensor, in addition to Khronos' header.
 *
 * No C declaration of XR_ML_pixel_sensor is public; names and order of fields follow the vendor's managed bindings.
 * Not confirmed on a device, and used nowhere else:
 * - whether XrPixelSensorBufferPropertiesML has a stream before its size: read it by xr_buffer_size only;
 * - the unit of XrPixelSensorDataGetInfoML.timeout, taken for nanoseconds because its type is XrDuration. Were it
 *   milliseconds, a call would wait for the next frame whatever the timeout;
 * - the fifth of XrPixelSensorFisheyeIntrinsicsML.radialDistortion, which is never read.
 */
#pragma once

#include "xr_ml.h"

/** Older headers of Khronos do not have the extension. */
#ifndef XR_ML_ML2_CONTROLLER_INTERACTION_EXTENSION_NAME
#define XR_ML_ML2_CONTROLLER_INTERACTION_EXTENSION_NAME "XR_ML_ml2_controller_interaction"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Defined in OpenXR 1.1. */
#define XR_ERROR_PERMISSION_INSUFFICIENT ((XrResult)-1000710000)

#define XR_ML_PIXEL_SENSOR_EXTENSION_NAME "XR_ML_pixel_sensor"

/** The XrStructureType of structure number n of XR_ML_pixel_sensor. */
#define XR_ML_PIXEL_SENSOR_TYPE(number) ((XrStructureType)(1000475000 + (number)))
#define XR_TYPE_PIXEL_SENSOR_CREATE_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(1)
#define XR_TYPE_EVENT_DATA_PIXEL_SENSOR_AVAILABILITY_CHANGED_ML XR_ML_PIXEL_SENSOR_TYPE(4)
#define XR_TYPE_PIXEL_SENSOR_CAPABILITY_ML XR_ML_PIXEL_SENSOR_TYPE(5)
#define XR_TYPE_PIXEL_SENSOR_CAPABILITY_QUERY_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(6)
#define XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML XR_ML_PIXEL_SENSOR_TYPE(7)
#define XR_TYPE_PIXEL_SENSOR_CONFIG_EXTENT_2DI_ML XR_ML_PIXEL_SENSOR_TYPE(9)
#define XR_TYPE_PIXEL_SENSOR_RANGE_CONTINUOUS_UINT32_ML XR_ML_PIXEL_SENSOR_TYPE(11)
#define XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_UINT32_ML XR_ML_PIXEL_SENSOR_TYPE(12)
#define XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_EXTENT_2DI_ML XR_ML_PIXEL_SENSOR_TYPE(13)
#define XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(14)
#define XR_TYPE_PIXEL_SENSOR_BUFFER_ML XR_ML_PIXEL_SENSOR_TYPE(15)
#define XR_TYPE_PIXEL_SENSOR_DATA_GET_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(16)
#define XR_TYPE_PIXEL_SENSOR_DATA_ML XR_ML_PIXEL_SENSOR_TYPE(17)
#define XR_TYPE_PIXEL_SENSOR_PINHOLE_INTRINSICS_ML XR_ML_PIXEL_SENSOR_TYPE(18)
#define XR_TYPE_PIXEL_SENSOR_CREATE_SPACE_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(19)
#define XR_TYPE_PIXEL_SENSOR_CONFIGURE_COMPLETION_ML XR_ML_PIXEL_SENSOR_TYPE(20)
#define XR_TYPE_PIXEL_SENSOR_FRAME_ML XR_ML_PIXEL_SENSOR_TYPE(21)
#define XR_TYPE_PIXEL_SENSOR_START_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(22)
#define XR_TYPE_PIXEL_SENSOR_STOP_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(23)
#define XR_TYPE_PIXEL_SENSOR_FISHEYE_INTRINSICS_ML XR_ML_PIXEL_SENSOR_TYPE(24)
#define XR_TYPE_PIXEL_SENSOR_EXPOSURE_TIME_ML XR_ML_PIXEL_SENSOR_TYPE(25)
#define XR_TYPE_PIXEL_SENSOR_DEPTH_CONFIDENCE_BUFFER_ML XR_ML_PIXEL_SENSOR_TYPE(26)
#define XR_TYPE_PIXEL_SENSOR_DEPTH_FLAG_BUFFER_ML XR_ML_PIXEL_SENSOR_TYPE(27)
#define XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_ML XR_ML_PIXEL_SENSOR_TYPE(31)
#define XR_TYPE_PIXEL_SENSOR_PLANE_ML XR_ML_PIXEL_SENSOR_TYPE(33)
#define XR_TYPE_PIXEL_SENSOR_DEPTH_FRAME_ILLUMINATION_ML XR_ML_PIXEL_SENSOR_TYPE(34)
#define XR_TYPE_PIXEL_SENSOR_CONFIG_INFO_ML XR_ML_PIXEL_SENSOR_TYPE(35)
#define XR_TYPE_PIXEL_SENSOR_START_COMPLETION_ML XR_ML_PIXEL_SENSOR_TYPE(36)
#define XR_TYPE_PIXEL_SENSOR_STOP_COMPLETION_ML XR_ML_PIXEL_SENSOR_TYPE(37)
#define XR_TYPE_PIXEL_SENSOR_ANALOG_GAIN_ML XR_ML_PIXEL_SENSOR_TYPE(38)
#define XR_TYPE_PIXEL_SENSOR_DIGITAL_GAIN_ML XR_ML_PIXEL_SENSOR_TYPE(39)

XR_DEFINE_HANDLE(XrPixelSensorML)

typedef enum XrPixelSensorCapabilityTypeML {
    XR_PIXEL_SENSOR_UPDATE_RATE_ML = 0,
    XR_PIXEL_SENSOR_RESOLUTION_ML = 1,
    XR_PIXEL_SENSOR_FORMAT_ML = 3,
    XR_PIXEL_SENSOR_DEPTH_ML = 4,
    XR_PIXEL_SENSOR_MIXED_REALITY_ML = 5,
    XR_PIXEL_SENSOR_MANUAL_EXPOSURE_TIME_ML = 100,
    XR_PIXEL_SENSOR_CAPABILITY_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorCapabilityTypeML;

typedef enum XrPixelSensorDataTypeML {
    XR_PIXEL_SENSOR_BOOL32_ML = 0,
    XR_PIXEL_SENSOR_UINT32_ML = 100,
    XR_PIXEL_SENSOR_FLOAT_ML = 101,
    XR_PIXEL_SENSOR_EXTENT_2DI_ML = 200,
    XR_PIXEL_SENSOR_DATA_TYPE_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorDataTypeML;

typedef enum XrPixelSensorRangeTypeML {
    XR_PIXEL_SENSOR_RANGE_BOOLEAN_ML = 0,
    XR_PIXEL_SENSOR_RANGE_CONTINUOUS_ML = 1,
    XR_PIXEL_SENSOR_RANGE_DISCRETE_ML = 2,
    XR_PIXEL_SENSOR_RANGE_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorRangeTypeML;

/** Formats of a stream and of metadata buffers. */
typedef enum XrPixelSensorFrameTypeML {
    XR_PIXEL_SENSOR_GRAYSCALE_ML = 0,
    XR_PIXEL_SENSOR_RGBA8888_ML = 1,
    XR_PIXEL_SENSOR_YUV420_888_ML = 2,
    XR_PIXEL_SENSOR_JPEG_ML = 3,
    XR_PIXEL_SENSOR_DEPTH32_ML = 4,
    XR_PIXEL_SENSOR_DEPTH_RAW_ML = 5,
    XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML = 6,
    XR_PIXEL_SENSOR_DEPTH_FLAGS_ML = 7,
    XR_PIXEL_SENSOR_FRAME_TYPE_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorFrameTypeML;

typedef enum XrPixelSensorMetadataTypeML {
    XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML = 0,
    XR_PIXEL_SENSOR_METADATA_ANALOG_GAIN_ML = 1,
    XR_PIXEL_SENSOR_METADATA_DIGITAL_GAIN_ML = 2,
    XR_PIXEL_SENSOR_METADATA_PINHOLE_ML = 3,
    XR_PIXEL_SENSOR_METADATA_FISHEYE_ML = 4,
    XR_PIXEL_SENSOR_METADATA_ILLUMINATION_ML = 5,
    XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML = 6,
    XR_PIXEL_SENSOR_METADATA_FLAGS_ML = 7,
    XR_PIXEL_SENSOR_METADATA_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorMetadataTypeML;
#define XR_PIXEL_SENSOR_METADATA_COUNT_ML 8u

typedef enum XrPixelSensorRealityModeML {
    XR_PIXEL_SENSOR_REALITY_MIXED_ML = 0,
    XR_PIXEL_SENSOR_REALITY_CAMERA_ML = 1,
    XR_PIXEL_SENSOR_REALITY_VIRTUAL_ML = 2,
    XR_PIXEL_SENSOR_REALITY_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorRealityModeML;

typedef enum XrPixelSensorIlluminationML {
    XR_PIXEL_SENSOR_ILLUMINATION_ON_ML = 0,
    XR_PIXEL_SENSOR_ILLUMINATION_OFF_ML = 1,
    XR_PIXEL_SENSOR_ILLUMINATION_MAX_ENUM_ML = 0x7FFFFFFF
} XrPixelSensorIlluminationML;

/** Flags of a pixel of DEPTH_FLAGS. The vendor's C interface uses other bits. */
#define XR_PIXEL_SENSOR_DEPTH_VALID_ML 0x1u
#define XR_PIXEL_SENSOR_DEPTH_INVALID_ML 0x2u

typedef struct XrPixelSensorCreateInfoML {
    XrStructureType type;
    const void *next;
    XrPath sensor;
} XrPixelSensorCreateInfoML;

typedef struct XrEventDataPixelSensorAvailabilityChangedML {
    XrStructureType type;
    const void *next;
    XrPath sensor;
    XrBool32 available;
    XrTime changeTime;
} XrEventDataPixelSensorAvailabilityChangedML;

typedef struct XrPixelSensorCapabilityML {
    XrStructureType type;
    void *next;
    XrPixelSensorCapabilityTypeML capabilityType;
    XrPixelSensorDataTypeML dataType;
    XrPixelSensorRangeTypeML rangeType;
} XrPixelSensorCapabilityML;

typedef struct XrPixelSensorCapabilityQueryInfoML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    XrPixelSensorCapabilityTypeML capabilityType;
} XrPixelSensorCapabilityQueryInfoML;

typedef struct XR_MAY_ALIAS XrPixelSensorConfigBaseHeaderML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    XrPixelSensorCapabilityTypeML capabilityType;
} XrPixelSensorConfigBaseHeaderML;

typedef struct XrPixelSensorConfigUint32ML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    XrPixelSensorCapabilityTypeML capabilityType;
    uint32_t value;
} XrPixelSensorConfigUint32ML;

typedef struct XrPixelSensorConfigExtent2DiML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    XrPixelSensorCapabilityTypeML capabilityType;
    XrExtent2Di value;
} XrPixelSensorConfigExtent2DiML;

typedef struct XR_MAY_ALIAS XrPixelSensorRangeBaseHeaderML {
    XrStructureType type;
    void *next;
} XrPixelSensorRangeBaseHeaderML;

typedef struct XrPixelSensorRangeContinuousUint32ML {
    XrStructureType type;
    void *next;
    XrBool32 valid;
    uint32_t min;
    uint32_t max;
} XrPixelSensorRangeContinuousUint32ML;

typedef struct XrPixelSensorRangeDiscreteUint32ML {
    XrStructureType type;
    void *next;
    XrBool32 valid;
    uint32_t capacityInput;
    uint32_t countOutput;
    uint32_t *values;
} XrPixelSensorRangeDiscreteUint32ML;

typedef struct XrPixelSensorRangeDiscreteExtent2DiML {
    XrStructureType type;
    void *next;
    XrBool32 valid;
    uint32_t capacityInput;
    uint32_t countOutput;
    XrExtent2Di *values;
} XrPixelSensorRangeDiscreteExtent2DiML;

typedef struct XrPixelSensorConfigInfoML {
    XrStructureType type;
    const void *next;
    uint32_t streamCount;
    const uint32_t *streams;
    uint32_t configCount;
    const XrPixelSensorConfigBaseHeaderML *const *configs;
} XrPixelSensorConfigInfoML;

typedef struct XrPixelSensorStreamsInfoML {
    XrStructureType type;
    const void *next;
    uint32_t streamCount;
    const uint32_t *streams;
} XrPixelSensorStreamsInfoML;
/** Different types with one layout. */
typedef XrPixelSensorStreamsInfoML XrPixelSensorStartInfoML;
typedef XrPixelSensorStreamsInfoML XrPixelSensorStopInfoML;

typedef struct XrPixelSensorCompletionML {
    XrStructureType type;
    void *next;
    XrResult futureResult;
} XrPixelSensorCompletionML;
typedef XrPixelSensorCompletionML XrPixelSensorConfigureCompletionML;
typedef XrPixelSensorCompletionML XrPixelSensorStartCompletionML;
typedef XrPixelSensorCompletionML XrPixelSensorStopCompletionML;

typedef struct XrPixelSensorBufferPropertiesInfoML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    uint32_t metadataCount;
    const XrPixelSensorMetadataTypeML *metadatas;
} XrPixelSensorBufferPropertiesInfoML;

typedef struct XrPixelSensorBufferPropertiesML {
    XrStructureType type;
    void *next;
    uint32_t stream;
    uint32_t bufferSize;
} XrPixelSensorBufferPropertiesML;

/**
 * Returns the buffer size, whether or not the structure has a stream (0 or 1) before it. The caller has zeroed the
 * structure before the call.
 */
static inline uint32_t xr_buffer_size(const XrPixelSensorBufferPropertiesML *properties) {
    return properties->bufferSize > properties->stream ? properties->bufferSize : properties->stream;
}

typedef struct XrPixelSensorBufferML {
    XrStructureType type;
    void *next;
    uint32_t bufferSize;
    void *buffer;
} XrPixelSensorBufferML;

typedef struct XrPixelSensorDataGetInfoML {
    XrStructureType type;
    const void *next;
    uint32_t stream;
    XrTime lastCaptureTime;
    XrDuration timeout;
} XrPixelSensorDataGetInfoML;

typedef struct XrPixelSensorPlaneML {
    XrStructureType type;
    void *next;
    uint32_t width;
    uint32_t height;
    uint32_t stride;
    uint32_t bytesPerPixel;
    uint32_t pixelStride;
    uint32_t bufferSize;
    uint8_t *buffer;
} XrPixelSensorPlaneML;

typedef struct XrPixelSensorFrameML {
    XrStructureType type;
    void *next;
    XrPixelSensorFrameTypeML frameType;
    uint32_t planeCount;
    XrPixelSensorPlaneML *planes;
} XrPixelSensorFrameML;

/** Metadata structures are chained on next. */
typedef struct XrPixelSensorDataML {
    XrStructureType type;
    void *next;
    XrTime captureTime;
    XrPixelSensorFrameML *frame;
} XrPixelSensorDataML;

typedef struct XrPixelSensorExposureTimeML {
    XrStructureType type;
    void *next;
    float exposureTime; /**< Milliseconds. */
} XrPixelSensorExposureTimeML;

typedef struct XrPixelSensorGainML {
    XrStructureType type;
    void *next;
    uint32_t gain;
} XrPixelSensorGainML;
typedef XrPixelSensorGainML XrPixelSensorAnalogGainML;
typedef XrPixelSensorGainML XrPixelSensorDigitalGainML;

typedef struct XrPixelSensorPinholeIntrinsicsML {
    XrStructureType type;
    void *next;
    XrVector2f focalLength;
    XrVector2f principalPoint;
    XrVector2f fov;       /**< Degrees. */
    double distortion[5]; /**< k1 k2 p1 p2 k3 */
} XrPixelSensorPinholeIntrinsicsML;

typedef struct XrPixelSensorFisheyeIntrinsicsML {
    XrStructureType type;
    void *next;
    XrVector2f focalLength;
    XrVector2f principalPoint;
    XrVector2f fov; /**< Degrees. */
    double radialDistortion[5];
    double tangentialDistortion[2];
} XrPixelSensorFisheyeIntrinsicsML;

typedef struct XrPixelSensorDepthFrameIlluminationML {
    XrStructureType type;
    void *next;
    XrPixelSensorIlluminationML illumination;
} XrPixelSensorDepthFrameIlluminationML;

typedef struct XrPixelSensorDepthBufferML {
    XrStructureType type;
    void *next;
    XrPixelSensorFrameML *frame;
} XrPixelSensorDepthBufferML;
typedef XrPixelSensorDepthBufferML XrPixelSensorDepthConfidenceBufferML;
typedef XrPixelSensorDepthBufferML XrPixelSensorDepthFlagBufferML;

typedef struct XrPixelSensorCreateSpaceInfoML {
    XrStructureType type;
    const void *next;
    XrPixelSensorML sensor;
    XrPosef offset;
} XrPixelSensorCreateSpaceInfoML;

typedef XrResult(XRAPI_PTR *PFN_xrEnumeratePixelSensorsML)(XrSession session, uint32_t capacityInput,
                                                           uint32_t *countOutput, XrPath *sensors);
typedef XrResult(XRAPI_PTR *PFN_xrCreatePixelSensorML)(XrSession session, const XrPixelSensorCreateInfoML *info,
                                                       XrPixelSensorML *sensor);
typedef XrResult(XRAPI_PTR *PFN_xrDestroyPixelSensorML)(XrPixelSensorML sensor);
typedef XrResult(XRAPI_PTR *PFN_xrGetPixelSensorStreamCountML)(XrPixelSensorML sensor, uint32_t *count);
typedef XrResult(XRAPI_PTR *PFN_xrEnumeratePixelSensorCapabilitiesML)(XrPixelSensorML sensor, uint32_t stream,
                                                                      uint32_t capacityInput, uint32_t *countOutput,
                                                                      XrPixelSensorCapabilityML *capabilities);
typedef XrResult(XRAPI_PTR *PFN_xrQueryPixelSensorCapabilityRangeML)(
    XrPixelSensorML sensor, const XrPixelSensorCapabilityQueryInfoML *info, uint32_t configCount,
    const XrPixelSensorConfigBaseHeaderML *const *configs, XrPixelSensorRangeBaseHeaderML *range);
typedef XrResult(XRAPI_PTR *PFN_xrConfigurePixelSensorAsyncML)(XrPixelSensorML sensor,
                                                               const XrPixelSensorConfigInfoML *info,
                                                               XrFutureEXT *future);
typedef XrResult(XRAPI_PTR *PFN_xrConfigurePixelSensorCompleteML)(XrPixelSensorML sensor, XrFutureEXT future,
                                                                  XrPixelSensorConfigureCompletionML *completion);
typedef XrResult(XRAPI_PTR *PFN_xrEnumeratePixelSensorMetadataML)(XrPixelSensorML sensor, uint32_t stream,
                                                                  uint32_t capacityInput, uint32_t *countOutput,
                                                                  XrPixelSensorMetadataTypeML *metadatas);
typedef XrResult(XRAPI_PTR *PFN_xrStartPixelSensorAsyncML)(XrPixelSensorML sensor, const XrPixelSensorStartInfoML *info,
                                                           XrFutureEXT *future);
typedef XrResult(XRAPI_PTR *PFN_xrStartPixelSensorCompleteML)(XrPixelSensorML sensor, XrFutureEXT future,
                                                              XrPixelSensorStartCompletionML *completion);
typedef XrResult(XRAPI_PTR *PFN_xrStopPixelSensorAsyncML)(XrPixelSensorML sensor, const XrPixelSensorStopInfoML *info,
                                                          XrFutureEXT *future);
typedef XrResult(XRAPI_PTR *PFN_xrStopPixelSensorCompleteML)(XrPixelSensorML sensor, XrFutureEXT future,
                                                             XrPixelSensorStopCompletionML *completion);
typedef XrResult(XRAPI_PTR *PFN_xrGetPixelSensorBufferPropertiesML)(XrPixelSensorML sensor,
                                                                    const XrPixelSensorBufferPropertiesInfoML *info,
                                                                    XrPixelSensorBufferPropertiesML *properties);
typedef XrResult(XRAPI_PTR *PFN_xrGetPixelSensorDataML)(XrPixelSensorML sensor, const XrPixelSensorDataGetInfoML *info,
                                                        XrPixelSensorBufferML *buffer, XrPixelSensorDataML *data);
typedef XrResult(XRAPI_PTR *PFN_xrCreatePixelSensorSpaceML)(XrSession session,
                                                            const XrPixelSensorCreateSpaceInfoML *info, XrSpace *space);

#ifdef __cplusplus
}
#endif
