// All cameras of the simulated headset at their own pace, each polled by its own thread and read by another: every
// slot, frame and handle comes back. slots_test.cpp has readers that are slow or end holding a frame.
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "../sim/headset.h"
#include "sensor.h"

namespace {

constexpr int kFrames = 20;
constexpr uint64_t kTimeoutNanos = 10000000000;

struct Stream {
    ml2s_sensor sensor;
    ml2s_stream stream;
    bool isSecond; ///< Short range, which is faster.
};

constexpr Stream kStreams[] = {
    {ML2S_SENSOR_DEPTH, ML2S_STREAM_DEPTH, true},
    {ML2S_SENSOR_WORLD, ML2S_STREAM_WORLD_RIGHT, false},
    {ML2S_SENSOR_EYE, ML2S_STREAM_EYE_NASAL_RIGHT, false},
};

/** A headset whose clock runs faster than the machine's, so that no capture is waited for. */
class Stress : public testing::Test {
  protected:
    void SetUp() override {
        ml2sim_reset();
        set("clock", "manual");
        set("loop_seconds", "2");
        clock_ = std::thread([this] {
            while (!isDone_) {
                ml2sim_advance(kPeriodNanos);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        });
    }
    void TearDown() override {
        isDone_ = true;
        clock_.join();
        const auto left = counters();
        EXPECT_STREQ(left.last_misuse, "");
        EXPECT_EQ(left.open_handles + left.outstanding_gets, 0u);
    }

  private:
    static constexpr int64_t kPeriodNanos = 1000000000 / 30;
    std::atomic<bool> isDone_ = false;
    std::thread clock_;
};

/** Polls until enough frames came, publishing each; every poll must end with one. */
void capture(const Stream &stream) {
    const uint64_t bit = ML2S_STREAM_BIT(stream.stream);
    auto settings = settingsOf(stream.sensor, bit, stream.isSecond ? bit : 0);
    settings.rate_hz = stream.isSecond ? 30 : 5;
    Sensor sensor(settings);
    for (int i = 0; i < kFrames; i++) {
        const auto frames = sensor.poll(kTimeoutNanos);
        ASSERT_EQ(frames.size(), 1u) << sensor.error.message;
        ASSERT_NE(frames[0].slot, ML2S_NO_SLOT);
        EXPECT_EQ(ml2s_publish(&frames[0]), ML2S_OK);
    }
}

} // namespace

TEST_F(Stress, CamerasOfSeveralThreadsDeliverEveryFrameWhileOthersRead) {
    std::vector<std::thread> captures;
    for (const auto &stream : kStreams) {
        captures.emplace_back([&stream] {
            const Slots slots(stream.stream);
            std::atomic<bool> isDone = false;
            std::thread reader([&] { readAll(stream.stream, isDone); });
            capture(stream);
            isDone = true;
            reader.join();
        });
    }
    for (auto &thread : captures) {
        thread.join();
    }
}
