// Each test is a process of its own, in which libperception.magicleap.so is what the test has loaded.
#include <dlfcn.h>

#include <array>
#include <string>

#include "../sources/sensor.h"

namespace {

constexpr std::array kSensors = {
    std::pair{ML2S_SENSOR_DEPTH, ML2S_STREAM_DEPTH},        std::pair{ML2S_SENSOR_WORLD, ML2S_STREAM_WORLD_LEFT},
    std::pair{ML2S_SENSOR_EYE, ML2S_STREAM_EYE_NASAL_LEFT}, std::pair{ML2S_SENSOR_HEAD, ML2S_STREAM_HEAD_POSE},
    std::pair{ML2S_SENSOR_COLOR, ML2S_STREAM_COLOR},        std::pair{ML2S_SENSOR_GAZE, ML2S_STREAM_GAZE},
    std::pair{ML2S_SENSOR_HANDS, ML2S_STREAM_HAND_LEFT},    std::pair{ML2S_SENSOR_CONTROLLER, ML2S_STREAM_CONTROLLER}};

/** The message of opening a sensor, or "" when it opens. */
std::string openAndClose(ml2s_sensor sensor, ml2s_stream stream) {
    Sensor opened(settingsOf(sensor, ML2S_STREAM_BIT(stream)));
    if (opened.result == ML2S_OK) {
        EXPECT_EQ(ml2s_check(sensor, ML2S_BACKEND_SDK, nullptr), ML2S_OK);
        EXPECT_EQ(opened.close(), ML2S_OK);
        return "";
    }
    EXPECT_EQ(opened.result, ML2S_NOT_AVAILABLE);
    auto checked = sized<ml2s_error>();
    EXPECT_EQ(ml2s_check(sensor, ML2S_BACKEND_SDK, &checked), ML2S_NOT_AVAILABLE);
    EXPECT_STREQ(checked.message, opened.error.message);
    return checked.message;
}

void load(const char *path) { ASSERT_NE(dlopen(path, RTLD_NOW), nullptr) << dlerror(); }

} // namespace

TEST(Tables, WithoutTheLibraryNoSensorIsThereAndTheLibraryIsNamed) {
    for (const auto &[sensor, stream] : kSensors) {
        const auto message = openAndClose(sensor, stream);
        EXPECT_EQ(message.rfind("not available: libperception.magicleap.so (", 0), 0u) << message;
    }
    int64_t captured;
    EXPECT_EQ(ml2s_boottime_of(0, &captured, nullptr), ML2S_NOT_AVAILABLE);
}

TEST(Tables, ALibraryThatComesLaterIsFound) {
    EXPECT_NE(openAndClose(ML2S_SENSOR_HEAD, ML2S_STREAM_HEAD_POSE), "");
    load(COMPLETE_SDK);
    for (const auto &[sensor, stream] : kSensors) {
        EXPECT_EQ(openAndClose(sensor, stream), "");
    }
}

TEST(Tables, AMissingEyeSymbolTakesTheEyesOnlyAndIsNamed) {
    load(SDK_WITHOUT_EYE);
    for (const auto &[sensor, stream] : kSensors) {
        EXPECT_EQ(openAndClose(sensor, stream),
                  sensor == ML2S_SENSOR_EYE ? "not available: libperception.magicleap.so/MLEyeCameraUpdateSettings"
                                            : "");
    }
}

TEST(Tables, AMissingSnapshotSymbolTakesThePosesOnlyAndIsNamed) {
    load(SDK_WITHOUT_SNAPSHOT);
    for (const auto &[sensor, stream] : kSensors) {
        const bool isPose = sensor == ML2S_SENSOR_HEAD || sensor == ML2S_SENSOR_GAZE || sensor == ML2S_SENSOR_HANDS ||
                            sensor == ML2S_SENSOR_CONTROLLER;
        EXPECT_EQ(openAndClose(sensor, stream),
                  isPose ? "not available: libperception.magicleap.so/MLSnapshotGetTransform" : "");
    }
}

TEST(Tables, AMissingLibraryOfInputTakesTheButtonsOnlyAndIsNamed) {
    load(COMPLETE_SDK);
    const auto message = openAndClose(ML2S_SENSOR_CONTROLLER_INPUT, ML2S_STREAM_CONTROLLER_JOY);
    EXPECT_EQ(message.rfind("not available: libinput.magicleap.so (", 0), 0u) << message;
    EXPECT_EQ(openAndClose(ML2S_SENSOR_CONTROLLER, ML2S_STREAM_CONTROLLER), "");
}
