#include "pixel_sensor.h"

#include "../sdk/error.h"
#include "../sdk/memory.h"
#include "future.h"

enum { MAX_LISTED = 16 };

static ml2s_result find_listed(const char *name, XrPath *path, ml2s_error *error) {
    XrPath listed[MAX_LISTED];
    uint32_t count;
    ml2s_result result = XR_CALL(error, core, xrStringToPath, xr.instance, name, path);
    if (result || (result = XR_CALL(error, pixel, xrEnumeratePixelSensorsML, xr.session, MAX_LISTED, &count, listed))) {
        return result;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (listed[i] == *path) {
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s (not listed by the device)", name);
}

static ml2s_result create(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorCreateInfoML info = {.type = XR_TYPE_PIXEL_SENSOR_CREATE_INFO_ML};
    ml2s_result result = find_listed(sensor->mode.path, &info.sensor, error);
    if (result) {
        return result;
    }
    XrResult created = xr.pixel.xrCreatePixelSensorML(xr.session, &info, &sensor->sensor);
    if (XR_FAILED(created)) {
        sensor->sensor = XR_NULL_HANDLE;
        return created == XR_ERROR_PERMISSION_INSUFFICIENT
                   ? error_set(error, ML2S_PERMISSION_DENIED, created, "no permission for %s", sensor->mode.path)
                   : error_set(error, ML2S_NOT_AVAILABLE, created, "not available: %s (xrCreatePixelSensorML: %d)",
                               sensor->mode.path, created);
    }
    uint32_t streams;
    result = XR_CALL(error, pixel, xrGetPixelSensorStreamCountML, sensor->sensor, &streams);
    return result || sensor->mode.device_stream < streams
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s stream %u (it has %u)", sensor->mode.path,
                           sensor->mode.device_stream, streams);
}

static uint32_t needed_metadata(const struct pixel_sensor *sensor) {
    if (sensor->stream != ML2S_STREAM_DEPTH) {
        return 0;
    }
    // Flags mark invalid depths. The pinhole intrinsics convert distance to z.
    return 1u << XR_PIXEL_SENSOR_METADATA_FLAGS_ML | 1u << XR_PIXEL_SENSOR_METADATA_PINHOLE_ML |
           (sensor->wants & ML2S_WANT_CONFIDENCE ? 1u << XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML : 0);
}

static const uint32_t pictures = 1u << XR_PIXEL_SENSOR_METADATA_FLAGS_ML | 1u << XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML;

/** Selects all metadata that the sensor offers, except pictures that the settings do not request. */
static ml2s_result choose_metadata(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorMetadataTypeML offered[XR_PIXEL_SENSOR_METADATA_COUNT_ML * 2];
    uint32_t count, types = 0;
    ml2s_result result =
        XR_CALL(error, pixel, xrEnumeratePixelSensorMetadataML, sensor->sensor, sensor->mode.device_stream,
                (uint32_t)(sizeof offered / sizeof *offered), &count, offered);
    if (result) {
        return result;
    }
    for (uint32_t i = 0; i < count; i++) {
        types |= offered[i] < XR_PIXEL_SENSOR_METADATA_COUNT_ML ? 1u << offered[i] : 0;
    }
    uint32_t needed = needed_metadata(sensor);
    if (needed & ~types) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s stream %u metadata 0x%x", sensor->mode.path,
                         sensor->mode.device_stream, needed & ~types);
    }
    sensor->metadata = types & (needed | ~pictures);
    return ML2S_OK;
}

static ml2s_result start_stream(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorStartInfoML info = {XR_TYPE_PIXEL_SENSOR_START_INFO_ML, NULL, 1, &sensor->mode.device_stream};
    XrPixelSensorStartCompletionML completion = {.type = XR_TYPE_PIXEL_SENSOR_START_COMPLETION_ML};
    ml2s_result result = XR_COMPLETE(error, xrStartPixelSensor, sensor->sensor, &info, &completion, true);
    sensor->is_running = !result;
    return result;
}

static ml2s_result stop_stream(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorStopInfoML info = {XR_TYPE_PIXEL_SENSOR_STOP_INFO_ML, NULL, 1, &sensor->mode.device_stream};
    XrPixelSensorStopCompletionML completion = {.type = XR_TYPE_PIXEL_SENSOR_STOP_COMPLETION_ML};
    return XR_COMPLETE(error, xrStopPixelSensor, sensor->sensor, &info, &completion, false);
}

static ml2s_result query_buffer_size(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorMetadataTypeML types[XR_PIXEL_SENSOR_METADATA_COUNT_ML];
    uint32_t count = 0;
    for (uint32_t type = 0; type < XR_PIXEL_SENSOR_METADATA_COUNT_ML; type++) {
        if (sensor->metadata & 1u << type) {
            types[count++] = (XrPixelSensorMetadataTypeML)type;
        }
    }
    XrPixelSensorBufferPropertiesInfoML info = {XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_INFO_ML, NULL,
                                                sensor->mode.device_stream, count, types};
    XrPixelSensorBufferPropertiesML properties = {.type = XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_ML};
    ml2s_result result = XR_CALL(error, pixel, xrGetPixelSensorBufferPropertiesML, sensor->sensor, &info, &properties);
    sensor->buffer_bytes = xr_buffer_size(&properties);
    return result;
}

static ml2s_result create_space(struct pixel_sensor *sensor, ml2s_error *error) {
    XrPixelSensorCreateSpaceInfoML info = {
        XR_TYPE_PIXEL_SENSOR_CREATE_SPACE_INFO_ML, NULL, sensor->sensor, {{0, 0, 0, 1}, {0, 0, 0}}};
    return XR_CALL(error, pixel, xrCreatePixelSensorSpaceML, xr.session, &info, &sensor->space);
}

ml2s_result pixel_sensor_start(struct pixel_sensor *sensor, ml2s_error *error) {
    ml2s_result result = create(sensor, error);
    if (result || (result = negotiate(sensor->sensor, &sensor->mode, error)) ||
        (result = choose_metadata(sensor, error)) || (result = start_stream(sensor, error)) ||
        (result = query_buffer_size(sensor, error)) || (result = create_space(sensor, error))) {
        pixel_sensor_stop(sensor, NULL);
    }
    return result;
}

ml2s_result pixel_sensor_stop(struct pixel_sensor *sensor, ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    if (sensor->is_running) {
        first = stop_stream(sensor, error);
        sensor->is_running = false;
    }
    if (sensor->space) {
        ml2s_result result = XR_CALL(first ? NULL : error, core, xrDestroySpace, sensor->space);
        first = first ? first : result;
        sensor->space = XR_NULL_HANDLE;
    }
    if (sensor->sensor) {
        ml2s_result result = XR_CALL(first ? NULL : error, pixel, xrDestroyPixelSensorML, sensor->sensor);
        first = first ? first : result;
        sensor->sensor = XR_NULL_HANDLE;
    }
    memory_unmap(&sensor->spare);
    return first;
}
