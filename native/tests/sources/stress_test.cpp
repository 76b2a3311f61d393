// All cameras of the simulated headset at their own pace, each polled by its own thread, with consumers that are slow,
// fast, or end holding a frame: nothing waits for them, and every slot, frame and handle comes back.
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "ml2sim.h"
#include "sensor.h"

namespace {

constexpr int kFrames = 20;
constexpr uint64_t kTimeoutNanos = 10000000000;

struct Stream {
    ml2s_sensor sensor;
    ml2s_stream stream;
    uint32_t slot_bytes;
    bool isSecond; ///< Short range, which is faster.
};

constexpr Stream kStreams[] = {
    {ML2S_SENSOR_DEPTH, ML2S_STREAM_DEPTH, 544 * 480 * 4, true},
    {ML2S_SENSOR_WORLD, ML2S_STREAM_WORLD_RIGHT, 1016 * 1016, false},
    {ML2S_SENSOR_EYE, ML2S_STREAM_EYE_NASAL_RIGHT, 400 * 400, false},
};

struct Count {
    int delivered = 0;
    int lost = 0;
};

/** A headset whose clock runs faster than the machine's, so that no capture is waited for. */
class Stress : public testing::Test {
  protected:
    void SetUp() override {
        ml2sim_reset();
        ASSERT_EQ(ml2sim_set("clock", "manual"), nullptr);
        ASSERT_EQ(ml2sim_set("loop_seconds", "2"), nullptr);
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
        ml2sim_counters counters;
        ml2sim_get_counters(&counters);
        EXPECT_STREQ(counters.last_misuse, "");
        EXPECT_EQ(counters.open_handles + counters.outstanding_gets, 0u);
    }

  private:
    static constexpr int64_t kPeriodNanos = 1000000000 / 30;
    std::atomic<bool> isDone_ = false;
    std::thread clock_;
};

/** Polls until enough frames came, publishing each; every poll must end with a frame, delivered or lost. */
Count capture(const Stream &stream) {
    const uint64_t bit = ML2S_STREAM_BIT(stream.stream);
    auto settings = settingsOf(stream.sensor, bit, stream.isSecond ? bit : 0);
    settings.rate_hz = stream.isSecond ? 30 : 5;
    Sensor sensor(settings);
    Count count;
    while (count.delivered + count.lost < kFrames) {
        const auto frames = sensor.poll(kTimeoutNanos);
        EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        if (frames.size() != 1) {
            break;
        }
        if (frames[0].slot == ML2S_NO_SLOT) {
            count.lost++;
            continue;
        }
        count.delivered++;
        EXPECT_EQ(ml2s_publish(&frames[0]), ML2S_OK);
        release(frames);
    }
    return count;
}

/** Reads every byte of a leased frame. */
std::vector<uint8_t> imageOf(const ml2s_frame &frame) {
    const auto &plane = frame.planes[ML2S_PLANE_IMAGE];
    const auto *begin = frame.data + plane.offset_bytes;
    return {begin, begin + plane.size_bytes};
}

class Consumers {
  public:
    explicit Consumers(const Stream &stream) : stream_(stream.stream) {
        for (auto task : {&Consumers::readFast, &Consumers::readSlow, &Consumers::leaseAndDie}) {
            threads_.emplace_back([this, task] { (this->*task)(); });
        }
    }
    void finish() {
        isDone_ = true;
        for (auto &thread : threads_) {
            thread.join();
        }
        release(abandoned_);
    }

  private:
    std::optional<ml2s_frame> next(int64_t after_nanos) {
        auto frame = sized<ml2s_frame>();
        while (!isDone_) {
            if (ml2s_acquire_latest(stream_, after_nanos, &frame) == ML2S_OK) {
                EXPECT_GT(frame.capture_nanos, after_nanos);
                return frame;
            }
            std::this_thread::yield();
        }
        return std::nullopt;
    }
    void readFast() {
        int64_t last = 0;
        while (const auto frame = next(last)) {
            last = frame->capture_nanos;
            EXPECT_FALSE(imageOf(*frame).empty());
            release({*frame});
        }
    }
    /** Holds every frame until another has come. */
    void readSlow() {
        int64_t last = 0;
        while (const auto frame = next(last)) {
            last = frame->capture_nanos;
            const auto image = imageOf(*frame);
            if (const auto newer = next(last)) {
                release({*newer});
            }
            EXPECT_TRUE(imageOf(*frame) == image) << "a leased frame was written to";
            release({*frame});
        }
    }
    void leaseAndDie() {
        if (const auto frame = next(0)) {
            abandoned_.push_back(*frame);
        }
    }

    const uint32_t stream_;
    std::atomic<bool> isDone_ = false;
    std::vector<ml2s_frame> abandoned_;
    std::vector<std::thread> threads_;
};

} // namespace

TEST_F(Stress, ConsumersOfAnyKindNeitherStallACameraNorLeakAnything) {
    std::vector<std::thread> captures;
    for (const auto &stream : kStreams) {
        captures.emplace_back([&stream] {
            // The latest, the writer's next, two of the slow, one each of the fast and the dead.
            const Slots slots(stream.stream, 6, stream.slot_bytes);
            Consumers consumers(stream);
            const auto count = capture(stream);
            consumers.finish();
            EXPECT_EQ(count.delivered, kFrames);
            EXPECT_EQ(count.lost, 0);
        });
    }
    for (auto &thread : captures) {
        thread.join();
    }
}

TEST_F(Stress, AConsumerThatHoldsEverySlotCostsFramesAndNothingElse) {
    const auto &stream = kStreams[2];
    const Slots slots(stream.stream, 2, stream.slot_bytes);
    uint32_t held[2];
    ml2s_memory memory;
    for (auto &slot : held) {
        ASSERT_EQ(ml2s_take(stream.stream, &slot, &memory), ML2S_OK);
    }
    const auto count = capture(stream);
    EXPECT_EQ(count.lost, kFrames);
    for (const auto slot : held) {
        EXPECT_EQ(ml2s_release(stream.stream, slot), ML2S_OK);
    }
}
