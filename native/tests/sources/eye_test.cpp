#include "scripted_sdk.h"
#include "sensor.h"

using scripted::script;

namespace {

constexpr uint64_t kAll = ML2S_STREAM_BIT(ML2S_STREAM_EYE_NASAL_LEFT) | ML2S_STREAM_BIT(ML2S_STREAM_EYE_NASAL_RIGHT) |
                          ML2S_STREAM_BIT(ML2S_STREAM_EYE_TEMPLE_LEFT) | ML2S_STREAM_BIT(ML2S_STREAM_EYE_TEMPLE_RIGHT);

class Eye : public testing::Test {
  protected:
    Eye() {
        script = {};
        for (const uint32_t id : {1u, 2u, 4u, 8u}) {
            script.eyeFrames.push_back(
                {id, 10 + id, scripted::kOffsetNanos + id, {4, 4, 5, 1, 1, sizeof pixels, pixels}});
        }
    }

    void expectOddOf(ml2s_stream stream, const std::string &message) {
        Sensor sensor(settingsOf(ML2S_SENSOR_EYE, ML2S_STREAM_BIT(stream)));
        expectOdd(sensor, message);
        EXPECT_EQ(script.countOf("MLEyeCameraReleaseCameraData"), int{ML2S_MOST_UNUSABLE_CAPTURES});
    }

    uint8_t pixels[20] = {0, 1, 2, 3, 99, 4, 5, 6, 7, 99, 8, 9, 10, 11, 99, 12, 13, 14, 15, 99};
    Slots nasalLeft{ML2S_STREAM_EYE_NASAL_LEFT}, nasalRight{ML2S_STREAM_EYE_NASAL_RIGHT},
        templeLeft{ML2S_STREAM_EYE_TEMPLE_LEFT}, templeRight{ML2S_STREAM_EYE_TEMPLE_RIGHT};
};

} // namespace

TEST_F(Eye, FourCamerasComeTightlyPackedWithoutPoseAndLens) {
    Sensor sensor(settingsOf(ML2S_SENSOR_EYE, kAll));
    EXPECT_EQ(script.eyeSettings.cameras, 15u);
    const auto frames = sensor.poll();
    EXPECT_EQ(script.calls.back(), "MLEyeCameraReleaseCameraData");
    ASSERT_EQ(frames.size(), 4u);
    const uint32_t streams[] = {ML2S_STREAM_EYE_TEMPLE_LEFT, ML2S_STREAM_EYE_NASAL_LEFT, ML2S_STREAM_EYE_NASAL_RIGHT,
                                ML2S_STREAM_EYE_TEMPLE_RIGHT};
    for (int i = 0; i < 4; i++) {
        EXPECT_EQ(frames[i].stream, streams[i]);
        EXPECT_EQ(frames[i].frame_number, 10 + (1 << i));
        EXPECT_EQ(frames[i].device_nanos, scripted::kOffsetNanos + (1 << i));
        EXPECT_EQ(frames[i].has, 0u);
        for (int pixel = 0; pixel < 16; pixel++) {
            EXPECT_EQ(frames[i].data[frames[i].planes[0].offset_bytes + pixel], pixel);
        }
    }
}

TEST_F(Eye, OnlyTheCamerasAskedForAreDelivered) {
    Sensor sensor(settingsOf(ML2S_SENSOR_EYE, kAll));
    ASSERT_EQ(sensor.configure(settingsOf(ML2S_SENSOR_EYE, ML2S_STREAM_BIT(ML2S_STREAM_EYE_TEMPLE_RIGHT))), ML2S_OK);
    EXPECT_EQ(script.eyeSettings.cameras, 8u);
    const Only got(sensor.poll());
    EXPECT_EQ(got.frame_number, 18);
}

TEST_F(Eye, ThereIsNoSecondStream) {
    const Sensor sensor(settingsOf(ML2S_SENSOR_EYE, kAll, kAll));
    EXPECT_EQ(sensor.result, ML2S_INVALID_ARGUMENT);
    EXPECT_TRUE(script.calls.empty());
}

TEST_F(Eye, AnUnknownCameraIsOdd) {
    script.eyeFrames[3].camera_id = 3;
    expectOddOf(ML2S_STREAM_EYE_TEMPLE_RIGHT, "eye camera: unknown camera 3");
}

TEST_F(Eye, PixelsThatAreNotSideBySideAreOdd) {
    script.eyeFrames[1].frame_buffer.pixel_stride = 2;
    expectOddOf(ML2S_STREAM_EYE_NASAL_LEFT, "eye camera: pixel stride 2, expected 1");
}

TEST_F(Eye, MoreFramesThanCamerasAreOdd) {
    script.frameCount = 5;
    expectOddOf(ML2S_STREAM_EYE_NASAL_LEFT, "eye camera: 5 frames at once, expected at most 4");
}
