// Inside an app that owns instance and session.
#include "app.h"

class Borrowed : public OpenXr {};

TEST_F(Borrowed, NoInstanceAndNoSessionIsMadeOrEnded) {
    App app(kAll);
    app.createSession();
    const auto appsOwn = counters().live_objects;
    ASSERT_EQ(app.lend(), ML2S_OK);
    {
        Sensor head(kHead);
        const Sensor hands(kHands);
        EXPECT_EQ(head.result, ML2S_OK) << head.error.message;
        EXPECT_EQ(hands.result, ML2S_OK) << hands.error.message;
        EXPECT_TRUE(head.pollReading().is_tracked);
    }
    EXPECT_EQ(counters().instances_created, 1u);
    EXPECT_EQ(counters().sessions_created, 1u);
    EXPECT_EQ(counters().live_objects, appsOwn);
}

TEST_F(Borrowed, FramesComeInTheAppsSession) {
    stopTime();
    App app(kAll);
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    const Slots slots(ML2S_STREAM_EYE_NASAL_LEFT);
    Sensor eye(kEyeNasalLeft);
    ml2sim_advance(1000 * kMillisecond);
    const auto frames = eye.poll();
    EXPECT_EQ(frames.size(), 1u) << eye.error.message;
}

TEST_F(Borrowed, TheAppsEventsAreLeftToTheApp) {
    App app(kAll);
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    Sensor head(kHead);
    head.pollReading();
    for (const auto state : {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY}) {
        const auto event = app.nextEvent();
        ASSERT_EQ(event.type, XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED);
        EXPECT_EQ(reinterpret_cast<const XrEventDataSessionStateChanged &>(event).state, state);
    }
}

TEST_F(Borrowed, GazeIsTheAppsAffair) {
    App app(kAll);
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    expectRefused(kGaze, ML2S_NOT_AVAILABLE,
                  "not available: gaze in the app's session (attaching action sets would break the app's)");
    expectRefused(kController, ML2S_NOT_AVAILABLE,
                  "not available: controller in the app's session (attaching action sets would break the app's)");
    expectRefused(kControllerInput, ML2S_NOT_AVAILABLE,
                  "not available: controller in the app's session (attaching action sets would break the app's)");
}

TEST_F(Borrowed, AnExtensionThatTheAppHasNotEnabledIsNamed) {
    App app({XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME});
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    const Sensor head(kHead);
    EXPECT_EQ(head.result, ML2S_OK);
    expectRefused(kEyeNasalLeft, ML2S_NOT_AVAILABLE, "not available: XR_EXT_future (not enabled by the app)");
    expectRefused(kHands, ML2S_NOT_AVAILABLE, "not available: XR_EXT_hand_tracking (not enabled by the app)");
}

TEST_F(Borrowed, TheAppsSessionCanBeGivenAwayForOneOfOurOwn) {
    {
        App app(kAll);
        ASSERT_EQ(app.lendSession(), ML2S_OK);
        const Sensor head(kHead);
        EXPECT_EQ(head.result, ML2S_OK);
    }
    ASSERT_EQ(useLoader(kLoader), ML2S_OK);
    const Sensor head(kHead);
    EXPECT_EQ(head.result, ML2S_OK) << head.error.message;
}
