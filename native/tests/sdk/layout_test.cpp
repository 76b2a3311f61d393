// The sizes and offsets are asserted where the types are declared; that this compiles as C++ asserts them for C++ too.
#include <cstring>

#include <gtest/gtest.h>

#include "../../sdk/tables.h"

TEST(Layout, InitialisersErasePaddingAndSetTheVersionsThatTheVendorChecks) {
    MLDepthCameraSettings depth;
    std::memset(&depth, 0xa5, sizeof depth);
    MLDepthCameraSettingsInit(&depth);
    const uint32_t expected[] = {2, 1, 1, 1600, 1, 1, 375, 1};
    static_assert(sizeof expected == sizeof depth);
    EXPECT_EQ(std::memcmp(&depth, expected, sizeof depth), 0);

    MLDepthCameraData depthData;
    std::memset(&depthData, 0xa5, sizeof depthData);
    MLDepthCameraDataInit(&depthData);
    const uint32_t emptyVersion3[] = {3, 0, 0, 0};
    EXPECT_EQ(std::memcmp(&depthData, emptyVersion3, sizeof depthData), 0);
}

TEST(Layout, EveryOtherStructureIsVersion1) {
    MLWorldCameraSettings world;
    MLWorldCameraSettingsInit(&world);
    EXPECT_EQ(world.version, 1u);
    EXPECT_EQ(world.mode, 2u);
    EXPECT_EQ(world.cameras, 7u);
    MLEyeCameraSettings eye;
    MLEyeCameraSettingsInit(&eye);
    EXPECT_EQ(eye.version, 1u);
    EXPECT_EQ(eye.cameras, 15u);
    MLWorldCameraData worldData;
    MLWorldCameraDataInit(&worldData);
    MLEyeCameraData eyeData;
    MLEyeCameraDataInit(&eyeData);
    MLHeadTrackingStateEx head;
    MLHeadTrackingStateExInit(&head);
    EXPECT_EQ(worldData.version, 1u);
    EXPECT_EQ(eyeData.version, 1u);
    EXPECT_EQ(head.version, 1u);
}
