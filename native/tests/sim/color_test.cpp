// The colour camera, whose frames are JPEGs.
#include "../codecs/libjpeg.h"
#include "headset.h"

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
