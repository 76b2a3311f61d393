// Markers of the room, and how the source follows the detector.
#include <algorithm>
#include <cstring>
#include <map>

#include "../../sim/scene/geometry.h"
#include "app.h"

extern "C" {
#include "../../sources/source.h"
}

namespace {

constexpr float kSide_m = 0.48f;

ml2s_settings aruco() {
    auto settings = settingsOf(ML2S_SENSOR_MARKERS, ML2S_STREAM_BIT(ML2S_STREAM_MARKERS));
    settings.backend = ML2S_BACKEND_OPENXR;
    settings.marker_type = XR_MARKER_TYPE_ARUCO_ML;
    settings.marker_dictionary = XR_MARKER_ARUCO_DICT_5X5_100_ML;
    settings.marker_length_m = kSide_m;
    return settings;
}
ml2s_settings april() {
    auto settings = aruco();
    settings.marker_type = XR_MARKER_TYPE_APRIL_TAG_ML;
    settings.marker_dictionary = XR_MARKER_APRIL_TAG_DICT_36H11_ML;
    return settings;
}
ml2s_settings qr() {
    auto settings = aruco();
    settings.marker_type = XR_MARKER_TYPE_QR_ML;
    return settings;
}

ml2sim::Vec3 axis(const ml2s_reading &marker, ml2sim::Vec3 own) {
    const auto *q = marker.rotation;
    return ml2sim::rotate({q[0], q[1], q[2], q[3]}, own);
}

/** The corners of a tag, read from the text that tests of other languages read. */
std::vector<ml2sim::Vec3> cornersOf(uint64_t tag) {
    const std::string all = ml2sim_landmarks();
    const auto from = all.find("{\"id\": " + std::to_string(tag) + ",");
    EXPECT_NE(from, std::string::npos);
    std::vector<ml2sim::Vec3> corners(4);
    const char *at = std::strchr(all.c_str() + from, '[') + 1;
    for (auto &corner : corners) {
        int used = 0;
        EXPECT_EQ(std::sscanf(at, "[%lf, %lf, %lf]%n", &corner.x, &corner.y, &corner.z, &used), 3);
        at += used + 2;
    }
    return corners;
}

/** Checks centre and axes against the corners, clockwise from the top left. */
void expectAsLaidOut(const ml2s_reading &marker, uint64_t tag, ml2sim::Vec3 right = {1, 0, 0},
                     ml2sim::Vec3 up = {0, 1, 0}) {
    const auto corners = cornersOf(tag);
    const auto center = 0.5 * (corners[0] + corners[2]);
    const ml2sim::Vec3 position{marker.position[0], marker.position[1], marker.position[2]};
    EXPECT_LT(length(position - center), 1e-4);
    constexpr double kHundredthOfDegree_rad = 1.7e-4;
    EXPECT_LT(length(axis(marker, right) - normalized(corners[1] - corners[0])), kHundredthOfDegree_rad);
    EXPECT_LT(length(axis(marker, up) - normalized(corners[0] - corners[3])), kHundredthOfDegree_rad);
}

} // namespace

class Markers : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        headset("trajectory", STILL_HEAD);
        runtime("markers.delay_ms", "0");
    }
    void TearDown() override {
        if (isOpen) {
            EXPECT_EQ(openxr_markers.close(nullptr, nullptr), ML2S_OK);
        }
        headset("trajectory", "");
        headset("tags", "4X4_50"); // other tests share the scene
        OpenXr::TearDown();
    }
    ml2s_result open(const ml2s_settings &settings) {
        const auto result = openxr_markers.open(&settings, &error);
        isOpen = result == ML2S_OK;
        return result;
    }
    std::vector<ml2s_reading> poll(ml2s_result expected = ML2S_OK) {
        std::vector<ml2s_reading> memory(32, sized<ml2s_reading>());
        readings readings = {reinterpret_cast<uint8_t *>(memory.data()), sizeof(ml2s_reading), 32, 0};
        EXPECT_EQ(openxr_markers.poll_readings(nullptr, &readings, &error), expected) << error.message;
        memory.resize(expected == ML2S_OK ? readings.count : 0);
        return memory;
    }
    /** The markers after one more snapshot. */
    std::vector<ml2s_reading> afterSnapshot() {
        poll();
        return poll();
    }

    ml2s_error error = sized<ml2s_error>();
    bool isOpen = false;
};

