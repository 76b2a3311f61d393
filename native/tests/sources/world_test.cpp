#include <cmath>
#include <cstring>

#include "scripted_sdk.h"
#include "sensor.h"

using scripted::script;

namespace {

constexpr uint32_t kWidth = 6;
constexpr uint32_t kHeight = 4;
constexpr uint32_t kStride = 10;
constexpr uint64_t kLeft = ML2S_STREAM_BIT(ML2S_STREAM_WORLD_LEFT);
constexpr uint64_t kRight = ML2S_STREAM_BIT(ML2S_STREAM_WORLD_RIGHT);
constexpr uint64_t kCenter = ML2S_STREAM_BIT(ML2S_STREAM_WORLD_CENTER);
constexpr uint64_t kAll = kLeft | kRight | kCenter;

class World : public testing::Test {
  protected:
    World() : pixels(kStride * kHeight) {
        script = {};
        for (size_t i = 0; i < pixels.size(); i++) {
            pixels[i] = static_cast<uint8_t>(i);
        }
        for (const uint32_t id : {4u, 1u, 2u}) {
            script.worldFrames.push_back(frameOf(id, MLWorldCameraFrameType_NormalExposure));
        }
    }

    MLWorldCameraFrame frameOf(MLWorldCameraIdentifier id, MLWorldCameraFrameType type) {
        MLWorldCameraFrame frame = {};
        frame.id = id;
        frame.frame_number = 100 * id + type;
        frame.timestamp = scripted::kOffsetNanos + id;
        frame.intrinsics = {kWidth, kHeight, {600, 601}, {3, 2}, 100, {1, 2, 3, 4}, {5, 6}};
        frame.camera_pose = {{0, 0, 0, 1}, {static_cast<float>(id), 0, 0}};
        frame.frame_buffer = {kWidth, kHeight, kStride, 1, static_cast<uint32_t>(pixels.size()), pixels.data()};
        frame.frame_type = type;
        return frame;
    }

    void expectOddOf(uint64_t stream, const std::string &text) {
        Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, stream));
        expectOdd(sensor, text);
        EXPECT_EQ(script.countOf("MLWorldCameraReleaseCameraData"), int{ML2S_MOST_UNUSABLE_CAPTURES});
    }

    std::vector<uint8_t> pixels;
    Slots left{ML2S_STREAM_WORLD_LEFT}, right{ML2S_STREAM_WORLD_RIGHT}, center{ML2S_STREAM_WORLD_CENTER};
};

} // namespace

TEST_F(World, ABatchBecomesOneFramePerCameraAndIsReleasedBeforeThePollReturns) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    EXPECT_EQ(script.worldSettings.cameras, 7u);
    EXPECT_EQ(script.worldSettings.mode, uint32_t{MLWorldCameraMode_NormalExposure});
    const auto frames = sensor.poll();
    EXPECT_EQ(script.calls.back(), "MLWorldCameraReleaseCameraData");
    ASSERT_EQ(frames.size(), 3u);
    const uint32_t streams[] = {ML2S_STREAM_WORLD_CENTER, ML2S_STREAM_WORLD_LEFT, ML2S_STREAM_WORLD_RIGHT};
    for (int i = 0; i < 3; i++) {
        EXPECT_EQ(frames[i].stream, streams[i]);
        EXPECT_EQ(frames[i].frame_number, script.worldFrames[i].frame_number);
        EXPECT_EQ(frames[i].device_nanos, script.worldFrames[i].timestamp);
        EXPECT_EQ(frames[i].position[0], script.worldFrames[i].camera_pose.position.x);
    }
}

TEST_F(World, PixelsAreCopiedWithoutPaddingAndTheLensInItsOwnOrder) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kCenter));
    const Only got(sensor.poll());
    const auto &plane = got.planes[ML2S_PLANE_IMAGE];
    EXPECT_EQ(plane.stride_bytes, kWidth);
    EXPECT_EQ(plane.size_bytes, kWidth * kHeight);
    for (uint32_t y = 0; y < kHeight; y++) {
        for (uint32_t x = 0; x < kWidth; x++) {
            EXPECT_EQ(got.data[plane.offset_bytes + y * kWidth + x], y * kStride + x);
        }
    }
    EXPECT_EQ(got.lens, ML2S_LENS_FISHEYE_TANGENTIAL);
    const double distortion[] = {1, 2, 3, 4, 5, 6};
    EXPECT_EQ(std::memcmp(got.distortion, distortion, sizeof distortion), 0);
}

TEST_F(World, EveryCameraHasTheExposureThatItWasAskedFor) {
    for (const uint32_t id : {4u, 1u, 2u}) {
        script.worldFrames.push_back(frameOf(id, MLWorldCameraFrameType_LowExposure));
    }
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll, kRight));
    EXPECT_EQ(script.worldSettings.mode, 3u);
    const auto frames = sensor.poll();
    ASSERT_EQ(frames.size(), 3u);
    for (const auto &frame : frames) {
        const bool isLow = frame.stream == ML2S_STREAM_WORLD_RIGHT;
        EXPECT_EQ(frame.frame_number % 100, isLow ? 1 : 2);
    }
}

TEST_F(World, CamerasThatWereNotAskedForAreLeft) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    ASSERT_EQ(sensor.configure(settingsOf(ML2S_SENSOR_WORLD, kLeft)), ML2S_OK);
    EXPECT_EQ(script.worldSettings.cameras, 1u);
    const Only got(sensor.poll());
    EXPECT_EQ(got.stream, ML2S_STREAM_WORLD_LEFT);
}

