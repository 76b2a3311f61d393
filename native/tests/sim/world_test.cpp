// The properties that only the world cameras have: batches, modes, strides, the double pointer.
#include <cmath>
#include <cstring>
#include <set>
#include <utility>
#include <vector>

#include "cameras_fixture.h"

class World : public Cameras<WorldPort> {
  protected:
    void connectTo(uint32_t cameras, uint32_t mode) {
        auto settings = WorldPort::settings();
        settings.cameras = cameras;
        settings.mode = mode;
        ASSERT_EQ(MLWorldCameraConnect(&settings, &handle), MLResult_Ok);
        ml2sim_advance(100 * kMillisecond);
    }
    double meanOf(const MLWorldCameraFrame &frame) {
        double sum = 0;
        for (uint32_t y = 0; y < frame.frame_buffer.height; y++)
            for (uint32_t x = 0; x < frame.frame_buffer.width; x++)
                sum += frame.frame_buffer.data[y * frame.frame_buffer.stride + x];
        return sum / frame.frame_buffer.width / frame.frame_buffer.height;
    }
};

TEST_F(World, AnInnerPointerThatIsNullIsRefused) {
    ASSERT_EQ(connect(), MLResult_Ok);
    MLWorldCameraData *inner = nullptr;
    EXPECT_EQ(MLWorldCameraGetLatestWorldCameraData(handle, 0, &inner), MLResult_InvalidParam);
    EXPECT_EQ(MLWorldCameraGetLatestWorldCameraData(handle, 0, nullptr), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT, 2);
}

TEST_F(World, RowsArePaddedAndThePaddingIsNoPicture) {
    connectAndGet();
    const auto &buffer = data.frames[0].frame_buffer;
    EXPECT_EQ(buffer.width, 1016u);
    EXPECT_EQ(buffer.height, 1016u);
    EXPECT_EQ(buffer.stride, 1024u);
    EXPECT_EQ(buffer.size, 1024u * 1016u);
    for (uint32_t x = 1016; x < 1024; x++)
        EXPECT_EQ(buffer.data[1024 * 500 + x], 0xee);
}

TEST_F(World, StillImagesRepeatOneFrameWhilePosesGoOn) {
    set("still_images", "1");
    connectAndGet();
    const auto first = data.frames[0];
    const std::vector<uint8_t> pixels(first.frame_buffer.data, first.frame_buffer.data + first.frame_buffer.size);
    release();
    ml2sim_advance(300 * kMillisecond);
    ASSERT_EQ(get(), MLResult_Ok);
    EXPECT_EQ(std::memcmp(pixels.data(), data.frames[0].frame_buffer.data, pixels.size()), 0);
    EXPECT_GT(data.frames[0].timestamp, first.timestamp);
    EXPECT_NE(data.frames[0].camera_pose.position.x, first.camera_pose.position.x);
}

TEST_F(World, ThePaddingOfRowsIsAKeyAndMovesNoPixel) {
    connectAndGet();
    const auto &padded = data.frames[0].frame_buffer;
    std::vector<uint8_t> row(padded.data + 700 * padded.stride, padded.data + 700 * padded.stride + 1016);
    const auto shown = data.frames[0].timestamp;
    release();
    set("stride_padding", "0");
    ml2sim_advance(2 * kSecond); // one loop
    ASSERT_EQ(get(), MLResult_Ok);
    EXPECT_EQ(data.frames[0].timestamp, shown + 2 * kSecond);
    EXPECT_EQ(data.frames[0].frame_buffer.stride, 1016u);
    EXPECT_EQ(std::memcmp(row.data(), data.frames[0].frame_buffer.data + 700 * 1016, 1016), 0);
}

TEST_F(World, ABatchHasOneFramePerCameraAndModeOfOneInstant) {
    set("controller_tracked", "1");
    connectTo(MLWorldCameraIdentifier_All, MLWorldCameraMode_LowExposure | MLWorldCameraMode_NormalExposure);
    ASSERT_EQ(get(), MLResult_Ok);
    ASSERT_EQ(data.frame_count, 6);
    std::set<std::pair<uint32_t, uint32_t>> kinds;
    std::set<int64_t> numbers;
    for (int i = 0; i < 6; i++) {
        kinds.insert({data.frames[i].id, data.frames[i].frame_type});
        numbers.insert(data.frames[i].frame_number);
        EXPECT_EQ(data.frames[i].timestamp, data.frames[0].timestamp);
    }
    EXPECT_EQ(kinds.size(), 6u);
    EXPECT_EQ(numbers.size(), 6u) << "every camera and mode counts for itself";
}

