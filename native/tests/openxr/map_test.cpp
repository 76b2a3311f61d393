// The map in which the headset is localized, and the rules of the simulated runtime for it.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "../../sim/scene/geometry.h"
#include "app.h"

namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kHundredthOfDegree_rad = 1.7e-4;
constexpr const char *kRoom = "07070707-0707-0707-0707-070707070707 Simulated room";
constexpr const char *kSecond = "28282828-2828-2828-2828-282828282828 Second room";

ml2sim::Pose poseOf(const ml2s_reading &reading) {
    EXPECT_TRUE(reading.is_tracked);
    const auto *q = reading.rotation, *p = reading.position;
    return {{q[0], q[1], q[2], q[3]}, {p[0], p[1], p[2]}};
}

void expectState(const ml2s_reading &reading, int state, int confidence, int errors, const char *name) {
    EXPECT_EQ(reading.stream, uint32_t{ML2S_STREAM_MAP});
    EXPECT_EQ(reading.values[ML2S_MAP_STATE], static_cast<float>(state));
    EXPECT_EQ(reading.values[ML2S_MAP_CONFIDENCE], static_cast<float>(confidence));
    EXPECT_EQ(reading.values[ML2S_MAP_ERRORS], static_cast<float>(errors));
    EXPECT_STREQ(reading.name, name);
}

} // namespace

class Map : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        headset("trajectory", STILL_HEAD);
        runtime("map.delay_ms", "0");
    }
    void TearDown() override {
        close();
        headset("trajectory", "");
        OpenXr::TearDown();
    }
    ml2s_result open(const char *name = "") {
        map.emplace(settingsFor(name));
        if (map->result != ML2S_OK) {
            error = map->error;
            const auto result = map->result;
            map.reset();
            return result;
        }
        return ML2S_OK;
    }
    static ml2s_settings settingsFor(const char *name) {
        auto settings = openXrSettings(ML2S_SENSOR_MAP, bitOf(ML2S_STREAM_MAP));
        settings.map_confidence = XR_LOCALIZATION_MAP_CONFIDENCE_FAIR_ML;
        std::snprintf(settings.map, sizeof settings.map, "%s", name);
        return settings;
    }
    void close() { map.reset(); }
    ml2s_reading poll(ml2s_result expected = ML2S_OK) {
        auto reading = sized<ml2s_reading>();
        uint32_t count = 0;
        EXPECT_EQ(ml2s_poll_readings(map->handle(), &reading, 1, &count, &error), expected) << error.message;
        EXPECT_EQ(count, expected == ML2S_OK ? 1u : 0u);
        return reading;
    }
    /** Polls until the headset is localized in the map of the name. */
    ml2s_reading localized(const std::string &name) {
        const int64_t end = ml2s_now() + 60000 * kMillisecond;
        auto reading = poll();
        while ((!reading.is_tracked || reading.name != name) && ml2s_now() < end && !HasFailure())
            reading = poll();
        EXPECT_EQ(reading.name, name);
        return reading;
    }

    ml2s_error error = sized<ml2s_error>();
    std::optional<Sensor> map;
};

TEST_F(Map, ItsOriginStaysInTheRoomWhereverTheWorldBegins) {
    ASSERT_EQ(open(), ML2S_OK) << error.message;
    Sensor head(kHead);
    const auto headInMap = [&] { return compose(inverse(poseOf(localized(kRoom))), poseOf(head.pollReading())); };
    const auto expected = headInMap();
    EXPECT_GT(length(expected.position), 1) << "the map does not begin at the head";
    const auto path = testing::TempDir() + "/head_of_the_map_test.tum";
    auto before = poseOf(localized(kRoom)).position;
    for (int i = 1; i <= 10; i++) {
        std::ostringstream pose;
        pose << 0.4 * std::cos(i) << " 0.05 " << 0.4 * std::sin(i) << " 0 " << std::sin(0.15 * i) << " 0 "
             << std::cos(0.15 * i) << "\n";
        std::ofstream(path) << "0 " << pose.str() << "0.01 " << pose.str();
        headset("trajectory", path.c_str());
        headset("fault.head.new_session", std::to_string(i).c_str());
        headset("trajectory", STILL_HEAD);
        const auto found = headInMap();
        EXPECT_LT(length(found.position - expected.position), kMillimetre) << i;
        const ml2sim::Vec3 forward{0, 0, -1};
        EXPECT_LT(length(rotate(found.rotation, forward) - rotate(expected.rotation, forward)), kHundredthOfDegree_rad);
        const auto inWorld = poseOf(localized(kRoom));
        EXPECT_GT(length(inWorld.position - before), 100 * kMillimetre) << "the world of before";
        EXPECT_LT(length(rotate(inWorld.rotation, {0, 1, 0}) - ml2sim::Vec3{0, 1, 0}), kHundredthOfDegree_rad);
        before = inWorld.position;
    }
}

