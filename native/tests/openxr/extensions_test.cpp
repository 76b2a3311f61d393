// The foundation for the vendor's extensions: results, futures and events.
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "app.h"

// Their headers are for C: they have atomic types.
extern "C" {
ml2s_result xr_result_of(XrResult result, const char *call, ml2s_error *error);
ml2s_result future_poll(XrFutureEXT future, bool *is_ready, ml2s_error *error);
ml2s_result future_cancel(XrFutureEXT future, ml2s_error *error);
ml2s_result events_latest(XrStructureType type, void *event, ml2s_error *error);
}

class Extensions : public OpenXr {};

TEST_F(Extensions, EachErrorCodeHasItsResult) {
    const Sensor head(kHead); // an instance that knows names of results
    const std::map<ml2s_result, std::vector<int>> expected = {
        // The last is positive, as a success is.
        {ML2S_PERMISSION_DENIED,
         {-1000710000, -1000138000, -1000139003, -1000139004, -1000140000, -1000474000, 1000482000}},
        {ML2S_NOT_AVAILABLE, {-1000139001}},
        {ML2S_NO_POSE, {XR_ERROR_TIME_INVALID, -1000138001, -1000140003, -1000474001}},
        {ML2S_VENDOR_FAILURE,
         {-1000138002, -1000138003, -1000138004, -1000139002, -1000469001, -1000469002, XR_ERROR_HANDLE_INVALID}},
        {ML2S_OK, {XR_SUCCESS, XR_SESSION_LOSS_PENDING}},
    };
    for (const auto &[result, codes] : expected)
        for (const int code : codes) {
            auto error = sized<ml2s_error>();
            EXPECT_EQ(xr_result_of(static_cast<XrResult>(code), "xrCall", &error), result) << code;
            EXPECT_EQ(error.vendor_code, result == ML2S_OK ? 0 : code);
        }
}

TEST_F(Extensions, AnExtensionIsEnabledOnlyWithTheOneThatItNeeds) {
    // The runtime counts an extension without what it needs as a misuse, and refuses the instance.
    for (const char *missing : {"XR_EXT_uuid", "XR_EXT_future"}) {
        runtime("fault.extension.missing", missing);
        expectRefused(kHead, ML2S_OK, "");
        // The loader remembers what the runtime offers until an instance ends.
        const App app({});
    }
}

/** Futures of a step of a pixel sensor, through the functions of an app, in the instance of the library. */
class Futures : public Extensions {
  protected:
    void SetUp() override {
        Extensions::SetUp();
        stopTime(); // a poll that waited would never return
        runtime("future.delay_ms", "10");
        app.emplace(kAll);
        ASSERT_EQ(app->lendSession(), ML2S_OK);
        XrPixelSensorCreateInfoML info = {XR_TYPE_PIXEL_SENSOR_CREATE_INFO_ML, nullptr, 0};
        app->find<PFN_xrStringToPath>("xrStringToPath")(app->instance, "/pixelsensor/eye/nasal/left", &info.sensor);
        ASSERT_EQ(app->find<PFN_xrCreatePixelSensorML>("xrCreatePixelSensorML")(app->session, &info, &sensor),
                  XR_SUCCESS);
        head = std::make_unique<Sensor>(kHead); // the library takes the instance
        before = counters().live_objects;
    }
    void TearDown() override {
        head.reset();
        if (sensor != XR_NULL_HANDLE)
            destroySensor();
        EXPECT_STREQ(counters().last_misuse, misuse);
    }

    void destroySensor() {
        EXPECT_EQ(app->find<PFN_xrDestroyPixelSensorML>("xrDestroyPixelSensorML")(sensor), XR_SUCCESS);
        sensor = XR_NULL_HANDLE;
    }

    XrFutureEXT begin() {
        const uint32_t stream = 0;
        const XrPixelSensorConfigUint32ML rate = {XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, nullptr, stream,
                                                  XR_PIXEL_SENSOR_UPDATE_RATE_ML, 30};
        const XrPixelSensorConfigUint32ML format = {XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, nullptr, stream,
                                                    XR_PIXEL_SENSOR_FORMAT_ML, XR_PIXEL_SENSOR_GRAYSCALE_ML};
        const XrPixelSensorConfigExtent2DiML size = {
            XR_TYPE_PIXEL_SENSOR_CONFIG_EXTENT_2DI_ML, nullptr, stream, XR_PIXEL_SENSOR_RESOLUTION_ML, {400, 400}};
        const XrPixelSensorConfigBaseHeaderML *configs[] = {
            reinterpret_cast<const XrPixelSensorConfigBaseHeaderML *>(&rate),
            reinterpret_cast<const XrPixelSensorConfigBaseHeaderML *>(&size),
            reinterpret_cast<const XrPixelSensorConfigBaseHeaderML *>(&format)};
        const XrPixelSensorConfigInfoML info = {XR_TYPE_PIXEL_SENSOR_CONFIG_INFO_ML, nullptr, 1, &stream, 3, configs};
        XrFutureEXT future = XR_NULL_HANDLE;
        EXPECT_EQ(app->find<PFN_xrConfigurePixelSensorAsyncML>("xrConfigurePixelSensorAsyncML")(sensor, &info, &future),
                  XR_SUCCESS);
        return future;
    }
    XrResult complete(XrFutureEXT future) {
        XrPixelSensorConfigureCompletionML completion = {XR_TYPE_PIXEL_SENSOR_CONFIGURE_COMPLETION_ML, nullptr,
                                                         XR_SUCCESS};
        const auto result = app->find<PFN_xrConfigurePixelSensorCompleteML>("xrConfigurePixelSensorCompleteML")(
            sensor, future, &completion);
        return result == XR_SUCCESS ? completion.futureResult : result;
    }
    static void expectReady(XrFutureEXT future, bool expected) {
        bool is_ready = !expected;
        EXPECT_EQ(future_poll(future, &is_ready, nullptr), ML2S_OK);
        EXPECT_EQ(is_ready, expected);
    }
    void expectInvalid(XrFutureEXT future) {
        auto error = sized<ml2s_error>();
        bool is_ready = true;
        EXPECT_EQ(future_poll(future, &is_ready, &error), ML2S_VENDOR_FAILURE);
        EXPECT_FALSE(is_ready);
        EXPECT_STREQ(error.message, "xrPollFutureEXT: XR_ERROR_FUTURE_INVALID_EXT (-1000469002)");
        misuse = "no such future to poll";
    }

