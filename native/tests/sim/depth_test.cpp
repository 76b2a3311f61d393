// The properties that only the depth camera has: modes, planes, capabilities, distance.
#include "cameras_fixture.h"
#include "ml_unused.h"

class Depth : public Cameras<DepthPort> {
  protected:
    static constexpr uint32_t kEverything = 0x1f;

    MLResult connectTo(MLDepthCameraFrameType type, MLDepthCameraFrameRate rate, uint32_t exposure, uint32_t flags) {
        auto settings = DepthPort::settings();
        settings.streams = 1u << type;
        settings.stream_configs[type] = {flags, exposure, rate};
        return MLDepthCameraConnect(&settings, &handle);
    }
    MLResult connectShort(uint32_t flags) {
        return connectTo(MLDepthCameraFrameType_ShortRange, MLDepthCameraFrameRate_30FPS, 375, flags);
    }
    void getOf(uint32_t flags) {
        ASSERT_EQ(connectShort(flags), MLResult_Ok);
        ml2sim_advance(100 * kMillisecond);
        ASSERT_EQ(get(), MLResult_Ok);
    }
    MLDepthCameraCapabilityList capabilitiesOf(MLDepthCameraStream stream) {
        auto filter = initialised(MLDepthCameraCapabilityFilterInit);
        filter.streams = stream;
        MLDepthCameraCapabilityList list{};
        EXPECT_EQ(MLDepthCameraGetCapabilities(handle, &filter, &list), MLResult_Ok);
        return list;
    }
    /** Frames that come in two seconds of one mode. */
    int framesIn2Seconds(MLDepthCameraFrameType type, MLDepthCameraFrameRate rate, uint32_t exposure) {
        if (connectTo(type, rate, exposure, MLDepthCameraFlags_DepthFlags) != MLResult_Ok)
            return -1;
        int frames = 0;
        for (int i = 0; i < 400; i++) {
            ml2sim_advance(5 * kMillisecond);
            if (get() != MLResult_Ok)
                continue;
            frames++;
            release();
        }
        disconnect();
        return frames;
    }
};

TEST_F(Depth, EveryLegalRateIsDelivered) {
    set("trajectory", STILL_HEAD);
    const auto longRange = MLDepthCameraFrameType_LongRange, shortRange = MLDepthCameraFrameType_ShortRange;
    EXPECT_EQ(framesIn2Seconds(longRange, MLDepthCameraFrameRate_1FPS, 1600), 2);
    EXPECT_EQ(framesIn2Seconds(longRange, MLDepthCameraFrameRate_5FPS, 1600), 10);
    EXPECT_EQ(framesIn2Seconds(shortRange, MLDepthCameraFrameRate_5FPS, 375), 10);
    EXPECT_EQ(framesIn2Seconds(shortRange, MLDepthCameraFrameRate_25FPS, 375), 50);
    EXPECT_EQ(framesIn2Seconds(shortRange, MLDepthCameraFrameRate_30FPS, 375), 60);
    EXPECT_EQ(framesIn2Seconds(shortRange, MLDepthCameraFrameRate_50FPS, 375), 100);
    EXPECT_EQ(framesIn2Seconds(shortRange, MLDepthCameraFrameRate_60FPS, 375), 120);
}

