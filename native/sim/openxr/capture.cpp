// The data of a running stream: buffer sizes, waiting, and filling the caller's buffer.
#include <algorithm>
#include <cstring>

#include "../clock.h"
#include "entry_points.h"
#include "pixel_sensor.h"

namespace ml2sim::xr {
namespace {

constexpr uint32_t kAlignment = 64;
constexpr uint8_t kBetweenRows = 0xee;

uint32_t aligned(uint32_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

uint32_t trailer() { return static_cast<uint32_t>(runtime().keys.whole("picture.extra_bytes")); }

uint32_t padding() { return static_cast<uint32_t>(runtime().keys.whole("stride.extra_bytes")); }

/** The pictures of a capture: that of the stream, then those of its metadata. */
std::vector<XrPixelSensorFrameTypeML> pictureTypes(const PixelStream &stream, bool hasConfidence, bool hasFlags) {
    std::vector<XrPixelSensorFrameTypeML> types = {stream.mode->format};
    if (hasConfidence)
        types.push_back(XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML);
    if (hasFlags)
        types.push_back(XR_PIXEL_SENSOR_DEPTH_FLAGS_ML);
    return types;
}

uint32_t bytesFor(const PixelStream &stream, const std::vector<XrPixelSensorFrameTypeML> &types) {
    uint32_t bytes = static_cast<uint32_t>(runtime().keys.whole("buffer.extra_bytes"));
    for (const auto type : types) {
        const bool isRaster = type != XR_PIXEL_SENSOR_JPEG_ML;
        const auto rows = static_cast<uint32_t>(stream.mode->size.height);
        bytes += aligned(stream.pictures->mostBytes(type) + (isRaster ? rows * padding() : 0) + trailer());
    }
    return bytes;
}

/** Copies a plane to `to` and returns its size. */
uint32_t copyPlane(const Plane &plane, uint8_t *to, XrPixelSensorPlaneML &out) {
    out = {XR_TYPE_PIXEL_SENSOR_PLANE_ML, nullptr, plane.width, plane.height, 0, 1, 1, plane.bytes + trailer(), to};
    if (plane.bytesPerPixel == 0) {
        std::memcpy(to, plane.data, plane.bytes);
        return out.bufferSize;
    }
    const uint32_t row = plane.width * plane.bytesPerPixel;
    out.stride = row + padding();
    out.bytesPerPixel = out.pixelStride = plane.bytesPerPixel;
    out.bufferSize = out.stride * plane.height + trailer();
    for (uint32_t y = 0; y < plane.height; y++) {
        std::memcpy(to + size_t{y} * out.stride, plane.data + size_t{y} * row, row);
        std::memset(to + size_t{y} * out.stride + row, kBetweenRows, padding());
    }
    return out.bufferSize;
}

/** A call of xrGetPixelSensorDataML that has found a capture. */
struct Delivery {
    PixelSensor &sensor;
    PixelStream &stream;
    int64_t index;
    uint8_t *buffer;
    XrPixelSensorFrameML *confidence = nullptr;
    XrPixelSensorFrameML *flags = nullptr;

    void writePictures(const std::vector<XrPixelSensorFrameTypeML> &types) {
        uint8_t *to = buffer;
        for (size_t i = 0; i < types.size(); i++) {
            to += aligned(copyPlane(stream.pictures->plane(types[i], index), to, stream.planes[i]));
            stream.frames[i] = {XR_TYPE_PIXEL_SENSOR_FRAME_ML, nullptr, types[i], 1, &stream.planes[i]};
            if (types[i] == XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML)
                confidence = &stream.frames[i];
            if (types[i] == XR_PIXEL_SENSOR_DEPTH_FLAGS_ML)
                flags = &stream.frames[i];
        }
    }

    /** Moves the data from the buffer to memory of the stream, and overwrites the buffer. */
    void moveOutside(size_t count) {
        for (size_t i = 0; i < count; i++) {
            auto &plane = stream.planes[i];
            stream.outside[i].assign(plane.buffer, plane.buffer + plane.bufferSize);
            std::memset(plane.buffer, kBetweenRows, plane.bufferSize);
            plane.buffer = stream.outside[i].data();
        }
    }

    void write(XrBaseOutStructure *metadata) const {
        const bool isSecond = &stream != &sensor.streams[0];
        if (metadata->type == XR_TYPE_PIXEL_SENSOR_EXPOSURE_TIME_ML)
            reinterpret_cast<XrPixelSensorExposureTimeML *>(metadata)->exposureTime =
                static_cast<float>(stream.pictures->exposure(index).nanos) / 1e6f;
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_ANALOG_GAIN_ML)
            reinterpret_cast<XrPixelSensorAnalogGainML *>(metadata)->gain =
                (isSecond ? 100 : 200) * stream.pictures->exposure(index).gain;
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_DIGITAL_GAIN_ML)
            reinterpret_cast<XrPixelSensorDigitalGainML *>(metadata)->gain = 130;
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_PINHOLE_INTRINSICS_ML)
            writeIntrinsics(*sensor.model, *stream.mode,
                            reinterpret_cast<XrPixelSensorPinholeIntrinsicsML *>(metadata));
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_FISHEYE_INTRINSICS_ML)
            writeIntrinsics(reinterpret_cast<XrPixelSensorFisheyeIntrinsicsML *>(metadata));
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_DEPTH_FRAME_ILLUMINATION_ML)
            reinterpret_cast<XrPixelSensorDepthFrameIlluminationML *>(metadata)->illumination =
                XR_PIXEL_SENSOR_ILLUMINATION_ON_ML;
        else if (metadata->type == XR_TYPE_PIXEL_SENSOR_DEPTH_CONFIDENCE_BUFFER_ML)
            reinterpret_cast<XrPixelSensorDepthConfidenceBufferML *>(metadata)->frame = confidence;
        else
            reinterpret_cast<XrPixelSensorDepthFlagBufferML *>(metadata)->frame = flags;
    }
};

