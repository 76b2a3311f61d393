// Depth as a decoder reads it that was written here, from A. D. Wilson's paper and the layout of
// compressed_depth_image_transport.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "encoded.h"

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr size_t kHeader = 20;

uint32_t wordAt(const std::vector<uint8_t> &data, size_t at) {
    return data.at(at) | data.at(at + 1) << 8 | data.at(at + 2) << 16 | uint32_t{data.at(at + 3)} << 24;
}

/** The numbers of an RVL stream. */
class Numbers {
  public:
    explicit Numbers(const std::vector<uint8_t> &data) {
        for (size_t at = kHeader; at < data.size(); at += 4) {
            const uint32_t word = wordAt(data, at);
            for (int shift = 28; shift >= 0; shift -= 4) {
                nibbles_.push_back(word >> shift & 15);
            }
        }
    }
    uint64_t next() {
        uint64_t number = 0;
        for (int shift = 0;; shift += 3) {
            const uint64_t nibble = nibbles_.at(at_++);
            number |= (nibble & 7) << shift;
            if (nibble < 8) {
                return number;
            }
        }
    }
    /** Returns true if only the zeros are left that fill the last word. */
    bool isAtEnd() const {
        return nibbles_.size() - at_ < 8 && std::all_of(nibbles_.begin() + static_cast<std::ptrdiff_t>(at_),
                                                        nibbles_.end(), [](uint32_t nibble) { return nibble == 0; });
    }

  private:
    std::vector<uint32_t> nibbles_;
    size_t at_ = 0;
};

std::vector<uint16_t> decoded(const std::vector<uint8_t> &data) {
    const size_t count = size_t{wordAt(data, 12)} * wordAt(data, 16);
    std::vector<uint16_t> pixels;
    Numbers numbers(data);
    int64_t previous = 0;
    while (pixels.size() < count) {
        pixels.resize(pixels.size() + numbers.next(), 0);
        for (uint64_t left = numbers.next(); left; left--) {
            const auto number = static_cast<int64_t>(numbers.next());
            previous += number % 2 ? -(number + 1) / 2 : number / 2;
            pixels.push_back(static_cast<uint16_t>(previous));
        }
    }
    EXPECT_EQ(pixels.size(), count);
    EXPECT_TRUE(numbers.isAtEnd());
    return pixels;
}

std::vector<uint8_t> encodedDepth(uint32_t width, uint32_t height, const std::vector<float> &metres,
                                  uint32_t strideFloats = 0) {
    const uint32_t stride = 4 * (strideFloats ? strideFloats : width);
    return encoded(imageOf(ML2S_CODEC_DEPTH_RVL, 0, width, height, stride, metres.data(), 4 * metres.size()));
}

/** A wall with noise as a sensor has it, edges and pixels without a value. */
std::vector<float> room(size_t count, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> noise;
    std::vector<float> metres(count);
    for (size_t i = 0; i < count; i++) {
        const float z = 1 + static_cast<float>(i % 700) * 0.004f + static_cast<float>(i / 900 % 3);
        metres[i] = random() % 20 ? z + (0.001f + 0.003f * z * z) * noise(random) : 0;
    }
    return metres;
}

/** Each value is within half a millimetre, and there is one where it has a place. */
void expectWithinHalfMillimetre(const std::vector<uint16_t> &found, const std::vector<float> &metres) {
    ASSERT_EQ(found.size(), metres.size());
    for (size_t i = 0; i < metres.size(); i++) {
        const double millimetres = 1000.0 * metres[i];
        if (millimetres >= 0.501 && millimetres <= 65535.49) {
            // A float of 65 m has steps of 0.004 mm.
            ASSERT_NEAR(found[i], millimetres, 0.504) << "pixel " << i;
        } else if (!(millimetres >= 0.499 && millimetres <= 65535.51)) {
            ASSERT_EQ(found[i], 0) << "pixel " << i << ": " << metres[i];
        }
    }
}

} // namespace

TEST(DepthRvl, AHandCheckedImage) {
    // 2 zeros, 1 value, 1000 * 2 = 03720: low groups first, each but the last with 8.
    const auto data = encodedDepth(3, 1, {0, 0, 1});
    const std::vector<uint8_t> expected = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0,    0,    0,     // int32 0, A 0, B 0
                                           3, 0, 0, 0, 1, 0, 0, 0, 0, 0xf3, 0x8a, 0x21}; // columns, rows, 0x218af300
    EXPECT_EQ(data, expected);
}

TEST(DepthRvl, LastWordsAreFullOrFilledWithZeros) {
    for (uint32_t width = 1; width <= 64; width++) {
        std::vector<float> metres(width, 1);
        EXPECT_EQ(decoded(encodedDepth(width, 1, metres)), std::vector<uint16_t>(width, 1000));
    }
}

