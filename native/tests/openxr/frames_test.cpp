// Frames through XR_ML_pixel_sensor against what the vendor's C interface shows of the very same captures.
#include "openxr_fixture.h"

#include <cmath>
#include <cstring>
#include <optional>

extern "C" {
#include "../../sdk/memory.h"
}

namespace {

/** The frames of captures that are new to the sensor. */
Polled polled(Sensor &sensor) {
    ml2sim_advance(1000 * kMillisecond);
    return sensor.poll();
}
/** The frame of a capture that is new to the sensor. */
Only next(Sensor &sensor) { return Only(polled(sensor)); }

/** A capture as each interface shows it. */
struct Shown {
    explicit Shown(const ml2s_settings &settings)
        : slots(static_cast<uint32_t>(__builtin_ctzll(settings.streams))), byOpenXr(settings), bySdk(onSdk(settings)),
          openXr(next(byOpenXr)), sdk(bySdk.poll()) {}
    const Slots slots;
    Sensor byOpenXr, bySdk;
    const Only openXr, sdk;
};

class Frames : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        stopTime();
    }

    static const uint8_t *row(const ml2s_frame &frame, ml2s_plane_role role, uint32_t y) {
        return frame.data + frame.planes[role].offset_bytes + size_t{y} * frame.planes[role].stride_bytes;
    }
    static void expectSamePixels(const ml2s_frame &a, const ml2s_frame &b, ml2s_plane_role role,
                                 uint32_t bytesPerPixel) {
        ASSERT_EQ(a.width, b.width);
        ASSERT_EQ(a.height, b.height);
        ASSERT_NE(a.planes[role].size_bytes, 0u);
        ASSERT_NE(b.planes[role].size_bytes, 0u);
        for (uint32_t y = 0; y < a.height; y++) {
            ASSERT_EQ(std::memcmp(row(a, role, y), row(b, role, y), a.width * bytesPerPixel), 0) << "row " << y;
        }
    }
    static void expectSameMoment(const ml2s_frame &a, const ml2s_frame &b) {
        EXPECT_EQ(a.device_nanos, b.device_nanos);
        EXPECT_NEAR(static_cast<double>(a.capture_nanos - b.capture_nanos), 0, 1000);
    }
    static void expectSamePose(const ml2s_frame &a, const ml2s_frame &b) {
        ASSERT_TRUE(a.has & b.has & ML2S_HAS_POSE);
        double dot = 0;
        for (int i = 0; i < 4; i++) {
            dot += a.rotation[i] * b.rotation[i];
        }
        EXPECT_NEAR(std::fabs(dot), 1, 1e-6);
        for (int i = 0; i < 3; i++) {
            EXPECT_NEAR(a.position[i], b.position[i], 1e-5);
        }
    }
    static void expectSameLens(const ml2s_frame &a, const ml2s_frame &b) {
        ASSERT_TRUE(a.has & b.has & ML2S_HAS_INTRINSICS);
        EXPECT_EQ(a.lens, b.lens);
        EXPECT_EQ(std::memcmp(a.focal_length, b.focal_length, sizeof a.focal_length), 0);
        EXPECT_EQ(std::memcmp(a.principal_point, b.principal_point, sizeof a.principal_point), 0);
        EXPECT_EQ(std::memcmp(a.distortion, b.distortion, sizeof a.distortion), 0);
    }
    static float depthAt(const ml2s_frame &frame, ml2s_plane_role role, uint32_t x, uint32_t y) {
        float value;
        std::memcpy(&value, row(frame, role, y) + 4 * x, 4);
        return value;
    }
    static uint32_t flagsAt(const ml2s_frame &frame, uint32_t x, uint32_t y) {
        uint32_t value;
        std::memcpy(&value, row(frame, ML2S_PLANE_FLAGS, y) + 4 * x, 4);
        return value;
    }
};

} // namespace

TEST_F(Frames, AWorldCameraShowsWhatTheVendorsInterfaceShows) {
    const Shown shown(kWorldLeft);
    expectSameMoment(shown.openXr, shown.sdk);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 1);
    expectSamePose(shown.openXr, shown.sdk);
    expectSameLens(shown.openXr, shown.sdk);
    EXPECT_TRUE(shown.openXr.has & ML2S_HAS_EXPOSURE);
    EXPECT_EQ(shown.openXr.exposure_nanos, 5000000);
    EXPECT_TRUE(shown.openXr.has & ML2S_HAS_ANALOG_GAIN && shown.openXr.has & ML2S_HAS_DIGITAL_GAIN);
    EXPECT_EQ(shown.openXr.analog_gain, 200u);
    EXPECT_EQ(shown.openXr.digital_gain, 130u);
    EXPECT_FALSE(shown.openXr.has & ML2S_HAS_ILLUMINATION);
}

