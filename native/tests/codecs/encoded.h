#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "../sources/sensor.h"

inline ml2s_image imageOf(uint32_t codec, uint32_t quality, uint32_t width, uint32_t height, uint32_t stride,
                          const void *data, uint64_t size) {
    return {sizeof(ml2s_image), codec, quality, width, height, stride, static_cast<const uint8_t *>(data), size};
}

inline uint64_t mostBytes(const ml2s_image &image) {
    auto error = sized<ml2s_error>();
    uint64_t most = 0;
    EXPECT_EQ(ml2s_most_encoded_bytes(&image, &most, &error), ML2S_OK) << error.message;
    return most;
}

/** Encodes into memory of the size that suffices for each content, and sees that nothing beyond is written. */
inline std::vector<uint8_t> encoded(const ml2s_image &image) {
    constexpr uint8_t kGuard = 0xa5;
    constexpr size_t kGuards = 64;
    const uint64_t most = mostBytes(image);
    std::vector<uint8_t> output(most + kGuards, kGuard);
    auto error = sized<ml2s_error>();
    uint64_t size = 0;
    EXPECT_EQ(ml2s_encode(&image, {output.data(), most}, &size, &error), ML2S_OK) << error.message;
    EXPECT_LE(size, most);
    EXPECT_TRUE(std::all_of(output.begin() + static_cast<std::ptrdiff_t>(most), output.end(),
                            [](uint8_t byte) { return byte == kGuard; }));
    output.resize(size);
    return output;
}