/** The structure type of each XrPixelSensorMetadataTypeML. */
constexpr int kMetadataStructures[] = {1000475025, 1000475038, 1000475039, 1000475018,
                                       1000475024, 1000475034, 1000475026, 1000475027};

bool isOffered(const PixelSensor &sensor, const PixelStream &stream, XrPixelSensorMetadataTypeML type) {
    const auto offered = metadataOf(*sensor.model, stream.mode->format);
    return std::find(offered.begin(), offered.end(), type) != offered.end();
}

/** Returns the types of the structures that are chained to data. Each must be offered. */
std::vector<XrPixelSensorMetadataTypeML> chainedTypes(const PixelSensor &sensor, const PixelStream &stream,
                                                      const XrPixelSensorDataML &data) {
    std::vector<XrPixelSensorMetadataTypeML> types;
    for (auto *next = static_cast<XrBaseOutStructure *>(data.next); next != nullptr; next = next->next) {
        const auto *found = std::find(std::begin(kMetadataStructures), std::end(kMetadataStructures), next->type);
        const auto type = static_cast<XrPixelSensorMetadataTypeML>(found - kMetadataStructures);
        if (found == std::end(kMetadataStructures) || !isOffered(sensor, stream, type))
            misuse(ML2SIM_XR_MISUSE_TYPE, XR_ERROR_VALIDATION_FAILURE,
                   "chained to data: a structure of type " + std::to_string(next->type) + ", which is not offered");
        types.push_back(type);
    }
    return types;
}

bool has(const std::vector<XrPixelSensorMetadataTypeML> &types, XrPixelSensorMetadataTypeML type) {
    return std::find(types.begin(), types.end(), type) != types.end();
}

std::vector<XrPixelSensorFrameTypeML> pictureTypes(const PixelStream &stream,
                                                   const std::vector<XrPixelSensorMetadataTypeML> &metadata) {
    return pictureTypes(stream, has(metadata, XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML),
                        has(metadata, XR_PIXEL_SENSOR_METADATA_FLAGS_ML));
}

PixelStream &runningStream(PixelSensor &sensor, uint32_t index, const char *what) {
    auto &stream = sensor.stream(index);
    if (!stream.isRunning)
        misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, std::string(what) + " before start");
    return stream;
}

/** Marks a sensor while a thread reads its data. */
class Fetching {
  public:
    Fetching(XrPixelSensorML handle, PixelSensor &sensor) : handle_(handle) {
        if (sensor.isFetching)
            misuse(ML2SIM_XR_MISUSE_THREAD, XR_ERROR_CALL_ORDER_INVALID, "data fetched by two threads at once");
        sensor.isFetching = true;
    }
    ~Fetching() {
        const auto found = runtime().objects.find(number(handle_));
        if (found != runtime().objects.end())
            static_cast<PixelSensor &>(*found->second).isFetching = false;
    }