TEST_F(Frames, TheSecondStreamOfAWorldCameraIsItsLowExposure) {
    headset("controller_tracked", "1");
    auto settings = kWorldLeft;
    settings.second_streams = settings.streams;
    const Shown shown(settings);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 1);
    EXPECT_EQ(shown.openXr.exposure_nanos, 1000000);
}

TEST_F(Frames, PaddingBetweenRowsIsKeptAndSaid) {
    runtime("stride.extra_bytes", "64");
    const Shown shown(kWorldLeft);
    EXPECT_EQ(shown.openXr.planes[ML2S_PLANE_IMAGE].stride_bytes, 1080u);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 1);
}

TEST_F(Frames, CamerasOfOneMomentComeInOnePoll) {
    const Slots left(ML2S_STREAM_WORLD_LEFT), right(ML2S_STREAM_WORLD_RIGHT), center(ML2S_STREAM_WORLD_CENTER);
    auto settings = kWorldLeft;
    settings.streams |= bitOf(ML2S_STREAM_WORLD_RIGHT) | bitOf(ML2S_STREAM_WORLD_CENTER);
    Sensor world(settings);
    ml2sim_advance(1000 * kMillisecond);
    const auto frames = world.poll();
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].device_nanos, frames[1].device_nanos);
    EXPECT_EQ(frames[0].device_nanos, frames[2].device_nanos);
}

TEST_F(Frames, DepthIsTheZThatTheVendorsInterfaceGives) {
    const auto settings = depthSettings(ML2S_WANT_CONFIDENCE | ML2S_WANT_FLAGS);
    const Shown shown(settings);
    expectSameMoment(shown.openXr, shown.sdk);
    expectSamePose(shown.openXr, shown.sdk);
    expectSameLens(shown.openXr, shown.sdk);
    EXPECT_EQ(shown.openXr.illumination, 1u);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 4);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_CONFIDENCE, 4);
}

TEST_F(Frames, FlagsAreThisBackendsBitsAndMarkTheInvalid) {
    const auto settings = depthSettings(ML2S_WANT_FLAGS);
    const Shown shown(settings);
    uint32_t invalid = 0;
    for (uint32_t y = 0; y < shown.openXr.height; y++) {
        for (uint32_t x = 0; x < shown.openXr.width; x++) {
            const uint32_t flags = flagsAt(shown.openXr, x, y);
            const bool isInvalid = flagsAt(shown.sdk, x, y) & 1;
            ASSERT_EQ(flags & 3, isInvalid ? 2u : 1u) << x << ", " << y;
            ASSERT_EQ(std::isnan(depthAt(shown.openXr, ML2S_PLANE_IMAGE, x, y)), isInvalid) << x << ", " << y;
            invalid += isInvalid;
        }
    }
    EXPECT_GT(invalid, 0u);
    EXPECT_LT(invalid, shown.openXr.width * shown.openXr.height);
}

TEST_F(Frames, RadialDepthIsLeftAsItIs) {
    const auto settings = depthSettings(ML2S_WANT_RADIAL);
    const Shown shown(settings);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 4);
    EXPECT_EQ(shown.openXr.planes[ML2S_PLANE_CONFIDENCE].size_bytes, 0u);
    EXPECT_EQ(shown.openXr.planes[ML2S_PLANE_FLAGS].size_bytes, 0u);
}

TEST_F(Frames, InfraredIsTheRawPicture) {
    auto settings = depthSettings();
    settings.streams = settings.second_streams = bitOf(ML2S_STREAM_INFRA);
    const Shown shown(settings);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 4);
}

TEST_F(Frames, AnEyeCameraHasNeitherPoseNorIntrinsics) {
    const Shown shown(kEyeNasalLeft);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 1);
    EXPECT_FALSE(shown.openXr.has & (ML2S_HAS_POSE | ML2S_HAS_INTRINSICS));
}

