// A program that never told how to reach OpenXR.
#include "../sources/sensor.h"

TEST(OpenXrUnused, ASensorOfOpenXrSaysWhatIsToBeCalled) {
    auto settings = settingsOf(ML2S_SENSOR_HEAD, ML2S_STREAM_BIT(ML2S_STREAM_HEAD_POSE));
    settings.backend = ML2S_BACKEND_OPENXR;
    const Sensor head(settings);
    EXPECT_EQ(head.result, ML2S_NOT_AVAILABLE);
    EXPECT_EQ(std::string(head.error.message), "not available: OpenXR (ml2s_use_openxr was not called)");
}
