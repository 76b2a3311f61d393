// The JPEGs of the library as libjpeg reads them, beside those that libjpeg makes of the same pixels.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "encoded.h"
#include "libjpeg.h"

namespace {

using Content = std::function<int(uint32_t x, uint32_t y)>;

std::map<std::string, Content> contents() {
    const auto random = std::make_shared<std::mt19937>(7);
    const auto noise = [random](double deviation) { return std::normal_distribution<>(0, deviation)(*random); };
    return {{"black", [](uint32_t, uint32_t) { return 0; }},
            {"white", [](uint32_t, uint32_t) { return 255; }},
            {"noise", [random](uint32_t, uint32_t) { return static_cast<int>((*random)() & 255); }},
            {"black and white noise", [random](uint32_t, uint32_t) { return ((*random)() & 1) * 255; }},
            {"checker", [](uint32_t x, uint32_t y) { return (x + y) % 2 ? 255 : 0; }},
            {"gradient", [](uint32_t x, uint32_t y) { return static_cast<int>((3 * x + y) / 4 % 256); }},
            {"scene", [noise](uint32_t x, uint32_t y) {
                 return static_cast<int>(std::lround(128 + 70 * std::sin(x / 9.0) * std::cos(y / 13.0) +
                                                     ((x / 31 + y / 17) % 2 ? 25 : -25) + noise(2)));
             }}};
}

/** Grey rows without padding. */
struct Picture {
    Picture(uint32_t width, uint32_t height, const Content &content)
        : width(width), height(height), pixels(size_t{width} * height) {
        for (uint32_t y = 0; y < height; y++) {
            for (uint32_t x = 0; x < width; x++) {
                pixels[size_t{y} * width + x] = static_cast<uint8_t>(std::clamp(content(x, y), 0, 255));
            }
        }
    }
    ml2s_image image(uint32_t quality) const {
        return imageOf(ML2S_CODEC_GREY_JPEG, quality, width, height, width, pixels.data(), pixels.size());
    }
    uint32_t width, height;
    std::vector<uint8_t> pixels;
};

double meanSquaredError(const Picture &picture, const Decoded &decoded) {
    double sum = 0;
    for (size_t i = 0; i < picture.pixels.size(); i++) {
        const double difference = static_cast<double>(picture.pixels[i]) - decoded.pixels[i];
        sum += difference * difference;
    }
    return sum / static_cast<double>(picture.pixels.size());
}

int largestError(const Picture &picture, const Decoded &decoded) {
    int largest = 0;
    for (size_t i = 0; i < picture.pixels.size(); i++) {
        largest = std::max(largest, std::abs(picture.pixels[i] - decoded.pixels[i]));
    }
    return largest;
}

/** Reads a JPEG with libjpeg: one component, baseline, no warning, the size. */
Decoded readBack(const Picture &picture, const std::vector<uint8_t> &jpeg) {
    auto decoded = libjpegDecoded(jpeg);
    EXPECT_EQ(decoded.components, 1);
    EXPECT_FALSE(decoded.isProgressive);
    EXPECT_EQ(decoded.warnings, 0);
    EXPECT_EQ(decoded.width, picture.width);
    EXPECT_EQ(decoded.height, picture.height);
    return decoded;
}

/** 0.1 dB of PSNR. */
constexpr double kTenthOfDecibel = 1.0233;

void expectAsGoodAndSmallAsLibjpeg(const Picture &picture, uint32_t quality) {
    const auto own = encoded(picture.image(quality));
    const auto ownDecoded = readBack(picture, own);
    double error = 0;
    size_t size = 0;
    // The decoder's integers undo the errors of libjpeg's own integers in black and white noise, but not those of its
    // floats.
    for (bool hasFloats : {false, true}) {
        const auto other =
            libjpegEncoded(picture.pixels, picture.width, picture.height, static_cast<int>(quality), hasFloats);
        const auto otherDecoded = libjpegDecoded(other);
        EXPECT_EQ(ownDecoded.divisors, otherDecoded.divisors);
        error = std::max(error, meanSquaredError(picture, otherDecoded));
        size = std::max(size, other.size());
    }
    EXPECT_LE(meanSquaredError(picture, ownDecoded), error * kTenthOfDecibel + 0.002);
    EXPECT_LE(static_cast<double>(own.size()), static_cast<double>(size) * 1.02);
}

} // namespace