TEST_F(Frames, ColourIsTheJpegOfTheCapture) {
    struct {
        ml2s_stream stream;
        bool isOutside; ///< The runtime gives it outside the buffer, so it is copied.
    } const cases[] = {{ML2S_STREAM_COLOR, false}, {ML2S_STREAM_MIXED_REALITY, false}, {ML2S_STREAM_COLOR, true}};
    for (const auto &[stream, isOutside] : cases) {
        runtime("fault.sensor.outside", isOutside ? "/pixelsensor/picture/center" : "");
        const bool isMixed = stream == ML2S_STREAM_MIXED_REALITY;
        const ml2sim_color_request request = {isMixed ? 648u : 640u, isMixed ? 720u : 480u, 30, isMixed};
        const Slots slots(stream);
        Sensor camera(openXrSettings(ML2S_SENSOR_COLOR, bitOf(stream), 30, request.width, request.height));
        const auto frame = next(camera);
        ml2sim_color_frame truth;
        ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &truth), 0);
        EXPECT_EQ(frame.device_nanos, truth.capture_mltime);
        EXPECT_EQ(frame.exposure_nanos, truth.exposure_nanos);
        EXPECT_EQ(frame.width, request.width);
        const auto &plane = frame.planes[ML2S_PLANE_IMAGE];
        ASSERT_EQ(plane.size_bytes, truth.jpeg_bytes);
        EXPECT_EQ(std::memcmp(frame.data + plane.offset_bytes, truth.jpeg, truth.jpeg_bytes), 0);
        EXPECT_EQ(plane.stride_bytes, 0u);
        EXPECT_EQ(frame.lens, static_cast<uint32_t>(ML2S_LENS_PLUMB_BOB));
        EXPECT_FLOAT_EQ(static_cast<float>(frame.focal_length[0]), truth.intrinsics[2]);
        EXPECT_FLOAT_EQ(static_cast<float>(frame.principal_point[1]), truth.intrinsics[5]);
        EXPECT_FLOAT_EQ(static_cast<float>(frame.distortion[0]), truth.intrinsics[7]);
        ml2sim_pose pose;
        ml2sim_true_pose(ML2SIM_COLOR, frame.device_nanos, &pose);
        EXPECT_NEAR(frame.position[0], pose.position[0], 1e-5);
        EXPECT_NEAR(frame.position[2], pose.position[2], 1e-5);
    }
}

TEST_F(Frames, ACaptureComesOnce) {
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    Sensor eye(kEyeNasalLeft);
    const auto first = next(eye);
    EXPECT_TRUE(eye.poll().empty());
    EXPECT_EQ(eye.result, ML2S_TIMEOUT);
    const auto second = next(eye);
    EXPECT_EQ(second.frame_number, first.frame_number + 1);
    EXPECT_GT(second.device_nanos, first.device_nanos);
}

TEST_F(Frames, AFrameWithoutFreeSlotIsLostAndSaidSo) {
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT, 1);
    Sensor eye(kEyeNasalLeft);
    {
        const auto kept = next(eye), lost = next(eye);
        EXPECT_EQ(lost.slot, ML2S_NO_SLOT);
        EXPECT_EQ(lost.data, nullptr);
        EXPECT_EQ(lost.planes[ML2S_PLANE_IMAGE].size_bytes, 0u);
        EXPECT_EQ(lost.frame_number, kept.frame_number + 1);
    }
    EXPECT_NE(next(eye).slot, ML2S_NO_SLOT);
}

TEST_F(Frames, SlotsHaveTheSizeThatTheRuntimeWants) {
    runtime("buffer.extra_bytes", "5000");
    runtime("picture.extra_bytes", "100");
    std::optional<Slots> slots(std::in_place, ML2S_STREAM_WORLD_LEFT);
    const auto before = memory_mapped_bytes();
    {
        Sensor world(kWorldLeft);
        const auto frame = next(world);
        EXPECT_EQ(frame.planes[ML2S_PLANE_IMAGE].size_bytes, 1016u * 1016);
        EXPECT_GE(memory_mapped_bytes() - before, 1016u * 1016 + 100 + 5000);
        EXPECT_LT(memory_mapped_bytes() - before, 1016u * 1016 + 100 + 5000 + 128) << "what it aligns included";
    }
    slots.reset();
    EXPECT_EQ(memory_mapped_bytes(), before);
}