TEST_F(Map, APoseOfLowConfidenceIsNotTrackedAndTheReasonIsSaid) {
    ASSERT_EQ(open(), ML2S_OK);
    expectState(localized(kRoom), 1, 3, 0, kRoom);
    runtime("map.errors", "20");
    runtime("map.confidence", "0");
    const auto poor = poll();
    EXPECT_FALSE(poor.is_tracked);
    expectState(poor, 1, 0, 20, kRoom);
    runtime("map.confidence", "1");
    EXPECT_TRUE(poll().is_tracked);
}

TEST_F(Map, WithoutAMapThereIsNoPoseAndNoName) {
    ASSERT_EQ(open(), ML2S_OK);
    localized(kRoom);
    for (const int state : {0, 2, 3}) {
        runtime("map.state", std::to_string(state).c_str());
        const auto reading = poll();
        EXPECT_FALSE(reading.is_tracked);
        expectState(reading, state, 3, 0, "");
    }
}

TEST_F(Map, WithoutAnEventTheStateIsUnknownAndThePoseNotTracked) {
    runtime("fault.map.silent", "1");
    ASSERT_EQ(open("Second room"), ML2S_OK);
    for (int i = 0; i < 10; i++) {
        const auto reading = poll();
        EXPECT_FALSE(reading.is_tracked);
        expectState(reading, -1, 0, 0, "");
    }
}

TEST_F(Map, AnOriginThatMovesWithoutAnEventIsFollowed) {
    ASSERT_EQ(open(), ML2S_OK);
    const auto before = poseOf(localized(kRoom)).position;
    runtime("map.moved_mm", "250");
    EXPECT_NEAR(length(poseOf(poll()).position - before), 0.25, 1e-5);
}

TEST_F(Map, AMapIsAskedForByNameOrUuid) {
    for (const char *name : {"Second room", "28282828-2828-2828-2828-282828282828"}) {
        ASSERT_EQ(open(name), ML2S_OK) << error.message;
        localized(kSecond);
        close();
    }
    runtime("map.count", "3");
    ASSERT_EQ(open("ABABABAB-ABAB-ABAB-ABAB-ABABABABABAB"), ML2S_OK) << error.message;
    localized("abababab-abab-abab-abab-abababababab Simulated room");
}

TEST_F(Map, ThePoseIsNotTrackedUntilTheHeadsetIsInTheMapThatIsAskedFor) {
    runtime("map.delay_ms", "60000");
    ASSERT_EQ(open("Second room"), ML2S_OK);
    auto reading = poll();
    EXPECT_FALSE(reading.is_tracked);
    expectState(reading, 1, 3, 0, kRoom);
    reading = poll();
    EXPECT_FALSE(reading.is_tracked);
    expectState(reading, 2, 3, 0, "");
}

TEST_F(Map, AMapThatIsAskedForMovesNoWorld) {
    Sensor head(kHead);
    head.pollReading();
    ASSERT_EQ(open("Second room"), ML2S_OK);
    localized(kSecond);
    EXPECT_EQ(head.pollReading().events, 0u);
}

TEST_F(Map, OneThatIsNotThereOrNotOneIsRefusedWithTheList) {
    runtime("map.count", "3");
    EXPECT_EQ(open("Kitchen"), ML2S_NOT_AVAILABLE);
    EXPECT_STREQ(error.message, "not available: map \"Kitchen\"; the headset has 3: "
                                "07070707-0707-0707-0707-070707070707 Simulated room, "
                                "28282828-2828-2828-2828-282828282828 Second room, "
                                "abababab-abab-abab-abab-abababababab Simulated room");
    EXPECT_EQ(open("Simulated room"), ML2S_INVALID_ARGUMENT);
    EXPECT_STREQ(error.message, "2 maps are called \"Simulated room\", expected the UUID of one: "
                                "07070707-0707-0707-0707-070707070707, abababab-abab-abab-abab-abababababab");
    runtime("map.count", "0");
    EXPECT_EQ(open("Kitchen"), ML2S_NOT_AVAILABLE);
    EXPECT_STREQ(error.message, "not available: map \"Kitchen\"; the headset has 0");
    EXPECT_EQ(counters().live_objects, 0u);
}

