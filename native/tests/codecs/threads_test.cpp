// Several threads that encode at a time share nothing.
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "encoded.h"

TEST(EncodeThreads, GetTheSameBytesAsOneThread) {
    std::vector<float> pixels(160 * 120);
    for (size_t i = 0; i < pixels.size(); i++) {
        pixels[i] = 1 + std::sin(static_cast<float>(i) * 0.01f);
    }
    const std::vector<ml2s_image> images = {
        imageOf(ML2S_CODEC_GREY_JPEG, 30, 160, 120, 640, pixels.data(), 4 * pixels.size()),
        imageOf(ML2S_CODEC_GREY_JPEG, 90, 157, 119, 640, pixels.data(), 4 * pixels.size()),
        imageOf(ML2S_CODEC_DEPTH_RVL, 0, 160, 120, 640, pixels.data(), 4 * pixels.size()),
    };
    std::vector<std::thread> threads;
    for (const auto &image : images) {
        const auto expected = encoded(image);
        threads.emplace_back([image, expected] {
            for (int i = 0; i < 20; i++) {
                EXPECT_EQ(encoded(image), expected);
            }
        });
    }
    for (auto &thread : threads) {
        thread.join();
    }
}
