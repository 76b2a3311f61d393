// Pixel sensors: listing, creation, configuration, start and stop. capture.cpp delivers the data.
#include "pixel_sensor.h"

#include "../clock.h"
#include "../tracking.h"
#include "entry_points.h"
#include "futures.h"
#include "modes.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

const SensorModel *modelOf(const std::string &path) {
    if (runtime().keys.text("fault.sensor.missing") == path)
        return nullptr;
    for (const auto &model : sensorModels())
        if (model.path == path)
            return &model;
    return nullptr;
}

PixelSensor &sensorOf(XrPixelSensorML sensor) { return find<PixelSensor>(sensor, "pixel sensor"); }

std::optional<Pose> placeOf(const SensorModel &model, XrTime time) {
    switch (model.camera) {
    case CameraId::WorldLeft:
        return compose(headAt(time), mount(Camera::WorldLeft));
    case CameraId::WorldCenter:
        return compose(headAt(time), mount(Camera::WorldCenter));
    case CameraId::WorldRight:
        return compose(headAt(time), mount(Camera::WorldRight));
    case CameraId::Depth:
        return compose(headAt(time), mount(Camera::Depth));
    case CameraId::Color:
        return compose(headAt(time), mount(Camera::Color));
    default:
        return {};
    }
}

/** Makes a future that applies effect to the streams. None of them may have a pending future. */
XrFutureEXT begin(XrPixelSensorML handle, PixelSensor &sensor, const char *step, std::vector<uint32_t> streams,
                  std::function<void(PixelSensor &)> effect) {
    for (const auto index : streams) {
        if (sensor.stream(index).hasPending)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID,
                   std::string(step) + " while another step is not completed");
        sensor.stream(index).hasPending = true;
    }
    return beginFuture(number(handle), step, [handle, streams, effect = std::move(effect)](bool succeeded) {
        auto &target = sensorOf(handle);
        for (const auto index : streams)
            target.streams[index].hasPending = false;
        if (succeeded)
            effect(target);
    });
}

XrResult complete(XrPixelSensorML handle, XrFutureEXT future, const char *step, XrStructureType type,
                  XrPixelSensorCompletionML *completion) {
    sensorOf(handle);
    auto &out = requireType(completion, type, "completion");
    return completeFuture(number(handle), future, step, &out.futureResult);
}

/** Returns the mode that the configs of a stream select. */
Mode modeFrom(PixelSensor &sensor, uint32_t stream, const XrPixelSensorConfigInfoML &info) {
    const auto candidates = modesWith(sensor.model->streams[stream], stream, info.configCount, info.configs);
    for (const auto type : {XR_PIXEL_SENSOR_UPDATE_RATE_ML, XR_PIXEL_SENSOR_RESOLUTION_ML, XR_PIXEL_SENSOR_FORMAT_ML}) {
        bool isGiven = false;
        for (uint32_t i = 0; i < info.configCount; i++)
            isGiven |= info.configs[i]->stream == stream && info.configs[i]->capabilityType == type;
        if (!isGiven)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, "a mandatory capability is not configured");
    }
    if (candidates.empty())
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, "configured to what is not offered");
    return candidates.front();
}

std::vector<uint32_t> streamsOf(PixelSensor &sensor, uint32_t count, const uint32_t *streams) {
    for (uint32_t i = 0; i < count; i++)
        sensor.stream(streams[i]);
    if (count == 0)
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, "no streams");
    return {streams, streams + count};
}

} // namespace

PixelStream &PixelSensor::stream(uint32_t index) {
    if (index >= streams.size())
        misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_INDEX_OUT_OF_RANGE, model->path + " has no such stream");
    return streams[index];
}

bool PixelSensor::isSubjectTo(const char *fault) const { return runtime().keys.text(fault) == model->path; }

XrResult xrEnumeratePixelSensorsML(XrSession session, uint32_t capacity, uint32_t *count, XrPath *sensors) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        std::vector<XrPath> paths;
        for (const auto &model : sensorModels())
            if (modelOf(model.path) != nullptr)
                paths.push_back(pathOf(model.path));
        return enumerate(paths, capacity, count, sensors);
    });
}

XrResult xrCreatePixelSensorML(XrSession session, const XrPixelSensorCreateInfoML *createInfo,
                               XrPixelSensorML *sensor) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(createInfo, XR_TYPE_PIXEL_SENSOR_CREATE_INFO_ML, "XrPixelSensorCreateInfo");
        const auto *model = modelOf(textOf(info.sensor));
        if (model == nullptr)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_PATH_UNSUPPORTED, "a sensor that is not listed");
        for (const auto &[handle, object] : runtime().objects)
            if (auto *other = dynamic_cast<PixelSensor *>(object.get()); other != nullptr && other->model == model)
                return XR_ERROR_LIMIT_REACHED;
        auto created = std::make_unique<PixelSensor>();
        created->model = model;
        if (created->isSubjectTo("fault.sensor.denied"))
            return XR_ERROR_PERMISSION_INSUFFICIENT;
        if (created->isSubjectTo("fault.sensor.taken"))
            return XR_ERROR_RUNTIME_FAILURE;
        created->streams.resize(model->streams.size());
        requireNonNull(sensor, "sensor") = registerObject<XrPixelSensorML>(number(session), std::move(created));
        return XR_SUCCESS;
    });
}

XrResult xrDestroyPixelSensorML(XrPixelSensorML sensor) {
    return entry([&](auto &) {
        const auto &going = sensorOf(sensor);
        const std::string path = going.model->path;
        bool isRunning = false;
        for (const auto &stream : going.streams)
            isRunning |= stream.isRunning;
        destroy(number(sensor), path.c_str());
        if (isRunning)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, path + " destroyed while running");
    });
}

