// The effect of each fault.<camera>.<what> on a caller.
#include <algorithm>
#include <cmath>
#include <future>
#include <utility>
#include <vector>

#include "cameras_fixture.h"

template <typename Port> class CameraFaults : public Cameras<Port> {};
TYPED_TEST_SUITE(CameraFaults, AllPorts);

TYPED_TEST(CameraFaults, WithoutPermissionOrBrokenItIsNotConnected) {
    for (const auto &[fault, result] :
         {std::pair{"permission", MLResult_PermissionDenied}, std::pair{"connect", MLResult_UnspecifiedFailure}}) {
        this->setFault(fault, "1");
        EXPECT_EQ(this->connect(), result) << fault;
        EXPECT_EQ(this->handle, ML_INVALID_HANDLE);
        this->setFault(fault, "0");
    }
}

TYPED_TEST(CameraFaults, AStalledCameraTimesOutUntilItRunsAgain) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->setFault("stalled", "1");
    ml2sim_advance(kSecond);
    EXPECT_EQ(this->get(), MLResult_Timeout);
    this->setFault("stalled", "0");
    EXPECT_EQ(this->get(), MLResult_Ok);
}

TYPED_TEST(CameraFaults, AFailingGetFailsAndLendsNothing) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->setFault("get", "1");
    ml2sim_advance(kSecond);
    EXPECT_EQ(this->get(), MLResult_UnspecifiedFailure);
    EXPECT_EQ(counters().outstanding_gets, 0u);
}

TYPED_TEST(CameraFaults, ACameraThatGoesAwayEndsTheWaitAndNeedsANewConnection) {
    std::promise<void> connected;
    auto owner = std::async(std::launch::async, [&] {
        EXPECT_EQ(this->connect(), MLResult_Ok);
        connected.set_value();
        EXPECT_EQ(this->get(1000), MLResult_UnspecifiedFailure);
        EXPECT_EQ(this->connect(), MLResult_UnspecifiedFailure);
    });
    connected.get_future().wait();
    const auto first = this->handle;
    this->setFault("disconnected", "1");
    owner.get();
    this->setFault("disconnected", "0");
    ml2sim_reset();
    EXPECT_NE(first, ML_INVALID_HANDLE);
}

TYPED_TEST(CameraFaults, AHandleOfACameraThatWentAwayStaysDead) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->setFault("disconnected", "1");
    EXPECT_EQ(this->get(), MLResult_UnspecifiedFailure);
    this->setFault("disconnected", "0");
    ml2sim_advance(kSecond);
    EXPECT_EQ(this->get(), MLResult_UnspecifiedFailure);
    const auto settings = TypeParam::settings();
    EXPECT_EQ(TypeParam::updateSettings(this->handle, &settings), MLResult_UnspecifiedFailure);
    EXPECT_EQ(this->disconnect(), MLResult_Ok);
    this->connectAndGet();
}

TYPED_TEST(CameraFaults, EveryNthFrameNeverComesAndLeavesAGap) {
    set("trajectory", STILL_HEAD);
    this->setFault("drop_every", "3");
    ASSERT_EQ(this->connect(), MLResult_Ok);
    std::vector<int64_t> numbers;
    for (int tick = 0; tick < 30; tick++) {
        ml2sim_advance(kSecond / 30 + 1);
        if (this->get() != MLResult_Ok)
            continue;
        numbers.push_back(this->frameNumber());
        this->release();
    }
    ASSERT_EQ(numbers.size(), 20u);
    for (size_t i = 2; i < numbers.size(); i++)
        EXPECT_EQ(numbers[i] - numbers[i - 2], 3);
}

TYPED_TEST(CameraFaults, OfFourOddCapturesOneHasAFrameTwice) {
    set("trajectory", STILL_HEAD);
    this->setFault("odd_every", "1");
    ASSERT_EQ(this->connect(), MLResult_Ok);
    std::vector<int> counts;
    while (counts.size() < 8) {
        ml2sim_advance(kSecond / 30 + 1);
        if (this->get() != MLResult_Ok)
            continue;
        counts.push_back(this->data.frame_count);
        this->release();
    }
    const int usual = *std::min_element(counts.begin(), counts.end());
    EXPECT_EQ(std::count(counts.begin(), counts.end(), usual), 6);
    EXPECT_EQ(std::count(counts.begin(), counts.end(), usual + 1), 2);
}

TYPED_TEST(CameraFaults, AFrameCountCanLie) { EXPECT_EQ(this->dataWith("frame_count", "255").frame_count, 255); }

TYPED_TEST(CameraFaults, SizesCanLie) {
    this->setFault("size", "3");
    this->setFault("stride", "5");
    this->setFault("width", "4000000000");
    this->setFault("bytes_per_pixel", "7");
    this->connectAndGet();
    const auto &buffer = TypeParam::buffer(this->data);
    EXPECT_EQ(buffer.size, 3u);
    EXPECT_EQ(buffer.stride, 5u);
    EXPECT_EQ(buffer.width, 4000000000u);
    EXPECT_EQ(TypeParam::bytesPerPixel(this->data), 7u);
}

TYPED_TEST(CameraFaults, PixelsCanBeNull) {
    EXPECT_EQ(TypeParam::buffer(this->dataWith("null_data", "1")).data, nullptr);
}

TYPED_TEST(CameraFaults, FramesCanBeNullThoughTheyAreCounted) {
    const auto &data = this->dataWith("null_frames", "1");
    EXPECT_EQ(data.frames, nullptr);
    EXPECT_GT(data.frame_count, 0);
}

TYPED_TEST(CameraFaults, TheVersionCanChange) {
    const auto version = this->data.version;
    EXPECT_NE(this->dataWith("version", "1").version, version);
}

TYPED_TEST(CameraFaults, TheCameraCanBeUnknown) { EXPECT_EQ(TypeParam::id(this->dataWith("id", "1")), 0x40u); }

template <typename Port> class PoseFaults : public Cameras<Port> {};
using PortsWithPose = testing::Types<DepthPort, WorldPort>;
TYPED_TEST_SUITE(PoseFaults, PortsWithPose);

TYPED_TEST(PoseFaults, PoseAndFocalLengthCanBeNoNumbers) {
    const auto &frame = this->dataWith("not_finite", "1").frames[0];
    EXPECT_TRUE(std::isnan(frame.camera_pose.rotation.w));
    EXPECT_TRUE(std::isinf(frame.camera_pose.position.x));
    EXPECT_TRUE(std::isnan(frame.intrinsics.focal_length.x));
}
