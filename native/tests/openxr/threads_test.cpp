// Sensors of several threads in one session.
#include <atomic>
#include <future>
#include <thread>

#include "app.h"

class Threads : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        headset("trajectory", STILL_HEAD);
    }
};

TEST_F(Threads, SensorsOfSeveralThreadsComeAndGoInOneSession) {
    constexpr int kRounds = 5;
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    std::atomic<int> frames{0}, poses{0};
    const auto pollPoses = [&](const ml2s_settings &settings) {
        for (int round = 0; round < kRounds; round++) {
            Sensor sensor(settings);
            for (int i = 0; i < 10; i++) {
                poses += sensor.pollReading().is_tracked;
            }
        }
    };
    const auto pollFrames = [&] {
        for (int round = 0; round < kRounds; round++) {
            Sensor eye(kEyeNasalLeft);
            frames += static_cast<int>(eye.poll(10000 * kMillisecond).size());
        }
    };
    std::thread head(pollPoses, kHead), gaze(pollPoses, kGaze), controller(pollPoses, kController), eyes(pollFrames);
    head.join();
    gaze.join();
    controller.join();
    eyes.join();
    EXPECT_EQ(frames, kRounds);
    EXPECT_EQ(poses, 3 * kRounds * 10);
}

TEST_F(Threads, FramesAreReadWhileTheNextAreWritten) {
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    std::atomic<bool> isDone{false};
    std::thread reader([&] { readAll(ML2S_STREAM_EYE_NASAL_LEFT, isDone); });
    {
        Sensor eye(kEyeNasalLeft);
        for (int i = 0; i < 15; i++) {
            for (const auto &frame : eye.poll(10000 * kMillisecond)) {
                if (frame.slot != ML2S_NO_SLOT) {
                    EXPECT_EQ(ml2s_publish(&frame), ML2S_OK);
                }
            }
        }
    }
    isDone = true;
    reader.join();
}

TEST_F(Threads, ASensorThatIsStillStartingIsGivenUpWhenTheAppsSessionEnds) {
    App app(kAll);
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    runtime("fault.future.stuck", "1");
    std::promise<uint32_t> isOpen;
    std::thread sensors([&] {
        const Sensor head(kHead);
        isOpen.set_value(counters().live_objects);
        expectRefused(kEyeNasalLeft, ML2S_VENDOR_FAILURE, "the app is ending its OpenXR session");
    });
    const auto before = isOpen.get_future().get();
    while (counters().live_objects < before + 2) { // the camera and its future
        std::this_thread::yield();
    }
    auto error = sized<ml2s_error>();
    EXPECT_EQ(ml2s_use_openxr(nullptr, &error), ML2S_OK) << error.message;
    sensors.join();
}

TEST_F(Threads, TheAppDoesNotWaitForASessionThatDoesNotBegin) {
    runtime("fault.session.idle", "1");
    auto opened = std::async(std::launch::async, [] { return Sensor(kHead).result; });
    while (counters().live_objects == 0) {
        std::this_thread::yield();
    }
    auto error = sized<ml2s_error>();
    auto openxr = sized<ml2s_openxr>();
    openxr.loader_path = "another";
    EXPECT_EQ(ml2s_use_openxr(&openxr, &error), ML2S_BUSY);
    EXPECT_EQ(opened.wait_for(std::chrono::seconds(0)), std::future_status::timeout) << "it has been waited for";
    EXPECT_EQ(opened.get(), ML2S_VENDOR_FAILURE);
}

TEST_F(Threads, BeforeTheAppsSessionEndsPollsFailUntilAllIsClosed) {
    App app(kAll);
    app.createSession();
    const auto appsOwn = counters().live_objects;
    ASSERT_EQ(app.lend(), ML2S_OK);
    std::promise<void> isPolled;
    std::thread sensors([&] {
        Sensor head(kHead);
        isPolled.set_value();
        do {
            head.pollReading();
        } while (head.result != ML2S_VENDOR_FAILURE);
        EXPECT_STREQ(head.error.message, "the app is ending its OpenXR session");
        expectRefused(kHands, ML2S_VENDOR_FAILURE, "the app is ending its OpenXR session");
    });
    isPolled.get_future().wait();
    auto error = sized<ml2s_error>();
    EXPECT_EQ(ml2s_use_openxr(nullptr, &error), ML2S_OK) << error.message;
    EXPECT_EQ(counters().live_objects, appsOwn);
    sensors.join();
    expectRefused(kHead, ML2S_NOT_AVAILABLE, "not available: OpenXR (ml2s_use_openxr was not called)");
}
