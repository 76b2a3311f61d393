// The library over the real Khronos loader and the simulated headset's OpenXR runtime.
#pragma once

#include <cstdlib>
#include <string>

#include "../../sim/ml2sim.h"
#include "../../sim/openxr/ml2sim_xr.h"
#include "../sources/sensor.h"

constexpr int64_t kMillisecond = 1000000;
constexpr const char *kLoader = "libopenxr_loader.so.1";

inline uint64_t bitOf(uint32_t stream) { return ML2S_STREAM_BIT(stream); }

inline ml2s_settings openXrSettings(ml2s_sensor sensor, uint64_t streams, uint32_t rate_hz = 30, uint32_t width = 0,
                                    uint32_t height = 0) {
    auto settings = settingsOf(sensor, streams);
    settings.backend = ML2S_BACKEND_OPENXR;
    settings.rate_hz = rate_hz;
    settings.width = width;
    settings.height = height;
    return settings;
}

inline const auto kHead = openXrSettings(ML2S_SENSOR_HEAD, ML2S_STREAM_BIT(ML2S_STREAM_HEAD_POSE));
inline const auto kGaze = openXrSettings(ML2S_SENSOR_GAZE, ML2S_STREAM_BIT(ML2S_STREAM_GAZE));
inline const auto kController = openXrSettings(ML2S_SENSOR_CONTROLLER, ML2S_STREAM_BIT(ML2S_STREAM_CONTROLLER));
inline const auto kControllerInput =
    openXrSettings(ML2S_SENSOR_CONTROLLER_INPUT, ML2S_STREAM_BIT(ML2S_STREAM_CONTROLLER_JOY));
inline const auto kHands =
    openXrSettings(ML2S_SENSOR_HANDS, ML2S_STREAM_BIT(ML2S_STREAM_HAND_LEFT) | ML2S_STREAM_BIT(ML2S_STREAM_HAND_RIGHT));
inline const auto kWorldLeft =
    openXrSettings(ML2S_SENSOR_WORLD, ML2S_STREAM_BIT(ML2S_STREAM_WORLD_LEFT), 30, 1016, 1016);
inline const auto kEyeNasalLeft =
    openXrSettings(ML2S_SENSOR_EYE, ML2S_STREAM_BIT(ML2S_STREAM_EYE_NASAL_LEFT), 30, 400, 400);

inline ml2s_settings depthSettings(uint32_t wants = 0) {
    auto settings = openXrSettings(ML2S_SENSOR_DEPTH, bitOf(ML2S_STREAM_DEPTH), 30, 544, 480);
    settings.second_streams = settings.streams;
    settings.wants = wants;
    return settings;
}

inline ml2s_settings onSdk(ml2s_settings settings) {
    settings.backend = ML2S_BACKEND_SDK;
    return settings;
}

class OpenXr : public testing::Test {
  protected:
    void SetUp() override {
        setenv("XR_RUNTIME_JSON", RUNTIME_JSON, 1);
        ml2sim_reset();
        ml2sim_xr_reset();
        headset("noise", "0"); // tests compare with the truth
        ASSERT_EQ(useLoader(kLoader), ML2S_OK);
    }

    /** Stops time: only ml2sim_advance changes it. Frames are then rendered one by one, and there are no current poses.
     */
    static void stopTime() {
        headset("clock", "manual");
        headset("loop_seconds", "2");
        runtime("future.delay_ms", "0");
        ml2sim_advance(5000 * kMillisecond);
    }

    void TearDown() override {
        const auto values = counters();
        for (int kind = 0; kind < ML2SIM_XR_MISUSE_COUNT; kind++)
            EXPECT_EQ(values.misuses[kind], 0u) << "kind " << kind << ": " << values.last_misuse;
        EXPECT_EQ(values.live_objects, 0u);
    }

    static ml2s_result useLoader(const char *path) {
        auto openxr = sized<ml2s_openxr>();
        openxr.loader_path = path;
        return ml2s_use_openxr(&openxr, nullptr);
    }

    static void headset(const char *key, const char *value) {
        const char *problem = ml2sim_set(key, value);
        ASSERT_EQ(problem, nullptr) << problem;
    }
    static void runtime(const char *key, const char *value) {
        const char *problem = ml2sim_xr_set(key, value);
        ASSERT_EQ(problem, nullptr) << problem;
    }
    static ml2sim_xr_counters counters() {
        ml2sim_xr_counters counters;
        ml2sim_xr_get_counters(&counters);
        return counters;
    }

    /** Checks the answer to opening a sensor; the sensor is closed again. */
    static void expectRefused(const ml2s_settings &settings, ml2s_result result, const std::string &message) {
        const Sensor sensor(settings);
        EXPECT_EQ(sensor.result, result);
        EXPECT_EQ(std::string(sensor.error.message), message);
    }
};
