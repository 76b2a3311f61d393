// Checks an image and encodes it with its codec.
#include <stdbool.h>
#include <stddef.h>

#include "../sdk/error.h"
#include "codec.h"

enum { MOST_PIXELS_PER_SIDE = 65535 };

static const struct codec *const codecs[] = {
    [ML2S_CODEC_GREY_JPEG] = &grey_jpeg,
    [ML2S_CODEC_DEPTH_RVL] = &depth_rvl,
};

/** Finds the codec of an image and checks the size in pixels. */
static ml2s_result find(const ml2s_image *image, const struct codec **out, ml2s_error *error) {
    if (!error_is_valid(error) || !image || image->struct_size < sizeof *image) {
        return error_set(error_is_valid(error) ? error : NULL, ML2S_INVALID_ARGUMENT, 0,
                         "image: struct_size is smaller than the structure, or image is null");
    }
    if (image->codec >= sizeof codecs / sizeof *codecs || !codecs[image->codec]) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "unknown codec %u", image->codec);
    }
    *out = codecs[image->codec];
    if (!image->width || image->width > MOST_PIXELS_PER_SIDE || !image->height ||
        image->height > MOST_PIXELS_PER_SIDE) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: %u x %u pixels, but each side has 1 to %u", (*out)->name,
                         image->width, image->height, MOST_PIXELS_PER_SIDE);
    }
    return ML2S_OK;
}

static ml2s_result check_quality(const ml2s_image *image, const struct codec *codec, ml2s_error *error) {
    if (image->quality < codec->least_quality || image->quality > codec->most_quality) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: quality %u, but it is %u to %u", codec->name,
                         image->quality, codec->least_quality, codec->most_quality);
    }
    return ML2S_OK;
}

static ml2s_result check_pixels(const ml2s_image *image, const struct codec *codec, ml2s_error *error) {
    uint64_t row_bytes = (uint64_t)image->width * codec->bytes_per_pixel;
    uint64_t needed = (uint64_t)(image->height - 1) * image->stride_bytes + row_bytes;
    if (!image->data) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: data is null", codec->name);
    }
    if (image->stride_bytes < row_bytes) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: a stride of %u bytes, but a row has %lld", codec->name,
                         image->stride_bytes, (long long)row_bytes);
    }
    if ((uintptr_t)image->data % codec->bytes_per_pixel || image->stride_bytes % codec->bytes_per_pixel) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: data and stride_bytes must be multiples of %u",
                         codec->name, codec->bytes_per_pixel);
    }
    if (image->size_bytes < needed) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s: the image has %lld bytes, but %u x %u pixels need %lld",
                         codec->name, (long long)image->size_bytes, image->width, image->height, (long long)needed);
    }
    return ML2S_OK;
}

ml2s_result ml2s_most_encoded_bytes(const ml2s_image *image, uint64_t *size_bytes, ml2s_error *error) {
    const struct codec *codec;
    ml2s_result result = find(image, &codec, error);
    if (!result && !size_bytes) {
        result = error_set(error, ML2S_INVALID_ARGUMENT, 0, "ml2s_most_encoded_bytes: size_bytes is null");
    }
    if (!result) {
        *size_bytes = codec->most_bytes(image->width, image->height);
    }
    return result;
}

ml2s_result ml2s_encode(const ml2s_image *image, ml2s_memory output, uint64_t *size_bytes, ml2s_error *error) {
    const struct codec *codec;
    ml2s_result result = find(image, &codec, error);
    if (result || (result = check_quality(image, codec, error)) || (result = check_pixels(image, codec, error))) {
        return result;
    }
    uint64_t most_bytes = codec->most_bytes(image->width, image->height);
    if (!output.data || !size_bytes || output.size_bytes < most_bytes) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "%s: output has %lld bytes, but ml2s_most_encoded_bytes is %lld; or a pointer is null",
                         codec->name, (long long)output.size_bytes, (long long)most_bytes);
    }
    *size_bytes = (uint64_t)(codec->encode(image, output.data) - output.data);
    return ML2S_OK;
}
