// Configuring a pixel sensor: exactly what is asked for, or a refusal that names what is offered.
#include <optional>

#include "openxr_fixture.h"

class Negotiation : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        stopTime();
    }
    static ml2s_settings color(uint32_t rate_hz, uint32_t width, uint32_t height) {
        return openXrSettings(ML2S_SENSOR_COLOR, bitOf(ML2S_STREAM_COLOR), rate_hz, width, height);
    }
    static void expectFrameOf(Sensor &camera, uint32_t width) {
        ml2sim_advance(1000 * kMillisecond);
        const Only got(camera.poll());
        EXPECT_EQ(got.width, width);
    }
};

TEST_F(Negotiation, ARateThatIsNotOfferedIsRefusedWithThoseThatAre) {
    auto settings = depthSettings();
    settings.second_streams = 0;
    expectRefused(settings, ML2S_INVALID_ARGUMENT,
                  "/pixelsensor/depth/center stream 0: no update rate 30, offered: 1 5");
}

TEST_F(Negotiation, ResolutionsAreThoseOfTheChosenRate) {
    expectRefused(color(60, 4096, 3072), ML2S_INVALID_ARGUMENT,
                  "/pixelsensor/picture/center stream 0: no resolution 4096x3072, offered: 640x480 1280x720 1280x960 "
                  "1440x1080 1920x1080 2048x1536");
    const Sensor slower(color(30, 4096, 3072));
    EXPECT_EQ(slower.result, ML2S_OK) << slower.error.message;
}

TEST_F(Negotiation, MixedRealityHasItsOwnResolutions) {
    expectRefused(openXrSettings(ML2S_SENSOR_COLOR, bitOf(ML2S_STREAM_MIXED_REALITY), 30, 640, 480),
                  ML2S_INVALID_ARGUMENT,
                  "/pixelsensor/picture/center stream 1: no resolution 640x480, offered: 648x720 972x1080 960x720 "
                  "1440x1080 1944x2160 2880x2160");
}

TEST_F(Negotiation, ASensorThatCannotBeHadIsNamed) {
    struct {
        const char *fault;
        ml2s_result result;
        const char *message;
    } const rows[] = {
        {"missing", ML2S_NOT_AVAILABLE, "not available: /pixelsensor/eye/nasal/left (not listed by the device)"},
        {"taken", ML2S_NOT_AVAILABLE, "not available: /pixelsensor/eye/nasal/left (xrCreatePixelSensorML: -2)"},
        {"denied", ML2S_PERMISSION_DENIED, "no permission for /pixelsensor/eye/nasal/left"},
    };
    for (const auto &row : rows) {
        const auto fault = std::string("fault.sensor.") + row.fault;
        runtime(fault.c_str(), "/pixelsensor/eye/nasal/left");
        expectRefused(kEyeNasalLeft, row.result, row.message);
        runtime(fault.c_str(), "");
    }
}

TEST_F(Negotiation, AStreamThatTheSensorHasNotIsNamed) {
    auto settings = kEyeNasalLeft;
    settings.second_streams = settings.streams;
    expectRefused(settings, ML2S_NOT_AVAILABLE, "not available: /pixelsensor/eye/nasal/left stream 1 (it has 1)");
}

TEST_F(Negotiation, OneOfTwoStreamsOfASensorRunsAtATime) {
    auto settings = depthSettings();
    settings.streams |= bitOf(ML2S_STREAM_INFRA);
    expectRefused(settings, ML2S_INVALID_ARGUMENT, "/pixelsensor/depth/center: expected one of its streams, found two");
}

TEST_F(Negotiation, AStepThatFailsIsNamedAndLeavesNothing) {
    for (const std::string step : {"configure", "start"}) {
        runtime("fault.future.fails", step.c_str());
        expectRefused(kEyeNasalLeft, ML2S_VENDOR_FAILURE,
                      std::string(step == "start" ? "xrStart" : "xrConfigure") +
                          "PixelSensorAsyncML: XR_ERROR_RUNTIME_FAILURE (-2)");
    }
}

TEST_F(Negotiation, AStepThatIsNeverCompletedIsGivenUp) {
    runtime("fault.future.stuck", "1");
    expectRefused(kEyeNasalLeft, ML2S_VENDOR_FAILURE, "xrConfigurePixelSensorAsyncML: not completed within 5 s");
    EXPECT_EQ(counters().futures_cancelled, 1u);
}

