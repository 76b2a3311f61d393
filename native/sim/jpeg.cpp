#include "jpeg.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

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

void decodeNv21(const uint8_t *jpeg, size_t bytes, uint8_t *out) {
    constexpr JDIMENSION kRows = 2 * DCTSIZE;
    jpeg_decompress_struct decoder{};
    jpeg_error_mgr errors{};
    decoder.err = jpeg_std_error(&errors);
    jpeg_create_decompress(&decoder);
    jpeg_mem_src(&decoder, jpeg, bytes);
    jpeg_read_header(&decoder, TRUE);
    decoder.raw_data_out = TRUE;
    decoder.out_color_space = JCS_YCbCr;
    jpeg_start_decompress(&decoder);
    const size_t width = decoder.output_width, height = decoder.output_height, half = (width + 1) / 2;
    std::vector<uint8_t> memory[3];
    std::vector<JSAMPROW> rows[3];
    JSAMPARRAY planes[3];
    for (int i = 0; i < 3; i++) {
        const size_t row = size_t{decoder.comp_info[i].width_in_blocks} * DCTSIZE;
        memory[i].resize(row * kRows);
        for (size_t at = 0; at < kRows; at++)
            rows[i].push_back(memory[i].data() + at * row);
        planes[i] = rows[i].data();
    }
    uint8_t *chroma = out + width * height;
    for (size_t top = 0; top < height; top += kRows) {
        jpeg_read_raw_data(&decoder, planes, kRows);
        const size_t count = std::min<size_t>(kRows, height - top);
        for (size_t row = 0; row < count; row++)
            out = std::copy_n(planes[0][row], width, out);
        for (size_t row = 0; row < (count + 1) / 2; row++)
            for (size_t column = 0; column < half; column++) {
                *chroma++ = planes[2][row][column];
                *chroma++ = planes[1][row][column];
            }
    }
    jpeg_finish_decompress(&decoder);
    jpeg_destroy_decompress(&decoder);
}

} // namespace ml2sim