TEST(GreyJpeg, EveryContentIsAsGoodAndSmallAsByLibjpeg) {
    for (const auto &[name, content] : contents()) {
        for (uint32_t quality : {50u, 80u, 95u}) {
            SCOPED_TRACE(name + " at quality " + std::to_string(quality));
            expectAsGoodAndSmallAsLibjpeg(Picture(256, 192, content), quality);
        }
    }
}

TEST(GreyJpeg, EveryQualityIsAsGoodAndSmallAsByLibjpeg) {
    const Picture picture(200, 200, contents().at("scene"));
    for (uint32_t quality = 1; quality <= 100; quality++) {
        SCOPED_TRACE(quality);
        expectAsGoodAndSmallAsLibjpeg(picture, quality);
    }
}

TEST(GreyJpeg, EverySizeIsDecoded) {
    const auto all = contents();
    for (uint32_t height = 1; height <= 33; height++) {
        for (uint32_t width = 1; width <= 33; width++) {
            SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
            const Picture gradient(width, height, all.at("gradient"));
            const auto other = libjpegEncoded(gradient.pixels, width, height, 90);
            EXPECT_LE(meanSquaredError(gradient, readBack(gradient, encoded(gradient.image(90)))),
                      meanSquaredError(gradient, libjpegDecoded(other)) + 0.5);
            const Picture noise(width, height, all.at("noise"));
            EXPECT_LE(largestError(noise, readBack(noise, encoded(noise.image(100)))), 2);
        }
    }
}

TEST(GreyJpeg, TheLargestImagesAreDecoded) {
    expectAsGoodAndSmallAsLibjpeg(Picture(4096, 3072, contents().at("gradient")), 80);
    expectAsGoodAndSmallAsLibjpeg(Picture(65500, 9, contents().at("noise")), 80); // libjpeg's own limit
    expectAsGoodAndSmallAsLibjpeg(Picture(9, 65500, contents().at("noise")), 80);
}

TEST(GreyJpeg, ARowEndsBeforeItsStride) {
    const Picture picture(61, 43, contents().at("scene"));
    for (uint32_t stride : {61u, 62u, 64u, 100u, 1024u}) {
        std::vector<uint8_t> padded(size_t{stride} * 42 + 61, 0xee); // no bytes after the last row
        for (uint32_t y = 0; y < 43; y++) {
            std::memcpy(padded.data() + size_t{y} * stride, picture.pixels.data() + size_t{y} * 61, 61);
        }
        const auto image = imageOf(ML2S_CODEC_GREY_JPEG, 85, 61, 43, stride, padded.data(), padded.size());
        EXPECT_EQ(encoded(image), encoded(picture.image(85)));
    }
}

TEST(GreyJpeg, TheLargestCoefficientsAreCoded) {
    // The signs of each basis function, in black and white, alternating with its negative: the largest coefficient,
    // and, for the first, the largest differences of the means.
    for (uint32_t u = 0; u < 8; u++) {
        for (uint32_t v = 0; v < 8; v++) {
            SCOPED_TRACE(std::to_string(u) + ", " + std::to_string(v));
            const Picture picture(64, 16, [&](uint32_t x, uint32_t y) {
                const double basis =
                    std::cos((2 * (x % 8) + 1) * u * M_PI / 16) * std::cos((2 * (y % 8) + 1) * v * M_PI / 16);
                return (basis > 0) != (x / 8 % 2 == 1) ? 255 : 0;
            });
            EXPECT_LE(meanSquaredError(picture, readBack(picture, encoded(picture.image(100)))), 0.5);
        }
    }
}

TEST(GreyJpeg, TheSizeThatSufficesIsThatOfTheLongestCodes) {
    const Picture one(8, 8, contents().at("black"));
    // A block of one longest DC code and 63 longest AC codes, each byte of them 0xff and 0.
    EXPECT_EQ(mostBytes(one.image(80)), 328u + 2 * ((9 + 11 + 63 * (16 + 10) + 7) / 8) + 2);
    const Picture largest(1, 1, contents().at("black"));
    auto image = largest.image(80);
    image.width = image.height = 65535;
    EXPECT_EQ(mostBytes(image), 328u + 2 * (uint64_t{8192} * 8192 * 1658 / 8) + 2);
}
