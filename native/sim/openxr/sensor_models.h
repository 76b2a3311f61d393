// What the simulated pixel sensors can do. Ranges follow the specification's table of streams; the vendor's are not
// public.
#pragma once

#include <string>
#include <vector>

#include "openxr_headers.h"

namespace ml2sim::xr {

/** One complete configuration that a stream can have. */
struct Mode {
    uint32_t rate_hz;
    XrExtent2Di size;
    XrPixelSensorFrameTypeML format;
    XrPixelSensorRealityModeML reality; ///< Of streams that have the choice.
};

struct StreamModel {
    std::vector<Mode> modes;
    bool hasMixedReality = false;
};

/** What a sensor looks through. */
enum class CameraId {
    WorldLeft,
    WorldCenter,
    WorldRight,
    Depth,
    Color,
    TempleLeft,
    NasalLeft,
    NasalRight,
    TempleRight
};

struct SensorModel {
    std::string path;
    CameraId camera;
    std::vector<StreamModel> streams;
};

const std::vector<SensorModel> &sensorModels();

/** The metadata that come with a format of a sensor. */
std::vector<XrPixelSensorMetadataTypeML> metadataOf(const SensorModel &sensor, XrPixelSensorFrameTypeML format);

} // namespace ml2sim::xr