    std::optional<App> app;
    XrPixelSensorML sensor = XR_NULL_HANDLE;
    std::unique_ptr<Sensor> head;
    uint32_t before = 0;
    const char *misuse = "";
};

TEST_F(Futures, ALateOneIsPendingUntilItIsReady) {
    const auto future = begin();
    expectReady(future, false);
    EXPECT_EQ(complete(future), XR_ERROR_FUTURE_PENDING_EXT);
    ml2sim_advance(10 * kMillisecond);
    expectReady(future, true);
    EXPECT_EQ(complete(future), XR_SUCCESS);
    EXPECT_EQ(counters().live_objects, before);
}

TEST_F(Futures, AFailedOneIsReadyAndSaysSoWhenItIsCompleted) {
    runtime("fault.future.fails", "configure");
    const auto future = begin();
    ml2sim_advance(10 * kMillisecond);
    expectReady(future, true);
    EXPECT_EQ(complete(future), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_EQ(counters().live_objects, before);
}

TEST_F(Futures, OneThatIsNeverReadyIsCancelledAndTheCallCanBeginAgain) {
    runtime("fault.future.stuck", "1");
    const auto future = begin();
    ml2sim_advance(60000 * kMillisecond);
    expectReady(future, false);
    EXPECT_EQ(future_cancel(future, nullptr), ML2S_OK);
    EXPECT_EQ(counters().live_objects, before);
    expectInvalid(future);
    EXPECT_EQ(future_cancel(begin(), nullptr), ML2S_OK);
}

TEST_F(Futures, OneWhoseHandleIsDestroyedIsInvalid) {
    const auto future = begin();
    destroySensor();
    EXPECT_EQ(counters().live_objects, before - 1);
    expectInvalid(future);
}

class Events : public Extensions {
  protected:
    template <class Event> static ml2s_result latest(XrStructureType type, Event *event) {
        uint8_t memory[512] = {}; // larger than any
        const auto result = events_latest(type, memory, nullptr);
        std::memcpy(event, memory, sizeof *event);
        return result;
    }
    /** Polls the sensor until an event satisfies the condition; the session gets its events in such polls. */
    template <class Event, class Condition>
    static Event await(Sensor &sensor, XrStructureType type, Condition isExpected) {
        Event event = {};
        const int64_t end = ml2s_now() + 10000 * kMillisecond;
        while (latest(type, &event) != ML2S_OK || !isExpected(event)) {
            if (ml2s_now() > end) {
                ADD_FAILURE() << "no such event within 10 s";
                break;
            }
            sensor.pollReading();
        }
        return event;
    }
};

TEST_F(Events, TheLatestOfEachKindIsKept) {
    Sensor head(kHead);
    const auto map = await<XrEventDataLocalizationChangedML>(
        head, XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML,
        [](const auto &event) { return event.state == XR_LOCALIZATION_MAP_STATE_LOCALIZED_ML; });
    EXPECT_EQ(map.confidence, XR_LOCALIZATION_MAP_CONFIDENCE_EXCELLENT_ML);
    EXPECT_STREQ(map.map.name, "Simulated room");
    runtime("map.confidence", "0");
    await<XrEventDataLocalizationChangedML>(head, XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML, [](const auto &event) {
        return event.confidence == XR_LOCALIZATION_MAP_CONFIDENCE_POOR_ML;
    });
    runtime("headset.fit", "1");
    await<XrEventDataHeadsetFitChangedML>(head, XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML, [](const auto &event) {
        return event.status == XR_HEADSET_FIT_STATUS_NOT_WORN_ML;
    });
    await<XrEventDataEyeCalibrationChangedML>(
        head, XR_TYPE_EVENT_DATA_EYE_CALIBRATION_CHANGED_ML,
        [](const auto &event) { return event.status == XR_EYE_CALIBRATION_STATUS_FINE_ML; });
}

TEST_F(Events, APermissionThatIsMissingIsSaidInsteadOfTheEventOfTheSessionBefore) {
    {
        Sensor head(kHead);
        await<XrEventDataLocalizationChangedML>(head, XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML,
                                                [](const auto &) { return true; });
    }
    runtime("fault.map.denied", "1");
    Sensor head(kHead);
    XrEventDataHeadsetFitChangedML fit;
    fit = await<decltype(fit)>(head, XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML, [](const auto &) { return true; });
    EXPECT_EQ(fit.status, XR_HEADSET_FIT_STATUS_GOOD_FIT_ML);
    uint8_t event[512];
    auto error = sized<ml2s_error>();
    EXPECT_EQ(events_latest(XR_TYPE_EVENT_DATA_LOCALIZATION_CHANGED_ML, event, &error), ML2S_PERMISSION_DENIED);
    EXPECT_EQ(std::string(error.message).find("xrEnableLocalizationEventsML: "), 0u) << error.message;
}
