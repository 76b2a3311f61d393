#include <climits>
#include <string>

#include "../sources/sensor.h"

extern "C" {
#include "../../sdk/error.h"
#include "../../sdk/result.h"
}

TEST(Error, WritesTextAndNumbersAsPrintfDoes) {
    auto error = sized<ml2s_error>();
    EXPECT_EQ(error_set(&error, ML2S_BUSY, 7, "%s %d %u %x %lld.", "a", INT_MIN, UINT_MAX, 0xbeefu, LLONG_MIN),
              ML2S_BUSY);
    char expected[sizeof error.message];
    std::snprintf(expected, sizeof expected, "%s %d %u %x %lld.", "a", INT_MIN, UINT_MAX, 0xbeefu, LLONG_MIN);
    EXPECT_STREQ(error.message, expected);
    EXPECT_EQ(error.vendor_code, 7);
}

TEST(Error, CutsWhatDoesNotFit) {
    auto error = sized<ml2s_error>();
    error_set(&error, ML2S_BUSY, 0, "%s%s", std::string(200, 'a').c_str(), std::string(200, 'b').c_str());
    EXPECT_EQ(error.message, std::string(200, 'a') + std::string(47, 'b'));
}

TEST(Error, NobodyNeedsToWantTheMessage) { EXPECT_EQ(error_set(nullptr, ML2S_BUSY, 0, "x"), ML2S_BUSY); }

TEST(Result, NamesTheCallTheCodeAndItsNumber) {
    auto error = sized<ml2s_error>();
    EXPECT_EQ(result_of(5, "MLDepthCameraConnect", &error), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "MLDepthCameraConnect: InvalidParam (5)");
    EXPECT_EQ(error.vendor_code, 5);
    EXPECT_EQ(result_of(7, "MLEyeCameraConnect", &error), ML2S_PERMISSION_DENIED);
    EXPECT_STREQ(error.message, "MLEyeCameraConnect: PermissionDenied (7)");
    EXPECT_EQ(result_of(15, "X", &error), ML2S_NO_POSE);
    EXPECT_STREQ(error.message, "X: InvalidTimestamp (15)");
}

TEST(Result, GivesCodesOfOtherInterfacesInHexadecimal) {
    auto error = sized<ml2s_error>();
    EXPECT_EQ(result_of(static_cast<int32_t>(0x87b80000), "MLSnapshotGetTransform", &error), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "MLSnapshotGetTransform: MLResult 0x87b80000");
    EXPECT_EQ(result_of(16, "X", &error), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(error.message, "X: MLResult 0x10");
}

TEST(Result, OkAndTimeoutAreNoErrors) {
    auto error = sized<ml2s_error>();
    EXPECT_EQ(result_of(0, "X", &error), ML2S_OK);
    EXPECT_EQ(result_of(2, "X", &error), ML2S_TIMEOUT);
    EXPECT_STREQ(error.message, "");
}
