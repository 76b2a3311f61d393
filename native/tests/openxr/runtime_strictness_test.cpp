// The simulated runtime itself: what it refuses, with which error, and that it counts it.
#include <optional>

#include "app.h"

/** A function of the instance, by its name. */
#define XR(name) function<PFN_##name>(#name)

namespace {

class Runtime : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        stopTime();
        app.emplace(std::vector<const char *>{XR_MND_HEADLESS_EXTENSION_NAME, XR_EXT_FUTURE_EXTENSION_NAME,
                                              XR_ML_PIXEL_SENSOR_EXTENSION_NAME});
        app->createSession();
    }
    void TearDown() override {
        // Tests misuse on purpose; each says what it expects.
        EXPECT_STREQ(counters().last_misuse, misuse.c_str());
        for (const auto sensor : sensors) {
            destroy(sensor);
        }
    }

    void expectMisuse(ml2sim_xr_misuse kind, const std::string &what) {
        EXPECT_EQ(counters().misuses[kind], 1u);
        misuse = what;
    }

    template <class Function> Function function(const char *name) {
        const auto found = app->find<Function>(name);
        EXPECT_NE(found, nullptr) << name;
        return found;
    }

    XrPixelSensorML createSensor(const char *path = "/pixelsensor/eye/nasal/left") {
        XrPixelSensorCreateInfoML info = {XR_TYPE_PIXEL_SENSOR_CREATE_INFO_ML, nullptr, 0};
        XR(xrStringToPath)(app->instance, path, &info.sensor);
        XrPixelSensorML sensor = XR_NULL_HANDLE;
        EXPECT_EQ(XR(xrCreatePixelSensorML)(app->session, &info, &sensor), XR_SUCCESS);
        sensors.push_back(sensor);
        return sensor;
    }
    XrResult destroy(XrPixelSensorML sensor) { return XR(xrDestroyPixelSensorML)(sensor); }

    XrResult configure(XrPixelSensorML sensor, XrFutureEXT *future) {
        const XrPixelSensorConfigUint32ML rate = {XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, nullptr, 0,
                                                  XR_PIXEL_SENSOR_UPDATE_RATE_ML, 30};
        const XrPixelSensorConfigUint32ML format = {XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, nullptr, 0,
                                                    XR_PIXEL_SENSOR_FORMAT_ML, XR_PIXEL_SENSOR_GRAYSCALE_ML};
        const XrPixelSensorConfigExtent2DiML size = {
            XR_TYPE_PIXEL_SENSOR_CONFIG_EXTENT_2DI_ML, nullptr, 0, XR_PIXEL_SENSOR_RESOLUTION_ML, {400, 400}};
        const auto head = [](const void *config) {
            return static_cast<const XrPixelSensorConfigBaseHeaderML *>(config);
        };
        const XrPixelSensorConfigBaseHeaderML *configs[] = {head(&rate), head(&size), head(&format)};
        const uint32_t stream = 0;
        const XrPixelSensorConfigInfoML info = {
            XR_TYPE_PIXEL_SENSOR_CONFIG_INFO_ML, nullptr, 1, &stream, configCount, configs};
        return XR(xrConfigurePixelSensorAsyncML)(sensor, &info, future);
    }
    XrResult completeConfigure(XrPixelSensorML sensor, XrFutureEXT future) {
        XrPixelSensorConfigureCompletionML completion = {XR_TYPE_PIXEL_SENSOR_CONFIGURE_COMPLETION_ML, nullptr,
                                                         XR_SUCCESS};
        return XR(xrConfigurePixelSensorCompleteML)(sensor, future, &completion);
    }
    XrPixelSensorML createRunning() {
        const auto sensor = createSensor();
        XrFutureEXT future;
        EXPECT_EQ(configure(sensor, &future), XR_SUCCESS);
        EXPECT_EQ(completeConfigure(sensor, future), XR_SUCCESS);
        const uint32_t stream = 0;
        const XrPixelSensorStartInfoML info = {XR_TYPE_PIXEL_SENSOR_START_INFO_ML, nullptr, 1, &stream};
        EXPECT_EQ(XR(xrStartPixelSensorAsyncML)(sensor, &info, &future), XR_SUCCESS);
        XrPixelSensorStartCompletionML completion = {XR_TYPE_PIXEL_SENSOR_START_COMPLETION_ML, nullptr, XR_SUCCESS};
        EXPECT_EQ(XR(xrStartPixelSensorCompleteML)(sensor, future, &completion), XR_SUCCESS);
        return sensor;
    }
    XrResult getData(XrPixelSensorML sensor, void *metadata = nullptr, uint32_t bytes = 400 * 400) {
        std::vector<uint8_t> memory(bytes);
        const XrPixelSensorDataGetInfoML info = {XR_TYPE_PIXEL_SENSOR_DATA_GET_INFO_ML, nullptr, 0, 1, 0};
        XrPixelSensorBufferML buffer = {XR_TYPE_PIXEL_SENSOR_BUFFER_ML, nullptr, bytes, memory.data()};
        XrPixelSensorDataML data = {XR_TYPE_PIXEL_SENSOR_DATA_ML, metadata, 0, nullptr};
        return XR(xrGetPixelSensorDataML)(sensor, &info, &buffer, &data);
    }

    std::optional<App> app;
    uint32_t configCount = 3;
    std::string misuse;

  private:
    std::vector<XrPixelSensorML> sensors;
};

} // namespace

