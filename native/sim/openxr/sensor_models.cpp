#include "sensor_models.h"

namespace ml2sim::xr {
namespace {

using Sizes = std::vector<XrExtent2Di>;
using Rates = std::vector<uint32_t>;

void add(StreamModel &stream, const Rates &rates, const Sizes &sizes,
         const std::vector<XrPixelSensorFrameTypeML> &formats,
         const std::vector<XrPixelSensorRealityModeML> &realities = {XR_PIXEL_SENSOR_REALITY_CAMERA_ML}) {
    for (const auto rate : rates)
        for (const auto &size : sizes)
            for (const auto format : formats)
                for (const auto reality : realities)
                    stream.modes.push_back({rate, size, format, reality});
}

StreamModel grey(int32_t side) {
    StreamModel stream;
    add(stream, {30}, {{side, side}}, {XR_PIXEL_SENSOR_GRAYSCALE_ML});
    return stream;
}

StreamModel depth(const Rates &rates) {
    StreamModel stream;
    add(stream, rates, {{544, 480}}, {XR_PIXEL_SENSOR_DEPTH32_ML, XR_PIXEL_SENSOR_DEPTH_RAW_ML});
    return stream;
}

StreamModel camera() {
    StreamModel stream;
    add(stream, {15, 30, 60}, {{640, 480}, {1280, 720}, {1280, 960}, {1440, 1080}, {1920, 1080}, {2048, 1536}},
        {XR_PIXEL_SENSOR_JPEG_ML});
    add(stream, {15, 30}, {{2880, 2160}, {3840, 2160}, {4096, 3072}}, {XR_PIXEL_SENSOR_JPEG_ML});
    return stream;
}

StreamModel mixedReality() {
    const std::vector<XrPixelSensorRealityModeML> realities = {XR_PIXEL_SENSOR_REALITY_MIXED_ML,
                                                               XR_PIXEL_SENSOR_REALITY_CAMERA_ML};
    StreamModel stream;
    stream.hasMixedReality = true;
    add(stream, {30, 60}, {{648, 720}, {972, 1080}, {960, 720}, {1440, 1080}}, {XR_PIXEL_SENSOR_JPEG_ML}, realities);
    add(stream, {30}, {{1944, 2160}, {2880, 2160}}, {XR_PIXEL_SENSOR_JPEG_ML}, realities);
    return stream;
}

} // namespace

const std::vector<SensorModel> &sensorModels() {
    static const std::vector<SensorModel> models = {
        {"/pixelsensor/picture/center", CameraId::Color, {camera(), mixedReality()}},
        {"/pixelsensor/world/left", CameraId::WorldLeft, {grey(1016), grey(1016)}},
        {"/pixelsensor/world/center", CameraId::WorldCenter, {grey(1016), grey(1016)}},
        {"/pixelsensor/world/right", CameraId::WorldRight, {grey(1016), grey(1016)}},
        {"/pixelsensor/depth/center", CameraId::Depth, {depth({1, 5}), depth({5, 25, 30, 50, 60})}},
        {"/pixelsensor/eye/temple/left", CameraId::TempleLeft, {grey(400)}},
        {"/pixelsensor/eye/temple/right", CameraId::TempleRight, {grey(400)}},
        {"/pixelsensor/eye/nasal/left", CameraId::NasalLeft, {grey(400)}},
        {"/pixelsensor/eye/nasal/right", CameraId::NasalRight, {grey(400)}},
    };
    return models;
}

std::vector<XrPixelSensorMetadataTypeML> metadataOf(const SensorModel &sensor, XrPixelSensorFrameTypeML format) {
    if (format == XR_PIXEL_SENSOR_DEPTH32_ML)
        return {XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML, XR_PIXEL_SENSOR_METADATA_PINHOLE_ML,
                XR_PIXEL_SENSOR_METADATA_ILLUMINATION_ML, XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML,
                XR_PIXEL_SENSOR_METADATA_FLAGS_ML};
    if (format == XR_PIXEL_SENSOR_DEPTH_RAW_ML)
        return {XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML, XR_PIXEL_SENSOR_METADATA_PINHOLE_ML,
                XR_PIXEL_SENSOR_METADATA_ILLUMINATION_ML};
    std::vector<XrPixelSensorMetadataTypeML> types = {XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML,
                                                      XR_PIXEL_SENSOR_METADATA_ANALOG_GAIN_ML,
                                                      XR_PIXEL_SENSOR_METADATA_DIGITAL_GAIN_ML};
    if (sensor.camera == CameraId::Color)
        types.push_back(XR_PIXEL_SENSOR_METADATA_PINHOLE_ML);
    else if (sensor.camera <= CameraId::WorldRight)
        types.push_back(XR_PIXEL_SENSOR_METADATA_FISHEYE_ML);
    return types;
}

} // namespace ml2sim::xr
