// The colour camera, whose frames are JPEGs.
#include <cstdio>

#include <jpeglib.h>

#include <cstring>
#include <vector>

#include "headset.h"

class Color : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        ml2sim_advance(kSecond);
    }
    static std::vector<uint8_t> decode(const ml2sim_color_frame &frame, uint32_t *width, uint32_t *height) {
        jpeg_decompress_struct decoder{};
        jpeg_error_mgr errors{};
        decoder.err = jpeg_std_error(&errors);
        jpeg_create_decompress(&decoder);
        jpeg_mem_src(&decoder, frame.jpeg, frame.jpeg_bytes);
        jpeg_read_header(&decoder, TRUE);
        jpeg_start_decompress(&decoder);
        *width = decoder.output_width;
        *height = decoder.output_height;
        std::vector<uint8_t> rgb(size_t{*width} * *height * 3);
        while (decoder.output_scanline < *height) {
            auto *row = rgb.data() + size_t{decoder.output_scanline} * *width * 3;
            jpeg_read_scanlines(&decoder, &row, 1);
        }
        jpeg_finish_decompress(&decoder);
        jpeg_destroy_decompress(&decoder);
        return rgb;
    }
};

TEST_F(Color, AFrameIsAJpegOfItsSizeWithTheIntrinsicsOfTheVendorTag) {
    const ml2sim_color_request request = {640, 480, 30, 0};
    ml2sim_color_frame frame;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &frame), 0);
    uint32_t width = 0, height = 0;
    decode(frame, &width, &height);
    EXPECT_EQ(width, 640u);
    EXPECT_EQ(height, 480u);
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
    uint32_t width = 0, height = 0;
    EXPECT_NE(decode(plain, &width, &height), decode(mixed, &width, &height));
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
