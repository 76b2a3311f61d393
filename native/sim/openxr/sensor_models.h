// The capabilities of the simulated pixel sensors. They follow docs/configuration.md; the vendor's are not public.
#pragma once

#include <string>
#include <vector>

#include "openxr_headers.h"

namespace ml2sim::xr {

/** A complete configuration of a stream. */
struct Mode {
    uint32_t rate_hz;
    XrExtent2Di size;
    XrPixelSensorFrameTypeML format;
    XrPixelSensorRealityModeML reality; ///< Used by streams with a choice of it.
};

struct StreamModel {
    std::vector<Mode> modes;
    bool hasMixedReality = false;
};

/** The camera of a sensor. */
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

/** Returns the metadata that a sensor offers for a format. */
std::vector<XrPixelSensorMetadataTypeML> metadataOf(const SensorModel &sensor, XrPixelSensorFrameTypeML format);

} // namespace ml2sim::xr
