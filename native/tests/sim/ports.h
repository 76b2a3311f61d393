// The three cameras behind one shape, for what they have in common.
#pragma once

#include "ml_depth_camera.h"
#include "ml_eye_camera.h"
#include "ml_world_camera.h"

#include "headset.h"

struct DepthPort {
    using Data = MLDepthCameraData;
    static constexpr const char *kName = "depth";
    static constexpr bool kHasPose = true;

    static MLDepthCameraSettings settings() {
        auto out = initialised(MLDepthCameraSettingsInit);
        out.streams = MLDepthCameraStream_ShortRange;
        out.stream_configs[MLDepthCameraFrameType_ShortRange].frame_rate = MLDepthCameraFrameRate_30FPS;
        return out;
    }
    static Data data() { return initialised(MLDepthCameraDataInit); }
    static constexpr auto connect = MLDepthCameraConnect;
    static constexpr auto updateSettings = MLDepthCameraUpdateSettings;
    static constexpr auto get = MLDepthCameraGetLatestDepthData;
    static constexpr auto release = MLDepthCameraReleaseDepthData;
    static constexpr auto disconnect = MLDepthCameraDisconnect;
    static const MLDepthCameraFrameBuffer &buffer(const Data &data) { return *data.frames[0].depth_image; }
    static uint32_t bytesPerPixel(const Data &data) { return buffer(data).bytes_per_unit; }
    static MLTime timestamp(const Data &data) { return data.frames[0].frame_timestamp; }
    static uint32_t id(const Data &data) { return data.frames[0].frame_type; }
};

struct WorldPort {
    using Data = MLWorldCameraData;
    static constexpr const char *kName = "world";
    static constexpr bool kHasPose = true;

    static MLWorldCameraSettings settings() {
        auto out = initialised(MLWorldCameraSettingsInit);
        out.cameras = MLWorldCameraIdentifier_Center;
        return out;
    }
    static Data data() { return initialised(MLWorldCameraDataInit); }
    static constexpr auto connect = MLWorldCameraConnect;
    static constexpr auto updateSettings = MLWorldCameraUpdateSettings;
    static MLResult get(MLHandle handle, uint64_t timeout_ms, Data *data) {
        return MLWorldCameraGetLatestWorldCameraData(handle, timeout_ms, &data);
    }
    static constexpr auto release = MLWorldCameraReleaseCameraData;
    static constexpr auto disconnect = MLWorldCameraDisconnect;
    static const MLWorldCameraFrameBuffer &buffer(const Data &data) { return data.frames[0].frame_buffer; }
    static uint32_t bytesPerPixel(const Data &data) { return buffer(data).bytes_per_pixel; }
    static MLTime timestamp(const Data &data) { return data.frames[0].timestamp; }
    static uint32_t id(const Data &data) { return data.frames[0].id; }
};

struct EyePort {
    using Data = MLEyeCameraData;
    static constexpr const char *kName = "eye";
    static constexpr bool kHasPose = false;

    static MLEyeCameraSettings settings() { return initialised(MLEyeCameraSettingsInit); }
    static Data data() { return initialised(MLEyeCameraDataInit); }
    static constexpr auto connect = MLEyeCameraConnect;
    static constexpr auto updateSettings = MLEyeCameraUpdateSettings;
    static constexpr auto get = MLEyeCameraGetLatestCameraData;
    static constexpr auto release = MLEyeCameraReleaseCameraData;
    static constexpr auto disconnect = MLEyeCameraDisconnect;
    static const MLEyeCameraFrameBuffer &buffer(const Data &data) { return data.frames[0].frame_buffer; }
    static uint32_t bytesPerPixel(const Data &data) { return buffer(data).bytes_per_pixel; }
    static MLTime timestamp(const Data &data) { return data.frames[0].timestamp; }
    static uint32_t id(const Data &data) { return data.frames[0].camera_id; }
};