TEST_F(World, ACameraWithoutFreeSlotLosesItsFrameOnly) {
    uint32_t held[ML2S_MAX_SLOTS];
    ml2s_memory memory;
    for (auto &slot : held) {
        ASSERT_EQ(ml2s_take(ML2S_STREAM_WORLD_CENTER, 1, &slot, &memory), ML2S_OK);
    }
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    const auto frames = sensor.poll();
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].slot, ML2S_NO_SLOT);
    EXPECT_NE(frames[1].slot, ML2S_NO_SLOT);
    for (const auto slot : held) {
        EXPECT_EQ(ml2s_release(ML2S_STREAM_WORLD_CENTER, slot), ML2S_OK);
    }
}

TEST_F(World, FramesBeyondTheCallersRoomComeBack) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    auto frame = sized<ml2s_frame>();
    uint32_t count = 0;
    ASSERT_EQ(ml2s_poll(sensor.handle(), 0, &frame, 1, &count, nullptr), ML2S_OK);
    EXPECT_EQ(count, 1u);
    EXPECT_EQ(ml2s_release(frame.stream, frame.slot), ML2S_OK);
}

TEST_F(World, AnOddFrameIsSkippedAndCountedAndTheOthersGoOn) {
    script.worldFrames[1].frame_buffer.data = nullptr;
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    for (uint32_t i = 0; i < 2 * ML2S_MOST_UNUSABLE_CAPTURES; i++) {
        const auto frames = sensor.poll();
        ASSERT_EQ(frames.size(), 3u) << sensor.error.message;
        EXPECT_EQ(frames[1].stream, uint32_t{ML2S_STREAM_WORLD_LEFT});
        expectSkipped(frames[1]);
        for (const auto &frame : {frames[0], frames[2]}) {
            EXPECT_EQ(frame.skipped, 0u);
            EXPECT_NE(frame.slot, ML2S_NO_SLOT);
        }
    }
}

TEST_F(World, AFrameThatNamesNoCameraIsCountedAgainstTheOneThatHasNone) {
    script.worldFrames[2].id = 8;
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    const auto frames = sensor.poll();
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[2].stream, uint32_t{ML2S_STREAM_WORLD_RIGHT});
    expectSkipped(frames[2]);
}

TEST_F(World, OneUsableCaptureEndsARunOfOddOnes) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kLeft));
    for (uint32_t i = 1; i < 3 * ML2S_MOST_UNUSABLE_CAPTURES; i++) {
        script.worldFrames[1].frame_type = i % ML2S_MOST_UNUSABLE_CAPTURES ? 0 : MLWorldCameraFrameType_NormalExposure;
        sensor.poll();
        EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    }
}

TEST_F(World, AFrameOfAnotherSizeIsSkippedUnlessTheNextOneHasItToo) {
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kLeft));
    const auto heightAfter = [&](uint32_t height) {
        script.worldFrames[1].frame_buffer.height = height;
        const auto frames = sensor.poll();
        return frames.at(0).height;
    };
    EXPECT_EQ(heightAfter(kHeight), kHeight);
    EXPECT_EQ(heightAfter(kHeight - 1), 0u);
    EXPECT_EQ(heightAfter(kHeight), kHeight);
    EXPECT_EQ(heightAfter(kHeight - 1), 0u);
    EXPECT_EQ(heightAfter(kHeight - 1), kHeight - 1);
}

TEST_F(World, AnUnknownCameraIsOdd) {
    script.worldFrames[2].id = 8;
    expectOddOf(kRight, "unknown camera 8 or frame type 2");
}

TEST_F(World, AnUnknownFrameTypeIsOdd) {
    script.worldFrames[0].frame_type = 0;
    expectOddOf(kCenter, "unknown camera 4 or frame type 0");
}

TEST_F(World, MoreFramesThanCamerasAndModesAreOdd) {
    script.frameCount = 7;
    expectOddOf(kLeft, "7 frames at once, expected at most 6");
}

TEST_F(World, TwoFramesOfOneCameraAreNotBothDelivered) {
    script.worldFrames[1] = script.worldFrames[0];
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    const auto frames = sensor.poll();
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0].stream, uint32_t{ML2S_STREAM_WORLD_CENTER});
    EXPECT_EQ(frames[0].skipped, 1u);
    EXPECT_NE(frames[0].slot, ML2S_NO_SLOT);
    EXPECT_EQ(frames[1].skipped, 0u);
}

TEST_F(World, APictureBeyondItsMemoryIsOdd) {
    script.worldFrames[2].frame_buffer.height = UINT32_MAX;
    expectOddOf(kRight, "do not fit 40 bytes");
}

TEST_F(World, AFailedReleaseIsToldAndTheSlotsComeBack) {
    script.results["MLWorldCameraReleaseCameraData"] = MLResult_InvalidParam;
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    EXPECT_TRUE(sensor.poll().empty());
    EXPECT_STREQ(sensor.error.message, "MLWorldCameraReleaseCameraData: InvalidParam (5)");
}

TEST_F(World, ABatchOfNothingIsATimeout) {
    script.worldFrames.clear();
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kAll));
    EXPECT_TRUE(sensor.poll().empty());
    EXPECT_EQ(sensor.result, ML2S_TIMEOUT);
    EXPECT_EQ(script.countOf("MLWorldCameraReleaseCameraData"), 1);
}