  private:
    XrPixelSensorML handle_;
};

/** Waits for the newest capture after `last` that is drawn. Returns nothing after the deadline. */
std::optional<int64_t> await(std::unique_lock<std::mutex> &lock, XrPixelSensorML handle, uint32_t index, XrTime last,
                             int64_t deadline) {
    for (;;) {
        const uint64_t seen = wakeCount();
        auto &sensor = find<PixelSensor>(handle, "pixel sensor");
        const auto pictures = runningStream(sensor, index, "data").pictures;
        const int64_t now = mlTimeNow();
        const bool isStalled = sensor.isSubjectTo("fault.sensor.stalled");
        if (!isStalled)
            if (const auto found = pictures->newestDrawn(sensor.streams[index].firstIndex, last, now))
                return found;
        if (now >= deadline)
            return {};
        lock.unlock();
        waitUntil(isStalled ? deadline : std::min(deadline, pictures->deliveryTimeOf(pictures->newestAt(now) + 1)),
                  seen);
        lock.lock();
    }
}

} // namespace

XrResult xrGetPixelSensorBufferPropertiesML(XrPixelSensorML sensor, const XrPixelSensorBufferPropertiesInfoML *asked,
                                            XrPixelSensorBufferPropertiesML *properties) {
    return entry([&](auto &) {
        auto &self = find<PixelSensor>(sensor, "pixel sensor");
        const auto &info =
            requireType(asked, XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_INFO_ML, "XrPixelSensorBufferPropertiesInfo");
        auto &out = requireType(properties, XR_TYPE_PIXEL_SENSOR_BUFFER_PROPERTIES_ML, "XrPixelSensorBufferProperties");
        const auto &stream = runningStream(self, info.stream, "buffer properties");
        const std::vector<XrPixelSensorMetadataTypeML> types(info.metadatas, info.metadatas + info.metadataCount);
        for (const auto type : types)
            if (!isOffered(self, stream, type))
                misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, "metadata that are not offered");
        out.stream = info.stream;
        out.bufferSize = bytesFor(stream, pictureTypes(stream, types));
    });
}

XrResult xrGetPixelSensorDataML(XrPixelSensorML sensor, const XrPixelSensorDataGetInfoML *getInfo,
                                XrPixelSensorBufferML *into, XrPixelSensorDataML *data) {
    return entry([&](auto &lock) {
        auto &self = find<PixelSensor>(sensor, "pixel sensor");
        const auto &info = requireType(getInfo, XR_TYPE_PIXEL_SENSOR_DATA_GET_INFO_ML, "XrPixelSensorDataGetInfo");
        auto &buffer = requireType(into, XR_TYPE_PIXEL_SENSOR_BUFFER_ML, "XrPixelSensorBuffer");
        auto &out = requireType(data, XR_TYPE_PIXEL_SENSOR_DATA_ML, "XrPixelSensorData");
        auto &stream = runningStream(self, info.stream, "data");
        const auto types = pictureTypes(stream, chainedTypes(self, stream, out));
        if (buffer.buffer == nullptr || buffer.bufferSize < bytesFor(stream, types))
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_SIZE_INSUFFICIENT, "the buffer is smaller than it must be");
        if (self.isSubjectTo("fault.sensor.failing"))
            return XR_ERROR_RUNTIME_FAILURE;
        const Fetching fetching(sensor, self);
        const auto index = await(lock, sensor, info.stream, info.lastCaptureTime, mlTimeNow() + info.timeout);
        if (!index)
            return XR_TIMEOUT_EXPIRED;
        Delivery delivery{self, stream, *index, static_cast<uint8_t *>(buffer.buffer)};
        delivery.writePictures(types);
        for (auto *next = static_cast<XrBaseOutStructure *>(out.next); next != nullptr; next = next->next)
            delivery.write(next);
        if (self.isSubjectTo("fault.sensor.outside"))
            delivery.moveOutside(types.size());
        if (self.isSubjectTo("fault.sensor.odd"))
            stream.planes[0].height /= 2;
        out.captureTime = stream.pictures->captureTimeOf(*index);
        out.frame = &stream.frames[0];
        ++runtime().counters.frames_delivered;
        return XR_SUCCESS;
    });
}

} // namespace ml2sim::xr