TEST_F(Negotiation, AFailureToStopIsSaidAndTheSensorIsClosedAllTheSame) {
    Sensor eye(kEyeNasalLeft);
    runtime("fault.future.fails", "stop");
    EXPECT_EQ(eye.close(), ML2S_VENDOR_FAILURE);
    EXPECT_EQ(std::string(eye.error.message), "xrStopPixelSensorAsyncML: XR_ERROR_RUNTIME_FAILURE (-2)");
    EXPECT_EQ(counters().live_objects, 0u);
}

TEST_F(Negotiation, OtherSettingsReplaceThoseInForce) {
    const Slots slots(ML2S_STREAM_COLOR);
    Sensor camera(color(30, 640, 480));
    EXPECT_EQ(camera.configure(color(15, 1280, 960)), ML2S_OK);
    expectFrameOf(camera, 1280);
}

TEST_F(Negotiation, SettingsThatAreRefusedLeaveTheOldOnesRunning) {
    const Slots slots(ML2S_STREAM_COLOR);
    Sensor camera(color(30, 640, 480));
    EXPECT_EQ(camera.configure(color(30, 641, 480)), ML2S_INVALID_ARGUMENT);
    expectFrameOf(camera, 640);
}

TEST_F(Negotiation, AStopThatFailsLeavesTheOldSettingsRunning) {
    const Slots left(ML2S_STREAM_EYE_NASAL_LEFT), right(ML2S_STREAM_EYE_NASAL_RIGHT);
    auto both = kEyeNasalLeft;
    both.streams |= bitOf(ML2S_STREAM_EYE_NASAL_RIGHT);
    Sensor eyes(both);
    const auto objects = counters().live_objects;
    runtime("fault.future.fails", "stop");
    EXPECT_EQ(eyes.configure(kEyeNasalLeft), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(eyes.error.message, "xrStopPixelSensorAsyncML: XR_ERROR_RUNTIME_FAILURE (-2)");
    EXPECT_EQ(counters().live_objects, objects) << "each sensor is stopped, and started once";
    runtime("fault.future.fails", "");
    ml2sim_advance(1000 * kMillisecond);
    const auto frames = eyes.poll();
    EXPECT_EQ(frames.size(), 2u) << eyes.error.message;
}

/** A camera that runs no stream: it took neither the new settings nor the previous ones. */
class Stopped : public Negotiation {
  protected:
    void SetUp() override {
        Negotiation::SetUp();
        camera.emplace(color(30, 640, 480));
        runtime("fault.sensor.taken", "/pixelsensor/picture/center");
        EXPECT_EQ(camera->configure(color(15, 1280, 960)), ML2S_NOT_AVAILABLE);
    }
    void TearDown() override {
        camera.reset();
        Negotiation::TearDown();
    }
    const Slots slots{ML2S_STREAM_COLOR};
    std::optional<Sensor> camera;
};

TEST_F(Stopped, ASensorWithoutStreamsSaysSoAtEachPollInsteadOfWaiting) {
    for (int i = 0; i < 2; i++) {
        EXPECT_TRUE(camera->poll(i * 10000 * kMillisecond).empty());
        EXPECT_EQ(camera->result, ML2S_VENDOR_FAILURE);
        EXPECT_STREQ(camera->error.message,
                     "no stream runs, close the sensor and open it again: the new settings failed, and the previous "
                     "ones could not be started again (not available: /pixelsensor/picture/center "
                     "(xrCreatePixelSensorML: -2))");
    }
}

TEST_F(Stopped, ASensorWithoutStreamsRunsWhenOpenedAgain) {
    EXPECT_EQ(camera->close(), ML2S_OK);
    runtime("fault.sensor.taken", "");
    camera.emplace(color(30, 640, 480));
    expectFrameOf(*camera, 640);
}

TEST_F(Stopped, ASensorWithoutStreamsRunsWithSettingsThatTheDeviceTakes) {
    runtime("fault.sensor.taken", "");
    EXPECT_EQ(camera->configure(color(30, 640, 480)), ML2S_OK);
    expectFrameOf(*camera, 640);
}
