// Arguments that every codec refuses.
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "encoded.h"

namespace {

/** A valid image of 16 x 8 pixels, of which tests change fields. */
class Encode : public testing::TestWithParam<ml2s_codec> {
  protected:
    bool isJpeg() const { return GetParam() == ML2S_CODEC_GREY_JPEG; }
    uint32_t pixelBytes() const { return isJpeg() ? 1 : 4; }
    std::string name() const { return isJpeg() ? "grey_jpeg" : "depth_rvl"; }

    alignas(64) uint8_t pixels_[16 * 8 * 4 + 64] = {};
    ml2s_image image_ = imageOf(GetParam(), isJpeg() ? 80 : 0, 16, 8, 16 * pixelBytes(), pixels_, 128 * pixelBytes());
    std::vector<uint8_t> output_ = std::vector<uint8_t>(mostBytes(image_), 0xa5);

    /** The message of the failure; nothing was written. */
    std::string failure(uint64_t outputBytes) {
        auto error = sized<ml2s_error>();
        uint64_t size = 77;
        EXPECT_EQ(ml2s_encode(&image_, {output_.data(), outputBytes}, &size, &error), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(size, 77u);
        EXPECT_EQ(output_, std::vector<uint8_t>(output_.size(), 0xa5));
        EXPECT_EQ(ml2s_encode(&image_, {output_.data(), outputBytes}, &size, nullptr), ML2S_INVALID_ARGUMENT);
        return error.message;
    }
    std::string failure() { return failure(output_.size()); }
};

INSTANTIATE_TEST_SUITE_P(Codecs, Encode, testing::Values(ML2S_CODEC_GREY_JPEG, ML2S_CODEC_DEPTH_RVL));

} // namespace

TEST_P(Encode, AValidImageIsEncoded) {
    uint64_t size = 0;
    EXPECT_EQ(ml2s_encode(&image_, {output_.data(), output_.size()}, &size, nullptr), ML2S_OK);
    EXPECT_GT(size, 0u);
}

TEST_P(Encode, UnknownCodecsAreRefused) {
    for (uint32_t codec : {0u, 3u, 64u, UINT32_MAX}) {
        image_.codec = codec;
        EXPECT_EQ(failure(), "unknown codec " + std::to_string(codec));
    }
}

TEST_P(Encode, QualitiesOutsideTheRangeAreRefused) {
    for (uint32_t quality : {isJpeg() ? 0u : 1u, 101u, UINT32_MAX}) {
        image_.quality = quality;
        EXPECT_EQ(failure(), name() + ": quality " + std::to_string(quality) + ", but it is " +
                                 (isJpeg() ? "1 to 100" : "0 to 0"));
    }
}

TEST_P(Encode, SizesOutsideTheRangeAreRefused) {
    for (uint32_t side : {0u, 65536u, UINT32_MAX}) {
        image_.width = side;
        EXPECT_EQ(failure(), name() + ": " + std::to_string(side) + " x 8 pixels, but each side has 1 to 65535");
        image_.width = 16;
        image_.height = side;
        EXPECT_EQ(failure(), name() + ": 16 x " + std::to_string(side) + " pixels, but each side has 1 to 65535");
        auto error = sized<ml2s_error>();
        uint64_t most = 77;
        EXPECT_EQ(ml2s_most_encoded_bytes(&image_, &most, &error), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(most, 77u);
        image_.height = 8;
    }
}

TEST_P(Encode, AnImageThatExceedsItsMemoryIsRefused) {
    image_.size_bytes--;
    EXPECT_EQ(failure(), name() + ": the image has " + std::to_string(128 * pixelBytes() - 1) +
                             " bytes, but 16 x 8 pixels need " + std::to_string(128 * pixelBytes()));
    image_.size_bytes = std::numeric_limits<uint64_t>::max();
    image_.stride_bytes = 16 * pixelBytes() - pixelBytes();
    EXPECT_EQ(failure(), name() + ": a stride of " + std::to_string(15 * pixelBytes()) + " bytes, but a row has " +
                             std::to_string(16 * pixelBytes()));
    image_.stride_bytes = 0;
    EXPECT_NE(failure(), "");
    image_.stride_bytes = 0xfffffffc; // the product does not fit 32 bits
    image_.size_bytes = 128 * pixelBytes();
    EXPECT_NE(failure(), "");
}

TEST_P(Encode, FloatsAtOddPlacesAreRefused) {
    image_.data++;
    image_.size_bytes = 1000;
    if (isJpeg()) {
        encoded(image_);
        return;
    }
    EXPECT_EQ(failure(), "depth_rvl: data and stride_bytes must be multiples of 4");
    image_.data--;
    image_.stride_bytes = 66;
    EXPECT_EQ(failure(), "depth_rvl: data and stride_bytes must be multiples of 4");
}

TEST_P(Encode, OutputThatCouldBeTooSmallIsRefused) {
    const auto most = std::to_string(output_.size());
    EXPECT_EQ(failure(output_.size() - 1), name() + ": output has " + std::to_string(output_.size() - 1) +
                                               " bytes, but ml2s_most_encoded_bytes is " + most +
                                               "; or a pointer is null");
    EXPECT_NE(failure(0), "");
}

TEST_P(Encode, MissingPointersAreRefused) {
    auto error = sized<ml2s_error>();
    uint64_t size;
    ml2s_memory output = {output_.data(), output_.size()};
    EXPECT_EQ(ml2s_encode(nullptr, output, &size, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_encode(&image_, output, nullptr, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_encode(&image_, {nullptr, 1 << 20}, &size, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_most_encoded_bytes(nullptr, &size, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_most_encoded_bytes(&image_, nullptr, &error), ML2S_INVALID_ARGUMENT);
    image_.data = nullptr;
    EXPECT_EQ(failure(), name() + ": data is null");
}

TEST_P(Encode, StructuresOfAnotherSizeAreRefused) {
    ml2s_error shortError = {};
    uint64_t size;
    EXPECT_EQ(ml2s_encode(&image_, {output_.data(), output_.size()}, &size, &shortError), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_most_encoded_bytes(&image_, &size, &shortError), ML2S_INVALID_ARGUMENT);
    image_.struct_size--;
    EXPECT_EQ(failure(), "image: struct_size is smaller than the structure, or image is null");
}