TEST_F(World, LowExposureComesOnlyWhileTheControllerIsTracked) {
    connectTo(MLWorldCameraIdentifier_Left, MLWorldCameraMode_LowExposure);
    EXPECT_EQ(get(), MLResult_Timeout);
    set("controller_tracked", "1");
    ASSERT_EQ(get(), MLResult_Ok);
    EXPECT_EQ(data.frames[0].frame_type, MLWorldCameraFrameType_LowExposure);
    release();
    set("controller_tracked", "0");
    ml2sim_advance(kSecond);
    EXPECT_EQ(get(), MLResult_Timeout);
}

TEST_F(World, LowExposureIsDarker) {
    set("controller_tracked", "1");
    connectTo(MLWorldCameraIdentifier_Left, MLWorldCameraMode_LowExposure | MLWorldCameraMode_NormalExposure);
    ASSERT_EQ(get(), MLResult_Ok);
    ASSERT_EQ(data.frame_count, 2);
    ASSERT_EQ(data.frames[1].frame_type, MLWorldCameraFrameType_LowExposure);
    EXPECT_LT(meanOf(data.frames[1]), 0.5 * meanOf(data.frames[0]));
}

TEST_F(World, OtherSettingsChangeTheCamerasOfTheNextBatch) {
    connectAndGet();
    release();
    auto settings = WorldPort::settings();
    settings.cameras = MLWorldCameraIdentifier_Left | MLWorldCameraIdentifier_Right;
    ASSERT_EQ(MLWorldCameraUpdateSettings(handle, &settings), MLResult_Ok);
    ml2sim_advance(100 * kMillisecond);
    ASSERT_EQ(get(), MLResult_Ok);
    ASSERT_EQ(data.frame_count, 2);
    EXPECT_EQ(data.frames[0].id | data.frames[1].id, 3u);
}

TEST_F(World, UnknownCamerasAndModesAreRefused) {
    auto settings = WorldPort::settings();
    settings.cameras = 8;
    EXPECT_EQ(MLWorldCameraConnect(&settings, &handle), MLResult_InvalidParam);
    settings = WorldPort::settings();
    settings.mode = 0;
    EXPECT_EQ(MLWorldCameraConnect(&settings, &handle), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT, 2);
}

TEST_F(World, ThePoseIsThatOfTheCaptureAndTangentialTermsAreToldAsSet) {
    set("tangential", "0.001");
    connectAndGet();
    const auto &frame = data.frames[0];
    ml2sim_pose truth;
    ASSERT_EQ(ml2sim_true_pose(ML2SIM_WORLD_CENTER, frame.timestamp, &truth), 0);
    EXPECT_NEAR(frame.camera_pose.position.x, truth.position[0], 1e-6);
    EXPECT_NEAR(frame.camera_pose.position.z, truth.position[2], 1e-6);
    EXPECT_NEAR(frame.camera_pose.rotation.w, truth.rotation[3], 1e-6);
    EXPECT_EQ(frame.intrinsics.tangential_distortion[0], 0.001);
    EXPECT_EQ(frame.intrinsics.tangential_distortion[1], 0.001);
}

TEST_F(World, WhileLostThePoseStaysWhereItWas) {
    MLTransform atLoss;
    connectAndGet();
    release();
    set("fault.head.tracking", "1");
    const auto lostAt = ml2sim_now_mltime();
    for (int i = 0; i < 2; i++) {
        ml2sim_advance(300 * kMillisecond);
        ASSERT_EQ(get(), MLResult_Ok);
        if (i > 0) {
            EXPECT_EQ(std::memcmp(&atLoss, &data.frames[0].camera_pose, sizeof atLoss), 0);
        }
        atLoss = data.frames[0].camera_pose;
        release();
    }
    ml2sim_pose truth;
    ml2sim_true_pose(ML2SIM_WORLD_CENTER, lostAt, &truth);
    EXPECT_NEAR(atLoss.position.x, truth.position[0], 1e-6);
}

TEST_F(World, KeysThatShapeTheSceneRestWhileACameraIsOpen) {
    ASSERT_EQ(connect(), MLResult_Ok);
    EXPECT_STREQ(ml2sim_set("seed", "9"), "seed: cannot change while a camera is open");
    disconnect();
    EXPECT_EQ(ml2sim_set("seed", "9"), nullptr);
}