TEST_F(Frames, PicturesOutsideTheBufferAreCopied) {
    for (const auto wants : {0u, 0u | ML2S_WANT_CONFIDENCE | ML2S_WANT_FLAGS}) {
        const Slots slots(ML2S_STREAM_DEPTH);
        const auto settings = depthSettings(wants);
        Sensor byOpenXr(settings), bySdk(onSdk(settings));
        runtime("fault.sensor.outside", "/pixelsensor/depth/center");
        for (int i = 0; i < 3; i++) {
            const auto a = next(byOpenXr), b = Only(bySdk.poll());
            expectSamePixels(a, b, ML2S_PLANE_IMAGE, 4);
            if (wants) {
                expectSamePixels(a, b, ML2S_PLANE_CONFIDENCE, 4);
                EXPECT_EQ(flagsAt(a, 0, 0) & 3, flagsAt(b, 0, 0) & 1 ? 2u : 1u);
            }
            runtime("fault.sensor.outside", "");
        }
    }
}

TEST_F(Frames, PaddingAfterAPictureIsNoPartOfIt) {
    runtime("picture.extra_bytes", "100");
    const Shown shown(kEyeNasalLeft);
    EXPECT_EQ(shown.openXr.planes[ML2S_PLANE_IMAGE].size_bytes, 400u * 400);
    expectSamePixels(shown.openXr, shown.sdk, ML2S_PLANE_IMAGE, 1);
}

TEST_F(Frames, AnOddPictureIsSkippedAndARunOfThemIsTold) {
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    Sensor eye(kEyeNasalLeft);
    runtime("fault.sensor.odd", "/pixelsensor/eye/nasal/left");
    expectOdd(eye, "/pixelsensor/eye/nasal/left: 400x200 pixels, configured for 400x400", [&] { return polled(eye); });
    runtime("fault.sensor.odd", "");
    const auto frame = next(eye);
    EXPECT_EQ(frame.skipped, 0u);
}

TEST_F(Frames, ARunningCameraThatFailsIsTold) {
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    Sensor eye(kEyeNasalLeft);
    runtime("fault.sensor.failing", "/pixelsensor/eye/nasal/left");
    EXPECT_TRUE(polled(eye).empty());
    EXPECT_EQ(eye.result, ML2S_VENDOR_FAILURE);
    runtime("fault.sensor.failing", "");
    EXPECT_NE(next(eye).slot, ML2S_NO_SLOT);
}

TEST_F(Frames, ACaptureOlderThanTheRuntimesMemoryHasNoPose) {
    const Slots slots(ML2S_STREAM_WORLD_LEFT);
    Sensor world(kWorldLeft);
    runtime("fault.pose.time_invalid", "1");
    const auto without = next(world);
    EXPECT_FALSE(without.has & ML2S_HAS_POSE);
    EXPECT_TRUE(without.has & ML2S_HAS_INTRINSICS);
    runtime("fault.pose.time_invalid", "0");
    const auto with = next(world);
    EXPECT_TRUE(with.has & ML2S_HAS_POSE);
}

TEST_F(Frames, AnUntrackedHeadsetGivesFramesWithoutPose) {
    headset("fault.head.tracking", "2");
    const Slots slots(ML2S_STREAM_WORLD_LEFT);
    Sensor world(kWorldLeft);
    const auto frame = next(world);
    EXPECT_FALSE(frame.has & ML2S_HAS_POSE);
}

class RunningFrames : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        headset("trajectory", STILL_HEAD);
    }
};

TEST_F(RunningFrames, AStalledCameraDoesNotHoldBackTheOthers) {
    const Slots left(ML2S_STREAM_EYE_NASAL_LEFT), right(ML2S_STREAM_EYE_NASAL_RIGHT);
    auto settings = kEyeNasalLeft;
    settings.streams |= bitOf(ML2S_STREAM_EYE_NASAL_RIGHT);
    Sensor eyes(settings);
    runtime("fault.sensor.stalled", "/pixelsensor/eye/nasal/left");
    constexpr int64_t kTimeout = 10000 * kMillisecond;
    int64_t first = 0, last = 0;
    for (int i = 0; i < 3; i++) {
        const Only got(eyes.poll(kTimeout));
        EXPECT_EQ(got.stream, static_cast<uint32_t>(ML2S_STREAM_EYE_NASAL_RIGHT));
        last = got.device_nanos;
        first = first ? first : last;
    }
    EXPECT_LT(last - first, kTimeout);
}

TEST_F(RunningFrames, StampsAreTheBoottimeOfTheCapture) {
    headset("mltime_skew_ppm", "200");
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    Sensor eye(kEyeNasalLeft);
    const Only got(eye.poll(10000 * kMillisecond));
    EXPECT_NEAR(static_cast<double>(got.capture_nanos - ml2sim_boottime_of_mltime(got.device_nanos)), 0, 50000);
}