TEST_F(Depth, RatesAndExposuresOutOfTheTablesAreRefused) {
    const uint32_t flags = MLDepthCameraFlags_DepthImage;
    const auto longRange = MLDepthCameraFrameType_LongRange, shortRange = MLDepthCameraFrameType_ShortRange;
    EXPECT_EQ(connectTo(longRange, MLDepthCameraFrameRate_30FPS, 1600, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(shortRange, MLDepthCameraFrameRate_1FPS, 375, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(longRange, MLDepthCameraFrameRate_5FPS, 249, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(longRange, MLDepthCameraFrameRate_5FPS, 2001, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(shortRange, MLDepthCameraFrameRate_5FPS, 49, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(shortRange, MLDepthCameraFrameRate_5FPS, 376, flags), MLResult_InvalidParam);
    EXPECT_EQ(connectTo(shortRange, MLDepthCameraFrameRate_5FPS, 375, 0), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT, 7);
}

TEST_F(Depth, TwoStreamsAtOnceAreRefused) {
    auto settings = DepthPort::settings();
    settings.streams = 3;
    EXPECT_EQ(MLDepthCameraConnect(&settings, &handle), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT);
}

TEST_F(Depth, OnlyTheBuffersThatWereAskedForAreThere) {
    getOf(MLDepthCameraFlags_Confidence | MLDepthCameraFlags_RawDepthImage);
    const auto &frame = data.frames[0];
    EXPECT_EQ(frame.depth_image, nullptr);
    EXPECT_NE(frame.confidence, nullptr);
    EXPECT_EQ(frame.flags, nullptr);
    EXPECT_EQ(frame.ambient_raw_depth_image, nullptr);
    EXPECT_NE(frame.raw_depth_image, nullptr);
}

TEST_F(Depth, APixelWithAnyFlagIsInvalidAndLightAddsToTheAmbient) {
    getOf(kEverything);
    const auto &frame = data.frames[0];
    const auto *flags = static_cast<const uint32_t *>(frame.flags->data);
    const auto *raw = static_cast<const float *>(frame.raw_depth_image->data);
    const auto *ambient = static_cast<const float *>(frame.ambient_raw_depth_image->data);
    int invalid = 0, lit = 0;
    for (uint32_t i = 0; i < 544 * 480; i++) {
        if (flags[i] == MLDepthCameraDepthFlags_Valid)
            continue;
        invalid++;
        ASSERT_TRUE(flags[i] & MLDepthCameraDepthFlags_Invalid) << "pixel " << i;
    }
    for (uint32_t i = 0; i < 544 * 480; i++)
        lit += raw[i] > ambient[i];
    EXPECT_GT(invalid, 0);
    EXPECT_GT(lit, 544 * 480 / 2);
}

TEST_F(Depth, TheMainsOfTheLightsExcludesRates) {
    set("mains_hz", "50");
    const auto shortRange = MLDepthCameraFrameType_ShortRange;
    const uint32_t flags = MLDepthCameraFlags_DepthImage;
    for (const auto excluded : {MLDepthCameraFrameRate_30FPS, MLDepthCameraFrameRate_60FPS}) {
        EXPECT_EQ(connectTo(shortRange, excluded, 375, flags), MLResult_InvalidParam);
    }
    ASSERT_EQ(connectTo(shortRange, MLDepthCameraFrameRate_25FPS, 375, flags), MLResult_Ok);
    auto list = capabilitiesOf(MLDepthCameraStream_ShortRange);
    EXPECT_EQ(list.size, 3) << "5, 25 and 50";
    MLDepthCameraReleaseCapabilities(handle, &list);
}

TEST_F(Depth, CapabilitiesAreThoseOfTheFilterAndReleasedOnce) {
    ASSERT_EQ(connectShort(MLDepthCameraFlags_DepthImage), MLResult_Ok);
    auto list = capabilitiesOf(MLDepthCameraStream_LongRange);
    ASSERT_EQ(list.size, 2);
    EXPECT_EQ(list.capabilities[0].stream_capabilities[0].max_exposure, 2000u);
    EXPECT_EQ(counters().outstanding_capability_lists, 1u);
    EXPECT_EQ(MLDepthCameraReleaseCapabilities(handle, &list), MLResult_Ok);
    EXPECT_EQ(MLDepthCameraReleaseCapabilities(handle, &list), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_RELEASE);
}

TEST_F(Depth, DisconnectingWithACapabilityListIsToldAndCounted) {
    ASSERT_EQ(connectShort(MLDepthCameraFlags_DepthImage), MLResult_Ok);
    auto list = capabilitiesOf(MLDepthCameraStream_ShortRange);
    EXPECT_EQ(disconnect(), MLResult_Ok);
    expectMisuse(ML2SIM_MISUSE_UNRELEASED);
    EXPECT_EQ(counters().outstanding_capability_lists, 1u);
    ASSERT_EQ(connectShort(MLDepthCameraFlags_DepthImage), MLResult_Ok);
    EXPECT_EQ(MLDepthCameraReleaseCapabilities(handle, &list), MLResult_Ok);
}