TEST_F(Markers, AreWhereTheyHangWithTheAxesOfArUco) {
    headset("tags", "5X5_100");
    ASSERT_EQ(open(aruco()), ML2S_OK) << error.message;
    EXPECT_TRUE(poll().empty()) << "nothing is known before the first snapshot";
    const auto seen = poll();
    ASSERT_GT(seen.size(), 3u);
    for (const auto &marker : seen) {
        expectAsLaidOut(marker, marker.id);
        EXPECT_EQ(marker.stream, uint32_t{ML2S_STREAM_MARKERS});
        EXPECT_STREQ(marker.name, "");
        EXPECT_FLOAT_EQ(marker.values[ML2S_MARKER_LENGTH_M], kSide_m);
        EXPECT_FLOAT_EQ(marker.values[ML2S_MARKER_REPROJECTION_ERROR_M], 0.0005f);
    }
}

TEST_F(Markers, FramesOfAprilTagsAreTurnedAboutX) {
    headset("tags", "36h11");
    ASSERT_EQ(open(april()), ML2S_OK) << error.message;
    const auto seen = afterSnapshot();
    ASSERT_GT(seen.size(), 3u);
    for (const auto &marker : seen)
        expectAsLaidOut(marker, marker.id, {1, 0, 0}, {0, -1, 0});
}

TEST_F(Markers, QrCodesHaveTheirTextAsName) {
    headset("tags", "QR");
    ASSERT_EQ(open(qr()), ML2S_OK) << error.message;
    const auto seen = afterSnapshot();
    ASSERT_GT(seen.size(), 0u);
    for (const auto &marker : seen) {
        const std::string name = marker.name;
        ASSERT_EQ(name.rfind("ml2-", 0), 0u) << name;
        EXPECT_EQ(marker.id, 0u);
        expectAsLaidOut(marker, std::stoul(name.substr(4)));
    }
}

TEST_F(Markers, ADetectorOfAnotherDictionarySeesNone) {
    headset("tags", "36h11");
    ASSERT_EQ(open(aruco()), ML2S_OK) << error.message;
    EXPECT_TRUE(afterSnapshot().empty());
}

TEST_F(Markers, ThoseThatAreNotTrackedAreLeftOut) {
    headset("tags", "5X5_100");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    EXPECT_FALSE(afterSnapshot().empty());
    runtime("fault.markers.untracked", "1");
    EXPECT_TRUE(afterSnapshot().empty());
    runtime("fault.markers.untracked", "0");
    EXPECT_FALSE(poll().empty());
}

TEST_F(Markers, AFalseDetectionLastsUntilTheSnapshotWithoutIt) {
    headset("tags", "36h11"); // so that none of the room's takes its place
    runtime("fault.markers.false", "1");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    poll();
    for (const int expected : {1, 0, 1, 0}) {
        const auto seen = poll();
        const auto isFalse = [](const ml2s_reading &marker) { return marker.id == 77; };
        EXPECT_EQ(std::count_if(seen.begin(), seen.end(), isFalse), expected);
        for (const auto &marker : seen) {
            EXPECT_FLOAT_EQ(marker.values[ML2S_MARKER_REPROJECTION_ERROR_M], 0.02f);
        }
    }
}

TEST_F(Markers, MoreThanTheVendorSaysAreTakenToo) {
    headset("tags", "36h11");
    ASSERT_EQ(open(april()), ML2S_OK) << error.message;
    EXPECT_EQ(afterSnapshot().size(), 16u);
    headset("assume.marker_limit", "20");
    EXPECT_GT(afterSnapshot().size(), 16u);
    headset("assume.marker_limit", "16");
}

TEST_F(Markers, TooSmallOnesAreNotSeen) {
    headset("tags", "5X5_100");
    runtime("markers.least_pixels", "1000");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    EXPECT_TRUE(afterSnapshot().empty());
}

