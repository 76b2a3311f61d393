// A pixel sensor.
#pragma once

#include <optional>

#include "pictures.h"
#include "runtime.h"
#include "sensor_models.h"

namespace ml2sim::xr {

struct PixelStream {
    std::optional<Mode> mode; ///< Set by configuration.
    bool isRunning = false;
    bool hasPending = false; ///< True while a future is not completed.
    std::shared_ptr<Pictures> pictures;
    int64_t firstIndex = 0; ///< Number of the first capture that it delivers.

    // The structures that the last data refer to.
    XrPixelSensorPlaneML planes[3];
    XrPixelSensorFrameML frames[3];
    std::vector<uint8_t> outside[3]; ///< Pictures that lie outside the caller's buffer, by fault.
};

struct PixelSensor : Object {
    const SensorModel *model;
    std::vector<PixelStream> streams;
    bool isFetching = false;

    /** Returns a stream. Refuses an index that the sensor does not have. */
    PixelStream &stream(uint32_t index);
    bool isSubjectTo(const char *fault) const;
};

} // namespace ml2sim::xr
