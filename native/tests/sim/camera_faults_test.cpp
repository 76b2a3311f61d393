// What a caller sees of each fault.<camera>.<what>.
#include <cmath>
#include <future>

#include "cameras_fixture.h"

template <typename Port> class CameraFaults : public Cameras<Port> {};
TYPED_TEST_SUITE(CameraFaults, AllPorts);

TYPED_TEST(CameraFaults, WithoutPermissionConnectIsDenied) {
    this->setFault("permission", "1");
    EXPECT_EQ(this->connect(), MLResult_PermissionDenied);
    EXPECT_EQ(this->handle, ML_INVALID_HANDLE);
}

TYPED_TEST(CameraFaults, ABrokenCameraFailsToConnect) {
    this->setFault("connect", "1");
    EXPECT_EQ(this->connect(), MLResult_UnspecifiedFailure);
    EXPECT_EQ(this->handle, ML_INVALID_HANDLE);
}

TYPED_TEST(CameraFaults, AStalledCameraTimesOutUntilItRunsAgain) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->setFault("stalled", "1");
    ml2sim_advance(kSecond);
    EXPECT_EQ(this->get(), MLResult_Timeout);
    this->setFault("stalled", "0");
    EXPECT_EQ(this->get(), MLResult_Ok);
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, AFailingGetFailsAndLendsNothing) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->setFault("get", "1");
    ml2sim_advance(kSecond);
    EXPECT_EQ(this->get(), MLResult_UnspecifiedFailure);
    EXPECT_EQ(counters().outstanding_gets, 0u);
    this->disconnect();
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
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, EveryNthFrameNeverComes) {
    set("trajectory", STILL_HEAD);
    this->setFault("drop_every", "3");
    ASSERT_EQ(this->connect(), MLResult_Ok);
    int frames = 0;
    for (int tick = 0; tick < 30; tick++) {
        ml2sim_advance(kSecond / 30 + 1);
        if (this->get() != MLResult_Ok)
            continue;
        frames++;
        this->release();
    }
    EXPECT_EQ(frames, 20);
    this->disconnect();
}

TYPED_TEST(CameraFaults, AFrameCountCanLie) {
    this->setFault("frame_count", "255");
    this->connectAndGet();
    EXPECT_EQ(this->data.frame_count, 255);
    this->releaseAndDisconnect();
}

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
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, PixelsCanBeNull) {
    this->setFault("null_data", "1");
    this->connectAndGet();
    EXPECT_EQ(TypeParam::buffer(this->data).data, nullptr);
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, FramesCanBeNullThoughTheyAreCounted) {
    this->setFault("null_frames", "1");
    this->connectAndGet();
    EXPECT_EQ(this->data.frames, nullptr);
    EXPECT_GT(this->data.frame_count, 0);
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, TheVersionCanChange) {
    this->setFault("version", "1");
    const auto version = this->data.version;
    this->connectAndGet();
    EXPECT_NE(this->data.version, version);
    this->releaseAndDisconnect();
}

TYPED_TEST(CameraFaults, TheCameraCanBeUnknown) {
    this->setFault("id", "1");
    this->connectAndGet();
    EXPECT_EQ(TypeParam::id(this->data), 0x40u);
    this->releaseAndDisconnect();
}

template <typename Port> class PoseFaults : public Cameras<Port> {};
using PortsWithPose = testing::Types<DepthPort, WorldPort>;
TYPED_TEST_SUITE(PoseFaults, PortsWithPose);

TYPED_TEST(PoseFaults, PoseAndFocalLengthCanBeNoNumbers) {
    this->setFault("not_finite", "1");
    this->connectAndGet();
    const auto &frame = this->data.frames[0];
    EXPECT_TRUE(std::isnan(frame.camera_pose.rotation.w));
    EXPECT_TRUE(std::isinf(frame.camera_pose.position.x));
    EXPECT_TRUE(std::isnan(frame.intrinsics.focal_length.x));
    this->releaseAndDisconnect();
}
