// Tests the times of frames, by a clock that only the test moves.
#include <future>

#include "cameras_fixture.h"

template <typename Port> class Timing : public Cameras<Port> {};
TYPED_TEST_SUITE(Timing, AllPorts);

/** All three run at 30 Hz here. */
constexpr int64_t kPeriod = kSecond / 30;

TYPED_TEST(Timing, NothingNewIsATimeout) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    EXPECT_EQ(this->get(), MLResult_Timeout);
}

TYPED_TEST(Timing, AFrameComesOnce) {
    this->connectAndGet();
    const auto number = this->frameNumber();
    this->release();
    EXPECT_EQ(this->get(), MLResult_Timeout);
    ml2sim_advance(kPeriod + 1);
    ASSERT_EQ(this->get(), MLResult_Ok);
    EXPECT_EQ(this->frameNumber(), number + 1);
}

TYPED_TEST(Timing, FramesMissedBySlowPollingLeaveAGap) {
    this->connectAndGet();
    const auto number = this->frameNumber();
    this->release();
    ml2sim_advance(kSecond);
    ASSERT_EQ(this->get(), MLResult_Ok);
    EXPECT_EQ(this->frameNumber(), number + 30);
}

TYPED_TEST(Timing, CapturesAreOnTheGridAndSomeMillisecondsOld) {
    this->connectAndGet();
    const auto stamp = TypeParam::timestamp(this->data);
    const auto index = (stamp * 30 + kSecond - 1) / kSecond;
    EXPECT_EQ(stamp, index * kSecond / 30);
    EXPECT_GT(ml2sim_now_mltime() - stamp, 5 * kMillisecond);
    EXPECT_LT(ml2sim_now_mltime() - stamp, kPeriod + 10 * kMillisecond);
}

TYPED_TEST(Timing, AFrameIsNotThereBeforeItIsReadOut) {
    this->connectAndGet();
    const auto capture = TypeParam::timestamp(this->data) + kSecond;
    this->release();
    ml2sim_advance(capture + kMillisecond - ml2sim_now_mltime());
    ASSERT_EQ(this->get(), MLResult_Ok);
    EXPECT_NEAR(double(TypeParam::timestamp(this->data)), double(capture - kPeriod), 1);
    this->release();
    ml2sim_advance(9 * kMillisecond);
    ASSERT_EQ(this->get(), MLResult_Ok);
    EXPECT_EQ(TypeParam::timestamp(this->data), capture);
}

TYPED_TEST(Timing, AWaitEndsWithTheFrameThatIsDelivered) {
    std::promise<void> connected;
    auto stamp = std::async(std::launch::async, [&] {
        EXPECT_EQ(this->connect(), MLResult_Ok);
        connected.set_value();
        EXPECT_EQ(this->get(1000), MLResult_Ok);
        const auto out = TypeParam::timestamp(this->data);
        this->releaseAndDisconnect();
        return out;
    });
    connected.get_future().wait();
    const auto before = ml2sim_now_mltime();
    ml2sim_advance(2 * kPeriod);
    EXPECT_GT(stamp.get(), before - kPeriod);
}

TYPED_TEST(Timing, AWaitEndsWithItsTimeout) {
    this->setFault("stalled", "1");
    std::promise<void> connected;
    auto result = std::async(std::launch::async, [&] {
        EXPECT_EQ(this->connect(), MLResult_Ok);
        connected.set_value();
        const auto out = this->get(50);
        this->disconnect();
        return out;
    });
    connected.get_future().wait();
    while (result.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready)
        ml2sim_advance(kMillisecond);
    EXPECT_EQ(result.get(), MLResult_Timeout);
}

TYPED_TEST(Timing, EqualTimesShowEqualPixelsAndOtherSeedsOthers) {
    const auto sumOf = [this](const char *seed) {
        ml2sim_reset();
        set("clock", "manual");
        set("loop_seconds", "2");
        set("seed", seed);
        ml2sim_advance(kSecond);
        this->connectAndGet();
        const auto &buffer = TypeParam::buffer(this->data);
        const auto *bytes = static_cast<const uint8_t *>(static_cast<const void *>(buffer.data));
        uint64_t sum = 0;
        for (uint32_t i = 0; i < buffer.size; i++)
            sum = sum * 31 + bytes[i];
        this->releaseAndDisconnect();
        return sum;
    };
    const auto first = sumOf("5");
    EXPECT_EQ(first, sumOf("5"));
    EXPECT_NE(first, sumOf("6"));
}