TEST_F(Runtime, AFunctionOfAnExtensionThatIsNotEnabledIsNotThere) {
    EXPECT_EQ(app->find<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT"), nullptr);
    EXPECT_NE(app->find<PFN_xrPollFutureEXT>("xrPollFutureEXT"), nullptr);
}

TEST_F(Runtime, AStructureOfAnotherTypeIsRefused) {
    const XrPixelSensorCreateInfoML info = {XR_TYPE_PIXEL_SENSOR_DATA_ML, nullptr, 1};
    XrPixelSensorML sensor;
    EXPECT_EQ(XR(xrCreatePixelSensorML)(app->session, &info, &sensor), XR_ERROR_VALIDATION_FAILURE);
    expectMisuse(ML2SIM_XR_MISUSE_TYPE, "XrPixelSensorCreateInfo has type 1000475017, expected 1000475001");
}

TEST_F(Runtime, ADestroyedHandleIsRefused) {
    const auto sensor = createSensor();
    EXPECT_EQ(destroy(sensor), XR_SUCCESS);
    EXPECT_EQ(destroy(sensor), XR_ERROR_HANDLE_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_HANDLE, "no such pixel sensor");
}

TEST_F(Runtime, DataBeforeStartIsRefused) {
    const auto sensor = createSensor();
    EXPECT_EQ(getData(sensor), XR_ERROR_CALL_ORDER_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "data before start");
}

TEST_F(Runtime, ConfiguringARunningStreamIsRefused) {
    const auto sensor = createRunning();
    XrFutureEXT future;
    EXPECT_EQ(configure(sensor, &future), XR_ERROR_CALL_ORDER_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "configured while running");
    misuse = "/pixelsensor/eye/nasal/left destroyed while running";
    EXPECT_EQ(destroy(sensor), XR_ERROR_CALL_ORDER_INVALID);
}

TEST_F(Runtime, ConfiguringTwiceAtOnceIsRefused) {
    const auto sensor = createSensor();
    XrFutureEXT future;
    EXPECT_EQ(configure(sensor, &future), XR_SUCCESS);
    XrFutureEXT other;
    EXPECT_EQ(configure(sensor, &other), XR_ERROR_CALL_ORDER_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "configure while another step is not completed");
    EXPECT_EQ(completeConfigure(sensor, future), XR_SUCCESS);
}

TEST_F(Runtime, AMandatoryCapabilityMustBeConfigured) {
    const auto sensor = createSensor();
    XrFutureEXT future;
    configCount = 2;
    EXPECT_EQ(configure(sensor, &future), XR_ERROR_VALIDATION_FAILURE);
    expectMisuse(ML2SIM_XR_MISUSE_ARGUMENT, "a mandatory capability is not configured");
}

TEST_F(Runtime, AFutureIsCompletedOnceAndOnlyWhenReady) {
    const auto sensor = createSensor();
    runtime("future.delay_ms", "2");
    XrFutureEXT future;
    EXPECT_EQ(configure(sensor, &future), XR_SUCCESS);
    EXPECT_EQ(completeConfigure(sensor, future), XR_ERROR_FUTURE_PENDING_EXT);
    ml2sim_advance(2 * kMillisecond);
    EXPECT_EQ(completeConfigure(sensor, future), XR_SUCCESS);
    EXPECT_EQ(completeConfigure(sensor, future), XR_ERROR_FUTURE_INVALID_EXT);
    expectMisuse(ML2SIM_XR_MISUSE_FUTURE, "no future of configure to complete, or completed before");
}

TEST_F(Runtime, MetadataThatAreNotOfferedCannotBeChained) {
    const auto sensor = createRunning();
    XrPixelSensorFisheyeIntrinsicsML fisheye = {};
    fisheye.type = XR_TYPE_PIXEL_SENSOR_FISHEYE_INTRINSICS_ML;
    EXPECT_EQ(getData(sensor, &fisheye), XR_ERROR_VALIDATION_FAILURE);
    expectMisuse(ML2SIM_XR_MISUSE_TYPE, "chained to data: a structure of type 1000475024, which is not offered");
}

TEST_F(Runtime, ABufferThatIsTooSmallIsRefused) {
    const auto sensor = createRunning();
    EXPECT_EQ(getData(sensor, nullptr, 1000), XR_ERROR_SIZE_INSUFFICIENT);
    expectMisuse(ML2SIM_XR_MISUSE_ARGUMENT, "the buffer is smaller than it must be");
}

TEST_F(Runtime, ASensorDestroyedBeforeItsSpaceIsCounted) {
    const auto sensor = createSensor();
    const XrPixelSensorCreateSpaceInfoML info = {
        XR_TYPE_PIXEL_SENSOR_CREATE_SPACE_INFO_ML, nullptr, sensor, {{0, 0, 0, 1}, {0, 0, 0}}};
    XrSpace space;
    EXPECT_EQ(XR(xrCreatePixelSensorSpaceML)(app->session, &info, &space), XR_SUCCESS);
    EXPECT_EQ(destroy(sensor), XR_ERROR_VALIDATION_FAILURE);
    expectMisuse(ML2SIM_XR_MISUSE_CHILDREN, "/pixelsensor/eye/nasal/left destroyed while 1 made from it live");
}

TEST_F(Runtime, ASessionIsBegunWhenReadyOnly) {
    const XrSessionBeginInfo info = {XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    const auto begin = XR(xrBeginSession);
    EXPECT_EQ(begin(app->session, &info), XR_ERROR_SESSION_NOT_READY);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "a session begun that was not ready");
    while (app->nextEvent().type != XR_TYPE_UNKNOWN) {
    }
    EXPECT_EQ(begin(app->session, &info), XR_SUCCESS);
}

TEST_F(Runtime, AProfileWithoutItsExtensionIsRefused) {
    XrActionSetCreateInfo set = {XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, "sensors", "Sensors", 0};
    XrActionSet actions = XR_NULL_HANDLE;
    EXPECT_EQ(XR(xrCreateActionSet)(app->instance, &set, &actions), XR_SUCCESS);
    XrPath profile = XR_NULL_PATH;
    XR(xrStringToPath)(app->instance, "/interaction_profiles/ml/ml2_controller", &profile);
    const XrInteractionProfileSuggestedBinding suggestion = {XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                             profile, 0, nullptr};
    EXPECT_EQ(XR(xrSuggestInteractionProfileBindings)(app->instance, &suggestion), XR_ERROR_PATH_UNSUPPORTED);
    expectMisuse(ML2SIM_XR_MISUSE_EXTENSION,
                 "/interaction_profiles/ml/ml2_controller without the extension that has it");
    XR(xrDestroyActionSet)(actions);
}

TEST_F(Runtime, AnUnknownKeyOrValueIsRefusedWithWhatIsExpected) {
    EXPECT_STREQ(ml2sim_xr_set("fault.sensor.take", "1"),
                 "unknown key \"fault.sensor.take\"; the nearest is \"fault.sensor.taken\"");
    EXPECT_STREQ(ml2sim_xr_set("future.delay_ms", "soon"),
                 "future.delay_ms: expected a whole number from 0 to 60000, found \"soon\"");
    EXPECT_STREQ(ml2sim_xr_set("fault.future.fails", "begin"),
                 "fault.future.fails: expected one of \"\", \"configure\", \"start\", \"stop\", found \"begin\"");
}

/** The detector of the simulated runtime: each rule of the specification that it enforces. */
class MarkerRules : public Runtime {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        stopTime();
        runtime("markers.delay_ms", "10");
        app.emplace(
            std::vector<const char *>{XR_MND_HEADLESS_EXTENSION_NAME, XR_ML_MARKER_UNDERSTANDING_EXTENSION_NAME});
        app->createSession();
    }
    void TearDown() override {
        XR(xrDestroyMarkerDetectorML)(detector);
        Runtime::TearDown();
    }
    XrResult create(const void *next) {
        const XrMarkerDetectorCreateInfoML info = {XR_TYPE_MARKER_DETECTOR_CREATE_INFO_ML, next,
                                                   XR_MARKER_DETECTOR_PROFILE_DEFAULT_ML, XR_MARKER_TYPE_ARUCO_ML};
        return XR(xrCreateMarkerDetectorML)(app->session, &info, &detector);
    }
    void createWithSize() {
        const XrMarkerDetectorSizeInfoML size = {XR_TYPE_MARKER_DETECTOR_SIZE_INFO_ML, nullptr, 0.48f};
        const XrMarkerDetectorArucoInfoML aruco = {XR_TYPE_MARKER_DETECTOR_ARUCO_INFO_ML, &size,
                                                   XR_MARKER_ARUCO_DICT_4X4_50_ML};
        ASSERT_EQ(create(&aruco), XR_SUCCESS);
    }
    XrResult snapshot() {
        XrMarkerDetectorSnapshotInfoML info = {XR_TYPE_MARKER_DETECTOR_SNAPSHOT_INFO_ML, nullptr};
        return XR(xrSnapshotMarkerDetectorML)(detector, &info);
    }
    XrResult getState(XrMarkerDetectorStatusML *state) {
        XrMarkerDetectorStateML out = {XR_TYPE_MARKER_DETECTOR_STATE_ML, nullptr, XR_MARKER_DETECTOR_STATUS_ERROR_ML};
        const auto result = XR(xrGetMarkerDetectorStateML)(detector, &out);
        *state = out.state;
        return result;
    }
    XrResult getMarkers() { return XR(xrGetMarkersML)(detector, 16, &count, markers); }
    /** Takes a snapshot of the room, and waits for it. */
    void see() {
        XrMarkerDetectorStatusML state;
        EXPECT_EQ(snapshot(), XR_SUCCESS);
        ml2sim_advance(10 * kMillisecond);
        EXPECT_EQ(getState(&state), XR_SUCCESS);
        EXPECT_EQ(state, XR_MARKER_DETECTOR_STATUS_READY_ML);
        EXPECT_EQ(getMarkers(), XR_SUCCESS);
    }

    XrMarkerDetectorML detector = XR_NULL_HANDLE;
    XrMarkerML markers[16];
    uint32_t count = 0;
};