TEST_F(Map, FailuresAreTyped) {
    runtime("fault.map.denied", "1");
    EXPECT_EQ(open("Second room"), ML2S_PERMISSION_DENIED);
    ASSERT_EQ(open(), ML2S_OK);
    poll(ML2S_PERMISSION_DENIED);
    EXPECT_EQ(std::string(error.message).find("xrEnableLocalizationEventsML: "), 0u) << error.message;
    close();
    runtime("fault.map.denied", "0");
    runtime("fault.map.fails", "1");
    ASSERT_EQ(open("Second room"), ML2S_OK);
    poll(ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "xrRequestMapLocalizationML: XR_ERROR_LOCALIZATION_MAP_FAIL_ML (-1000139002)");
}

TEST_F(Map, ARuntimeWithoutTheExtensionIsSaid) {
    runtime("fault.extension.missing", "XR_ML_localization_map");
    EXPECT_EQ(open(), ML2S_NOT_AVAILABLE);
    EXPECT_STREQ(error.message, "not available: XR_ML_localization_map");
    const App app({}); // the loader remembers what the runtime offers until an instance ends
}

TEST_F(Map, InASessionOfAnAppItIsRefusedSinceTheAppHasTheEvents) {
    auto extensions = kAll;
    extensions.insert(extensions.end(), {XR_EXT_UUID_EXTENSION_NAME, XR_ML_LOCALIZATION_MAP_EXTENSION_NAME});
    App app(extensions);
    ASSERT_EQ(app.lendSession(), ML2S_OK);
    EXPECT_EQ(open(), ML2S_NOT_AVAILABLE);
    EXPECT_STREQ(error.message, "not available: the map in an OpenXR session of the app, which gets the events of it");
}

/** The rules of the simulated runtime. */
class MapRules : public OpenXr {
  protected:
    template <class Function> Function find(const char *name) { return app->find<Function>(name); }
    void SetUp() override {
        OpenXr::SetUp();
        app.emplace(std::vector<const char *>{XR_MND_HEADLESS_EXTENSION_NAME, XR_EXT_UUID_EXTENSION_NAME,
                                              XR_ML_LOCALIZATION_MAP_EXTENSION_NAME});
        app->createSession();
    }
    void TearDown() override { app.reset(); } // these tests misuse the runtime

    XrResult request(XrSession session, uint8_t digit) {
        XrMapLocalizationRequestInfoML info = {XR_TYPE_MAP_LOCALIZATION_REQUEST_INFO_ML, nullptr, {}};
        std::fill(std::begin(info.mapUuid.data), std::end(info.mapUuid.data), digit);
        return find<PFN_xrRequestMapLocalizationML>("xrRequestMapLocalizationML")(session, &info);
    }
    XrResult query(const XrLocalizationMapQueryInfoBaseHeaderML *filter, uint32_t capacity, uint32_t *count,
                   XrLocalizationMapML *maps) {
        return find<PFN_xrQueryLocalizationMapsML>("xrQueryLocalizationMapsML")(app->session, filter, capacity, count,
                                                                                maps);
    }

    std::optional<App> app;
};

TEST_F(MapRules, AMapThatIsNotKnownIsUnavailable) {
    EXPECT_EQ(request(app->session, 9), XR_ERROR_LOCALIZATION_MAP_UNAVAILABLE_ML);
    EXPECT_EQ(request(app->session, 7), XR_SUCCESS);
    EXPECT_STREQ(counters().last_misuse, "");
}

TEST_F(MapRules, ASessionThatIsDestroyedIsInvalid) {
    XrSession gone = app->session;
    find<PFN_xrDestroySession>("xrDestroySession")(app->session);
    app->session = XR_NULL_HANDLE;
    app->createSession();
    EXPECT_EQ(request(gone, 7), XR_ERROR_HANDLE_INVALID);
}

TEST_F(MapRules, MapsAreListedInTwoCallsAndThereAreNoFilters) {
    uint32_t count = 0;
    EXPECT_EQ(query(nullptr, 0, &count, nullptr), XR_SUCCESS);
    EXPECT_EQ(count, 2u);
    XrLocalizationMapML maps[2] = {};
    maps[0].type = maps[1].type = XR_TYPE_LOCALIZATION_MAP_ML;
    EXPECT_EQ(query(nullptr, 1, &count, maps), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(query(nullptr, 2, &count, maps), XR_SUCCESS);
    EXPECT_STREQ(maps[1].name, "Second room");
    EXPECT_EQ(counters().misuses[ML2SIM_XR_MISUSE_TYPE], 0u);
    const XrLocalizationMapQueryInfoBaseHeaderML filter = {XR_TYPE_UNKNOWN, nullptr};
    EXPECT_EQ(query(&filter, 2, &count, maps), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(counters().misuses[ML2SIM_XR_MISUSE_TYPE], 1u);
}