TEST_F(Markers, TheRgbCameraSeesFewerThanTheThreeWorldCameras) {
    headset("tags", "5X5_100");
    std::map<ml2s_marker_camera, size_t> seen;
    for (const auto camera : {ML2S_MARKER_CAMERA_WORLD, ML2S_MARKER_CAMERA_RGB}) {
        auto settings = aruco();
        settings.marker_camera = camera;
        ASSERT_EQ(open(settings), ML2S_OK) << error.message;
        seen[camera] = afterSnapshot().size();
        EXPECT_EQ(openxr_markers.close(nullptr, nullptr), ML2S_OK);
        isOpen = false;
    }
    EXPECT_GT(seen[ML2S_MARKER_CAMERA_RGB], 0u);
    EXPECT_GT(seen[ML2S_MARKER_CAMERA_WORLD], seen[ML2S_MARKER_CAMERA_RGB]);
}

TEST_F(Markers, EachHasOneSpaceUntilItWasNotSeenForTenSeconds) {
    headset("tags", "5X5_100");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    const auto before = counters().live_objects;
    const auto seen = afterSnapshot().size();
    EXPECT_GT(seen, 0u);
    const int64_t begin = ml2s_now();
    afterSnapshot();
    EXPECT_EQ(counters().live_objects, before + seen);
    headset("tags", "36h11");
    while (counters().live_objects > before && ml2s_now() - begin < 60000 * kMillisecond)
        afterSnapshot();
    EXPECT_EQ(counters().live_objects, before);
    EXPECT_GE(ml2s_now() - begin, 10000 * kMillisecond);
}

TEST_F(Markers, OtherSettingsMakeAnotherDetectorAndAfterRefusedOnesEachPollSaysSo) {
    headset("tags", "5X5_100");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    EXPECT_FALSE(afterSnapshot().empty());
    const auto settings = april(), first = aruco();
    EXPECT_EQ(openxr_markers.configure(&settings, &error), ML2S_OK);
    EXPECT_TRUE(afterSnapshot().empty()) << "no AprilTags hang here";
    runtime("fault.markers.denied", "1");
    EXPECT_EQ(openxr_markers.configure(&first, &error), ML2S_PERMISSION_DENIED);
    runtime("fault.markers.denied", "0");
    poll(ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "the marker detector did not start with its new settings");
    EXPECT_EQ(openxr_markers.configure(&first, &error), ML2S_OK);
    EXPECT_FALSE(afterSnapshot().empty());
}

TEST_F(Markers, WhatCannotBeHadIsSaid) {
    struct {
        const char *fault;
        ml2s_result result;
        const char *message;
    } const rows[] = {
        {"fault.markers.denied", ML2S_PERMISSION_DENIED,
         "xrCreateMarkerDetectorML: XR_ERROR_MARKER_DETECTOR_PERMISSION_DENIED_ML (-1000138000)"},
        {"fault.markers.unsupported", ML2S_NOT_AVAILABLE, "not available: markers (the system does not detect them)"},
    };
    for (const auto &row : rows) {
        runtime(row.fault, "1");
        EXPECT_EQ(open(aruco()), row.result);
        EXPECT_STREQ(error.message, row.message);
        EXPECT_EQ(counters().live_objects, 0u);
        runtime(row.fault, "0");
    }
}

TEST_F(Markers, ASnapshotThatFailsIsSaid) {
    runtime("fault.markers.fails", "1");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    poll();
    poll(ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "xrSnapshotMarkerDetectorML: the snapshot failed");
}

TEST_F(Markers, ASnapshotThatIsNeverReadyIsSaidAndNoPollWaitsForIt) {
    runtime("fault.markers.stuck", "1");
    ASSERT_EQ(open(aruco()), ML2S_OK);
    const int64_t begin = ml2s_now();
    auto memory = sized<ml2s_reading>();
    ml2s_result result = ML2S_OK;
    int polls = 0;
    for (; result == ML2S_OK && ml2s_now() - begin < 60000 * kMillisecond; polls++) {
        readings readings = {reinterpret_cast<uint8_t *>(&memory), sizeof memory, 1, 0};
        result = openxr_markers.poll_readings(nullptr, &readings, &error);
    }
    EXPECT_EQ(result, ML2S_VENDOR_FAILURE);
    EXPECT_GT(polls, 2) << "a poll waited for the snapshot";
    EXPECT_STREQ(error.message, "xrSnapshotMarkerDetectorML: not ready within 5 s");
}