TEST_F(MarkerRules, ASizeIsNeededUnlessTheRuntimeEstimatesIt) {
    const XrMarkerDetectorArucoInfoML aruco = {XR_TYPE_MARKER_DETECTOR_ARUCO_INFO_ML, nullptr,
                                               XR_MARKER_ARUCO_DICT_4X4_50_ML};
    EXPECT_EQ(create(&aruco), XR_ERROR_VALIDATION_FAILURE);
    expectMisuse(ML2SIM_XR_MISUSE_TYPE, "a detector without XrMarkerDetectorSizeInfoML");
    runtime("markers.estimates_size", "1");
    EXPECT_EQ(create(&aruco), XR_SUCCESS);
}

TEST_F(MarkerRules, TheStateNeedsASnapshot) {
    createWithSize();
    XrMarkerDetectorStatusML state;
    EXPECT_EQ(getState(&state), XR_ERROR_CALL_ORDER_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "the state of a detector without a snapshot");
}

TEST_F(MarkerRules, MarkersNeedASnapshotThatWasSeenToBeReady) {
    createWithSize();
    XrMarkerDetectorStatusML state;
    EXPECT_EQ(snapshot(), XR_SUCCESS);
    EXPECT_EQ(getState(&state), XR_SUCCESS);
    EXPECT_EQ(state, XR_MARKER_DETECTOR_STATUS_PENDING_ML);
    ml2sim_advance(10 * kMillisecond);
    EXPECT_EQ(getMarkers(), XR_ERROR_CALL_ORDER_INVALID);
    expectMisuse(ML2SIM_XR_MISUSE_ORDER, "markers before the snapshot was seen to be ready");
    see();
    EXPECT_GT(count, 0u);
    EXPECT_EQ(snapshot(), XR_SUCCESS) << "also while another is pending";
    EXPECT_EQ(snapshot(), XR_SUCCESS);
}

