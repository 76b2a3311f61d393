// Frames that are rendered when they are first shown, as a caller sees them.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cameras_fixture.h"

/** Lets MLTime run about a hundred times as fast as this machine's, so that an image is not drawn in time. */
class FastClock {
  public:
    FastClock() {
        thread_ = std::thread([this] {
            while (!isEnding_) {
                ml2sim_advance(10 * kMillisecond);
                std::this_thread::sleep_for(std::chrono::microseconds(100));
            }
        });
    }
    ~FastClock() {
        isEnding_ = true;
        thread_.join();
    }
    FastClock(const FastClock &) = delete;
    FastClock &operator=(const FastClock &) = delete;

  private:
    std::atomic<bool> isEnding_{false};
    std::thread thread_;
};

/** Returns how many captures at 30 Hz are between two. */
int64_t capturesBetween(int64_t first, int64_t second) { return (second - first + kSecond / 60) * 30 / kSecond - 1; }

template <typename Port> class Rendering : public Cameras<Port> {
  protected:
    void SetUp() override {
        Cameras<Port>::SetUp();
        set("seed", "3405"); // of no other test: nothing is drawn yet
    }

    /** The captures between those that a caller gets. */
    struct Missed {
        int64_t unnumbered = 0;
        int64_t counted = 0; ///< By the simulation, before the last get.
    };
    Missed getMany() {
        Missed missed;
        int64_t number = 0, stamp = 0;
        for (int n = 0; n < 30; n++) {
            missed.counted = int64_t(ml2sim_captures_left_out());
            EXPECT_EQ(this->get(100000), MLResult_Ok);
            if (n > 0) {
                const int64_t gap = this->frameNumber() - number - 1;
                missed.unnumbered += capturesBetween(stamp, Port::timestamp(this->data)) - gap;
            }
            number = this->frameNumber();
            stamp = Port::timestamp(this->data);
            EXPECT_EQ(this->release(), MLResult_Ok);
        }
        return missed;
    }
};
TYPED_TEST_SUITE(Rendering, AllPorts);

TYPED_TEST(Rendering, CapturesThatFallDueMeanwhileHaveNoNumberAndAreCounted) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    ASSERT_EQ(this->get(), MLResult_Timeout);
    ASSERT_EQ(ml2sim_captures_left_out(), 0u);
    const FastClock clock;
    const auto missed = this->getMany();
    EXPECT_GT(missed.unnumbered, 0);
    EXPECT_EQ(missed.counted, missed.unnumbered);
}

TYPED_TEST(Rendering, ByARealClockEachCaptureIsDeliveredOrHasANumberOrIsCounted) {
    set("clock", "real");
    set("seed", "3407");
    ASSERT_EQ(this->connect(), MLResult_Ok);
    const auto next = [this] {
        MLResult result = MLResult_Timeout;
        while (result == MLResult_Timeout)
            result = this->get(50);
        EXPECT_EQ(result, MLResult_Ok);
        const std::pair capture(this->frameNumber(), TypeParam::timestamp(this->data));
        EXPECT_EQ(this->release(), MLResult_Ok);
        return capture;
    };
    const auto first = next();
    // A get counts those before its capture, and those that fell due until it returned.
    const auto counted = int64_t(ml2sim_captures_left_out());
    auto last = first;
    int64_t most = counted;
    for (int n = 0; n < 15; n++) {
        last = next();
        most = int64_t(ml2sim_captures_left_out());
    }
    const auto unnumbered = capturesBetween(first.second, last.second) - (last.first - first.first - 1);
    EXPECT_GE(unnumbered, 0);
    EXPECT_LE(unnumbered, most);
    EXPECT_GE(ml2sim_now_mltime() - last.second, 5 * kMillisecond) << "not before it is read out";
}

class WorldRendering : public Cameras<WorldPort> {
  protected:
    MLResult update(uint32_t cameras) {
        auto settings = WorldPort::settings();
        settings.cameras = cameras;
        return WorldPort::updateSettings(handle, &settings);
    }
};

TEST_F(WorldRendering, NewSettingsThatDrawInterruptCapturesButNotTheirNumbers) {
    set("seed", "3406");
    connectAndGet();
    const auto number = frameNumber(), stampBefore = WorldPort::timestamp(data);
    release();
    {
        const FastClock clock;
        ml2sim_advance(kSecond / 10);
        ASSERT_EQ(update(MLWorldCameraIdentifier_Center | MLWorldCameraIdentifier_Left), MLResult_Ok);
    }
    const auto leftOut = ml2sim_captures_left_out();
    EXPECT_GT(leftOut, 0u);
    ml2sim_advance(kSecond / 30 + 10 * kMillisecond);
    ASSERT_EQ(get(), MLResult_Ok);
    int64_t center = 0;
    for (uint8_t i = 0; i < data.frame_count; i++)
        if (data.frames[i].id == MLWorldCameraIdentifier_Center)
            center = data.frames[i].frame_number;
    const auto elapsed = capturesBetween(stampBefore, WorldPort::timestamp(data));
    EXPECT_EQ(center, number + 1 + elapsed - int64_t(leftOut));
}

TEST_F(WorldRendering, NewSettingsOfDrawnImagesLeaveTheNumbersToTheTime) {
    connectAndGet();
    const auto number = frameNumber();
    release();
    ASSERT_EQ(update(MLWorldCameraIdentifier_Center), MLResult_Ok);
    ml2sim_advance(kSecond);
    ASSERT_EQ(get(), MLResult_Ok);
    EXPECT_EQ(frameNumber(), number + 30);
    EXPECT_EQ(ml2sim_captures_left_out(), 0u);
}

class ColorRendering : public SimulatedHeadset {};

TEST_F(ColorRendering, CapturesThatFallDueMeanwhileHaveNoNumberAndAreCounted) {
    set("seed", "3405");
    testing::internal::CaptureStderr();
    const ml2sim_color_request request = {640, 480, 30, 0};
    const FastClock clock;
    ml2sim_color_frame last{}, frame{};
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &last), 0);
    int64_t missing = 0, counted = 0;
    for (int n = 0; n < 10; n++) {
        counted = int64_t(ml2sim_captures_left_out());
        ASSERT_EQ(ml2sim_color(&request, last.next_boottime, &frame), 0);
        EXPECT_EQ(frame.frame_number, last.frame_number + 1);
        missing += capturesBetween(last.capture_mltime, frame.capture_mltime);
        last = frame;
    }
    EXPECT_GT(missing, 0);
    EXPECT_EQ(counted, missing);
    const auto said = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(std::regex_search(said, std::regex("ml2sim: colour camera: [0-9]+ captures left out so far"))) << said;
}

TEST_F(SimulatedHeadset, ACameraKeepsItsFramesInTheFolderOfTheKey) {
    std::string folder = testing::TempDir() + "ml2sim_cache_XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    set("cache", folder.c_str());
    auto settings = EyePort::settings();
    settings.cameras = MLEyeCameraIdentifier_LeftNasal;
    MLHandle handle = 0;
    ASSERT_EQ(MLEyeCameraConnect(&settings, &handle), MLResult_Ok);
    EXPECT_EQ(MLEyeCameraDisconnect(handle), MLResult_Ok);
    std::vector<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::filesystem::remove_all(folder);
    ASSERT_EQ(names.size(), 1u);
    EXPECT_EQ(names[0].rfind("eye_nasal_left-", 0), 0u) << names[0];
}
