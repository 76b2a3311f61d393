#include "jpeg.h"

#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>

namespace ml2sim {

size_t encodeJpeg(const uint8_t *rgb, uint32_t width, uint32_t height, uint8_t *out, size_t capacity) {
    constexpr int kQuality = 85;
    jpeg_compress_struct encoder{};
    jpeg_error_mgr errors{};
    encoder.err = jpeg_std_error(&errors);
    jpeg_create_compress(&encoder);
    unsigned char *target = out;
    unsigned long used = capacity;
    jpeg_mem_dest(&encoder, &target, &used);
    encoder.image_width = width;
    encoder.image_height = height;
    encoder.input_components = 3;
    encoder.in_color_space = JCS_RGB;
    jpeg_set_defaults(&encoder);
    jpeg_set_quality(&encoder, kQuality, TRUE);
    jpeg_start_compress(&encoder, TRUE);
    while (encoder.next_scanline < height) {
        auto *row = const_cast<uint8_t *>(rgb) + size_t{encoder.next_scanline} * width * 3;
        jpeg_write_scanlines(&encoder, &row, 1);
    }
    jpeg_finish_compress(&encoder);
    jpeg_destroy_compress(&encoder);
    if (target != out) {
        std::fprintf(stderr, "ml2sim: a JPEG of %ux%u needs more than %zu bytes\n", width, height, capacity);
        std::abort();
    }
    return used;
}

} // namespace ml2sim