TEST_F(MarkerRules, AMarkerThatIsNotInThisSnapshotIsInvalid) {
    createWithSize();
    see();
    float length_m;
    EXPECT_EQ(XR(xrGetMarkerLengthML)(detector, markers[0], &length_m), XR_SUCCESS);
    EXPECT_EQ(XR(xrGetMarkerLengthML)(detector, markers[0] + 1000, &length_m), XR_ERROR_MARKER_INVALID_ML);
}

TEST_F(MarkerRules, AnArUcoMarkerHasNoText) {
    createWithSize();
    see();
    char text[16];
    EXPECT_EQ(XR(xrGetMarkerStringML)(detector, markers[0], 16, &count, text),
              XR_ERROR_MARKER_DETECTOR_INVALID_DATA_QUERY_ML);
    expectMisuse(ML2SIM_XR_MISUSE_ARGUMENT, "the text of a number");
}

TEST_F(MarkerRules, ASpaceOutlivesTheDetectorAndIsThenNotTracked) {
    createWithSize();
    see();
    const XrMarkerSpaceCreateInfoML info = {
        XR_TYPE_MARKER_SPACE_CREATE_INFO_ML, nullptr, detector, markers[0], {{0, 0, 0, 1}, {0, 0, 0}}};
    XrSpace space = XR_NULL_HANDLE, local = XR_NULL_HANDLE;
    ASSERT_EQ(XR(xrCreateMarkerSpaceML)(app->session, &info, &space), XR_SUCCESS);
    const XrReferenceSpaceCreateInfo reference = {
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
    ASSERT_EQ(XR(xrCreateReferenceSpace)(app->session, &reference, &local), XR_SUCCESS);
    const XrTime now = ml2sim_now_mltime();
    const auto flags = [&] {
        XrSpaceLocation location = {XR_TYPE_SPACE_LOCATION, nullptr, 0, {}};
        EXPECT_EQ(XR(xrLocateSpace)(space, local, now, &location), XR_SUCCESS);
        return location.locationFlags;
    };
    EXPECT_NE(flags() & XR_SPACE_LOCATION_POSITION_TRACKED_BIT, 0u);
    EXPECT_EQ(XR(xrDestroyMarkerDetectorML)(detector), XR_SUCCESS);
    EXPECT_EQ(flags() & XR_SPACE_LOCATION_POSITION_TRACKED_BIT, 0u);
    EXPECT_EQ(XR(xrDestroySpace)(space), XR_SUCCESS);
    EXPECT_EQ(XR(xrDestroySpace)(local), XR_SUCCESS);
    createWithSize();
}