TEST(DepthRvl, DepthIsWithinHalfAMillimetre) {
    const auto metres = room(size_t{544} * 480, 1);
    const auto data = encodedDepth(544, 480, metres);
    expectWithinHalfMillimetre(decoded(data), metres);
    EXPECT_LT(data.size(), metres.size() * 2);
}

TEST(DepthRvl, EveryNumberOfMillimetresIsExact) {
    std::vector<float> metres;
    std::vector<uint16_t> expected;
    for (uint32_t millimetres = 0; millimetres <= 65535; millimetres++) {
        metres.push_back(static_cast<float>(millimetres) / 1000);
        expected.push_back(static_cast<uint16_t>(millimetres));
    }
    EXPECT_EQ(decoded(encodedDepth(256, 256, metres)), expected);
}

TEST(DepthRvl, WhatHasNoNumberOfMillimetresIs0) {
    const std::vector<float> none = {
        kNaN,    -kNaN, kInfinity, -kInfinity, -1.0f,  -0.0f,    0.0f,      0.0004f,
        65.536f, 66.0f, 1e30f,     -1e30f,     1e-40f, 65.5356f, 8388.608f, std::numeric_limits<float>::max()};
    EXPECT_EQ(decoded(encodedDepth(static_cast<uint32_t>(none.size()), 1, none)),
              std::vector<uint16_t>(none.size(), 0));
    for (float value : none) {
        // Between others, at each place of a vector
        for (uint32_t place = 0; place < 6; place++) {
            std::vector<float> metres(6, 2);
            metres[place] = value;
            std::vector<uint16_t> expected(6, 2000);
            expected[place] = 0;
            EXPECT_EQ(decoded(encodedDepth(2, 3, metres)), expected) << value;
        }
    }
}

TEST(DepthRvl, RunsGoOnOverTheEndsOfRows) {
    for (uint32_t width = 1; width <= 33; width++) {
        for (uint32_t height : {1u, 2u, 3u, 8u, 33u}) {
            SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
            const auto metres = room(size_t{width} * height, width);
            expectWithinHalfMillimetre(decoded(encodedDepth(width, height, metres)), metres);
            for (float value : {0.0f, 3.0f}) {
                const std::vector<float> equal(size_t{width} * height, value);
                expectWithinHalfMillimetre(decoded(encodedDepth(width, height, equal)), equal);
            }
        }
    }
}

TEST(DepthRvl, ARowEndsBeforeItsStride) {
    const auto metres = room(size_t{61} * 43, 3);
    for (uint32_t stride : {61u, 62u, 64u, 100u}) {
        std::vector<float> padded(size_t{stride} * 42 + 61, 9); // no bytes after the last row
        for (uint32_t y = 0; y < 43; y++) {
            std::memcpy(padded.data() + size_t{y} * stride, metres.data() + size_t{y} * 61, 61 * sizeof(float));
        }
        EXPECT_EQ(encodedDepth(61, 43, padded, stride), encodedDepth(61, 43, metres));
    }
}

TEST(DepthRvl, TheLongestCodesFit) {
    constexpr uint32_t kSide = 100;
    std::vector<float> far(kSide * kSide), sparse(kSide * kSide), random(kSide * kSide);
    std::mt19937 bits(5);
    for (size_t i = 0; i < far.size(); i++) {
        far[i] = i % 2 ? 0.001f : 65.535f; // six groups each
        sparse[i] = i % 2 ? 0 : i % 4 ? 0.001f : 65.535f;
        const uint32_t word = static_cast<uint32_t>(bits());
        std::memcpy(&random[i], &word, sizeof word);
    }
    for (const auto &metres : {far, sparse, random}) {
        expectWithinHalfMillimetre(decoded(encodedDepth(kSide, kSide, metres)), metres);
    }
    EXPECT_EQ(encodedDepth(kSide, kSide, far).size(), kHeader + (kSide * kSide * 6 + 1 + 5 + 7) / 8 * 4);
}

TEST(DepthRvl, TheSizeThatSufficesIsSevenGroupsPerPixel) {
    EXPECT_EQ(mostBytes(imageOf(ML2S_CODEC_DEPTH_RVL, 0, 544, 480, 0, nullptr, 0)),
              kHeader + (544 * 480 * 7 + 2 + 7) / 8 * 4);
}

TEST(DepthRvl, LargeImagesAreDecoded) {
    const auto rows = room(size_t{4096} * 48, 11); // noise takes longer to draw than to encode
    std::vector<float> metres;
    for (int i = 0; i < 3072 / 48; i++) {
        metres.insert(metres.end(), rows.begin(), rows.end());
    }
    expectWithinHalfMillimetre(decoded(encodedDepth(4096, 3072, metres)), metres);
}