XrResult xrGetPixelSensorStreamCountML(XrPixelSensorML sensor, uint32_t *count) {
    return entry(
        [&](auto &) { requireNonNull(count, "count") = static_cast<uint32_t>(sensorOf(sensor).streams.size()); });
}

XrResult xrConfigurePixelSensorAsyncML(XrPixelSensorML sensor, const XrPixelSensorConfigInfoML *configInfo,
                                       XrFutureEXT *future) {
    return entry([&](auto &) {
        auto &self = sensorOf(sensor);
        const auto &info = requireType(configInfo, XR_TYPE_PIXEL_SENSOR_CONFIG_INFO_ML, "XrPixelSensorConfigInfo");
        const auto streams = streamsOf(self, info.streamCount, info.streams);
        std::map<uint32_t, Mode> modes;
        for (const auto stream : streams) {
            if (self.stream(stream).isRunning)
                misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "configured while running");
            modes[stream] = modeFrom(self, stream, info);
        }
        requireNonNull(future, "future") = begin(sensor, self, "configure", streams, [modes](PixelSensor &target) {
            for (const auto &[stream, mode] : modes)
                target.streams[stream].mode = mode;
        });
    });
}

XrResult xrConfigurePixelSensorCompleteML(XrPixelSensorML sensor, XrFutureEXT future,
                                          XrPixelSensorConfigureCompletionML *completion) {
    return entry([&](auto &) {
        return complete(sensor, future, "configure", XR_TYPE_PIXEL_SENSOR_CONFIGURE_COMPLETION_ML, completion);
    });
}

XrResult xrEnumeratePixelSensorMetadataML(XrPixelSensorML sensor, uint32_t stream, uint32_t capacity, uint32_t *count,
                                          XrPixelSensorMetadataTypeML *metadatas) {
    return entry([&](auto &) {
        auto &self = sensorOf(sensor);
        const auto &mode = self.stream(stream).mode;
        if (!mode)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "metadata listed before configuring");
        return enumerate(metadataOf(*self.model, mode->format), capacity, count, metadatas);
    });
}

XrResult xrStartPixelSensorAsyncML(XrPixelSensorML sensor, const XrPixelSensorStartInfoML *startInfo,
                                   XrFutureEXT *future) {
    return entry([&](auto &lock) {
        auto &self = sensorOf(sensor);
        const auto &info = requireType(startInfo, XR_TYPE_PIXEL_SENSOR_START_INFO_ML, "XrPixelSensorStartInfo");
        const auto streams = streamsOf(self, info.streamCount, info.streams);
        std::map<uint32_t, std::shared_ptr<Pictures>> pictures;
        for (const auto index : streams) {
            const auto &stream = self.streams[index];
            if (!stream.mode || stream.isRunning)
                misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "started twice, or before configuring");
            const auto *model = self.model;
            const auto mode = *stream.mode;
            lock.unlock(); // the first stream builds the scene
            pictures[index] = Pictures::of(*model, index, mode);
            lock.lock();
        }
        requireNonNull(future, "future") =
            begin(sensor, sensorOf(sensor), "start", streams, [pictures](PixelSensor &target) {
                for (const auto &[index, shown] : pictures) {
                    auto &stream = target.streams[index];
                    stream.pictures = shown;
                    stream.firstIndex = shown->newestAt(mlTimeNow()) + 1;
                    stream.isRunning = true;
                }
            });
    });
}

XrResult xrStartPixelSensorCompleteML(XrPixelSensorML sensor, XrFutureEXT future,
                                      XrPixelSensorStartCompletionML *completion) {
    return entry([&](auto &) {
        return complete(sensor, future, "start", XR_TYPE_PIXEL_SENSOR_START_COMPLETION_ML, completion);
    });
}

XrResult xrStopPixelSensorAsyncML(XrPixelSensorML sensor, const XrPixelSensorStopInfoML *stopInfo,
                                  XrFutureEXT *future) {
    return entry([&](auto &) {
        auto &self = sensorOf(sensor);
        const auto &info = requireType(stopInfo, XR_TYPE_PIXEL_SENSOR_STOP_INFO_ML, "XrPixelSensorStopInfo");
        const auto streams = streamsOf(self, info.streamCount, info.streams);
        for (const auto stream : streams) {
            if (!self.streams[stream].isRunning)
                misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "stopped but not running");
            self.streams[stream].isRunning = false;
        }
        requireNonNull(future, "future") = begin(sensor, self, "stop", streams, [](PixelSensor &) {});
    });
}

XrResult xrStopPixelSensorCompleteML(XrPixelSensorML sensor, XrFutureEXT future,
                                     XrPixelSensorStopCompletionML *completion) {
    return entry(
        [&](auto &) { return complete(sensor, future, "stop", XR_TYPE_PIXEL_SENSOR_STOP_COMPLETION_ML, completion); });
}

XrResult xrCreatePixelSensorSpaceML(XrSession session, const XrPixelSensorCreateSpaceInfoML *createInfo,
                                    XrSpace *space) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info =
            requireType(createInfo, XR_TYPE_PIXEL_SENSOR_CREATE_SPACE_INFO_ML, "XrPixelSensorCreateSpaceInfo");
        auto created = std::make_unique<Space>();
        created->at = [model = sensorOf(info.sensor).model](XrTime time) { return placeOf(*model, time); };
        // The sensor destroys it.
        requireNonNull(space, "space") = registerObject<XrSpace>(number(info.sensor), std::move(created));
    });
}

} // namespace ml2sim::xr
