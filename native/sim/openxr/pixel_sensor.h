// A created pixel sensor, and the futures of what was begun with it.
#pragma once

#include <functional>
#include <optional>

#include "capabilities.h"
#include "pictures.h"
#include "runtime.h"
#include "sensor_models.h"

namespace ml2sim::xr {

struct PixelStream {
    std::optional<Mode> mode; ///< When configured.
    bool isRunning = false;
    bool hasPending = false; ///< A future that is not completed.
    std::shared_ptr<Pictures> pictures;
    int64_t firstIndex = 0; ///< Of captures that it delivers.

    // What the last data point at.
    XrPixelSensorPlaneML planes[3];
    XrPixelSensorFrameML frames[3];
    std::vector<uint8_t> outside[3]; ///< The pictures, where they are not in the caller's buffer.
};

struct PixelSensor : Object {
    const SensorModel *model;
    std::vector<PixelStream> streams;
    bool isFetching = false;

    /** Refuses a stream that it does not have. */
    PixelStream &stream(uint32_t index);
    bool isSubjectTo(const char *fault) const;
};

/** What an asynchronous call began; takes effect when it is completed. */
struct Future : Object {
    const char *step;
    int64_t readyAt; ///< MLTime
    bool fails;
    std::function<void(PixelSensor &)> effect;
    std::vector<uint32_t> streams;
};

} // namespace ml2sim::xr
