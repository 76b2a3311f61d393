// The library's own instance and session: what is missing is named, and nothing outlives the last sensor.
#include "app.h"

class Standalone : public OpenXr {};

TEST_F(Standalone, AMissingLoaderIsNamed) {
    ASSERT_EQ(useLoader("libno_such_loader.so"), ML2S_OK);
    const Sensor head(kHead);
    EXPECT_EQ(head.result, ML2S_NOT_AVAILABLE);
    EXPECT_EQ(std::string(head.error.message).find("not available: libno_such_loader.so ("), 0u) << head.error.message;
}

TEST_F(Standalone, ALibraryThatIsNoLoaderIsNamed) {
    ASSERT_EQ(useLoader("libm.so.6"), ML2S_OK);
    expectRefused(kHead, ML2S_NOT_AVAILABLE, "not available: libm.so.6/xrGetInstanceProcAddr");
}

TEST_F(Standalone, AMissingRuntimeIsNotAvailable) {
    setenv("XR_RUNTIME_JSON", "/no/such/runtime.json", 1);
    expectRefused(kHead, ML2S_NOT_AVAILABLE, "not available: OpenXR runtime");
}

TEST_F(Standalone, AMissingExtensionIsNamedForExactlyTheSensorsThatNeedIt) {
    struct Case {
        std::string extension;
        bool pixels, head, gaze, hands;
    };
    stopTime();
    for (const auto &missing :
         {Case{"XR_MND_headless", true, true, true, true}, Case{"XR_KHR_convert_timespec_time", true, true, true, true},
          Case{"XR_ML_pixel_sensor", true, false, false, false}, Case{"XR_EXT_future", true, false, false, false},
          Case{"XR_EXT_eye_gaze_interaction", false, false, true, false},
          Case{"XR_EXT_hand_tracking", false, false, false, true}}) {
        runtime("fault.extension.missing", missing.extension.c_str());
        const auto expect = [&](const ml2s_settings &settings, bool isMissed) {
            expectRefused(settings, isMissed ? ML2S_NOT_AVAILABLE : ML2S_OK,
                          isMissed ? "not available: " + missing.extension : "");
        };
        expect(kEyeNasalLeft, missing.pixels);
        expect(kHead, missing.head);
        expect(kGaze, missing.gaze);
        expect(kHands, missing.hands);
        // The loader remembers what the runtime offers until an instance ends.
        const App app({});
    }
}

TEST_F(Standalone, AllSensorsShareOneInstanceThatEndsWithTheLast) {
    stopTime();
    {
        const Sensor head(kHead), hands(kHands), gaze(kGaze), eye(kEyeNasalLeft);
        EXPECT_EQ(counters().instances_created, 1u);
        EXPECT_EQ(counters().sessions_created, 1u);
    }
    EXPECT_EQ(counters().live_objects, 0u);
    const Sensor again(kHead);
    EXPECT_EQ(again.result, ML2S_OK);
    EXPECT_EQ(counters().instances_created, 2u);
}

TEST_F(Standalone, AnInstanceThatCannotBeMadeIsAFailureOfTheVendor) {
    runtime("fault.instance.fails", "1");
    const Sensor head(kHead);
    EXPECT_EQ(head.result, ML2S_VENDOR_FAILURE);
    EXPECT_EQ(std::string(head.error.message), "xrCreateInstance: XrResult (-2)");
    EXPECT_EQ(head.error.vendor_code, -2);
}

TEST_F(Standalone, AnInstanceOfTheAppIsAskedFor) {
    const App app({});
    expectRefused(kHead, ML2S_BUSY, "this app has an OpenXR instance already: give it to ml2s_use_openxr");
}

TEST_F(Standalone, ASessionThatDoesNotGetReadyIsGivenUp) {
    runtime("fault.session.idle", "1");
    expectRefused(kHead, ML2S_VENDOR_FAILURE, "the OpenXR session was not ready within 5 s");
}

TEST_F(Standalone, ASessionThatIsStoppedGoesOnWhenTheRuntimeLetsIt) {
    Sensor gaze(kGaze);
    EXPECT_TRUE(gaze.pollReading().is_tracked);
    runtime("fault.session.stopping", "1");
    EXPECT_FALSE(gaze.pollReading().is_tracked);
    EXPECT_EQ(gaze.result, ML2S_OK);
    runtime("fault.session.stopping", "0");
    EXPECT_TRUE(gaze.pollReading().is_tracked);
}

TEST_F(Standalone, ALostSessionIsSaidAndComesBackWhenAllIsOpenedAgain) {
    {
        Sensor head(kHead), hands(kHands);
        runtime("fault.session.lost", "1");
        for (auto *sensor : {&head, &hands}) {
            sensor->pollReading();
            EXPECT_EQ(sensor->result, ML2S_VENDOR_FAILURE);
            EXPECT_EQ(std::string(sensor->error.message),
                      "the OpenXR session is lost: close all its sensors and open them again");
        }
    }
    runtime("fault.session.lost", "0");
    Sensor head(kHead);
    EXPECT_TRUE(head.pollReading().is_tracked);
}

TEST_F(Standalone, ChangingTheWayToOpenXrNeedsAllItsSensorsClosed) {
    const Sensor head(kHead);
    EXPECT_EQ(useLoader(kLoader), ML2S_BUSY);
}

TEST_F(Standalone, EitherALoaderOrTheAppsSessionIsExpected) {
    auto openxr = sized<ml2s_openxr>();
    auto error = sized<ml2s_error>();
    EXPECT_EQ(ml2s_use_openxr(&openxr, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(std::string(error.message),
              "ml2s_openxr: expected either loader_path or instance, session and get_instance_proc_addr");
    openxr.instance = openxr.session = 1;
    EXPECT_EQ(ml2s_use_openxr(&openxr, &error), ML2S_INVALID_ARGUMENT);
    openxr.get_instance_proc_addr = reinterpret_cast<void *>(1);
    openxr.loader_path = kLoader;
    EXPECT_EQ(ml2s_use_openxr(&openxr, &error), ML2S_INVALID_ARGUMENT);
    openxr.struct_size = 4;
    EXPECT_EQ(ml2s_use_openxr(&openxr, &error), ML2S_INVALID_ARGUMENT);
}
