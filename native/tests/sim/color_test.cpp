// The colour camera, whose frames are JPEGs.
#include "../codecs/libjpeg.h"
#include "headset.h"

#include <algorithm>

class Color : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        ml2sim_advance(kSecond);
    }
    static Decoded decode(const ml2sim_color_frame &frame) {
        return libjpegDecoded({frame.jpeg, frame.jpeg + frame.jpeg_bytes});
    }
};

TEST_F(Color, AFrameIsAJpegOfItsSizeWithTheIntrinsicsOfTheVendorTag) {
    const ml2sim_color_request request = {640, 480, 30, 0};
    ml2sim_color_frame frame;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &frame), 0);
    EXPECT_EQ(decode(frame).width, 640u);
    EXPECT_EQ(decode(frame).height, 480u);
    EXPECT_EQ(frame.intrinsics[0], 640);
    EXPECT_EQ(frame.intrinsics[1], 480);
    EXPECT_NEAR(frame.intrinsics[4], 320, 10);
    EXPECT_NEAR(frame.intrinsics[6], 75, 2);
}

TEST_F(Color, AHologramChangesThePicture) {
    ml2sim_color_request request = {1440, 1080, 30, 0};
    ml2sim_color_frame plain, mixed;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &plain), 0);
    request.with_hologram = 1;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &mixed), 0);
    EXPECT_NE(decode(plain).pixels, decode(mixed).pixels);
}

TEST_F(Color, FramesFollowEachOtherOnTheGridAndSayWhenTheNextComes) {
    const ml2sim_color_request request = {640, 480, 30, 0};
    ml2sim_color_frame first, same, next;
    const auto now = ml2sim_now_boottime();
    ASSERT_EQ(ml2sim_color(&request, now, &first), 0);
    ASSERT_EQ(ml2sim_color(&request, first.next_boottime - 10, &same), 0);
    ASSERT_EQ(ml2sim_color(&request, first.next_boottime + 10, &next), 0);
    EXPECT_EQ(same.frame_number, first.frame_number);
    EXPECT_EQ(next.frame_number, first.frame_number + 1);
    EXPECT_NEAR(double(next.capture_mltime - first.capture_mltime), kSecond / 30.0, 1);
    EXPECT_GT(ml2sim_mltime_of_boottime(now), first.capture_mltime);
}

TEST_F(Color, TheLoopShowsTheSameJpegAgain) {
    const ml2sim_color_request request = {640, 480, 15, 0};
    ml2sim_color_frame first, again;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &first), 0);
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime() + 2 * kSecond, &again), 0);
    EXPECT_EQ(first.jpeg, again.jpeg);
    EXPECT_EQ(again.frame_number, first.frame_number + 30);
}

TEST_F(Color, SizesAndRatesThatTheDeviceLacksAreRefused) {
    ml2sim_color_frame frame;
    for (const ml2sim_color_request request : {ml2sim_color_request{641, 480, 30, 0},
                                               {640, 480, 25, 0},
                                               {3840, 2160, 60, 0},
                                               {1920, 1080, 30, 1},
                                               {972, 1080, 15, 1}})
        EXPECT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &frame), -1);
}

TEST_F(Color, WithNoiseTheExposureFollowsTheLightWithALag) {
    set("noise", "1");
    const ml2sim_color_request request = {640, 480, 15, 0};
    ml2sim_color_frame frame;
    frame.next_boottime = ml2sim_now_boottime();
    int64_t shortest = INT64_MAX, longest = 0;
    for (int n = 0; n < 15; n++) {
        ASSERT_EQ(ml2sim_color(&request, frame.next_boottime, &frame), 0);
        const auto capture = ml2sim_boottime_of_mltime(frame.capture_mltime);
        constexpr double kLag_s = 0.3, kStep_s = 1e-3;
        double lux = 300;
        for (int64_t ago = 3000; ago > 0; ago--)
            lux += (double(ml2sim_light(capture - ago * kMillisecond)) - lux) * kStep_s / kLag_s;
        EXPECT_NEAR(double(frame.exposure_nanos), std::min(8e6, 8e6 * 300 / lux), 2e4);
        shortest = std::min(shortest, frame.exposure_nanos);
        longest = std::max(longest, frame.exposure_nanos);
    }
    EXPECT_LT(shortest, 7000000);
    EXPECT_EQ(longest, 8000000) << "in less light the gain is higher";
}
