#include "libjpeg.h"

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include <jpeglib.h>

namespace {

[[noreturn]] void fail(j_common_ptr codec) {
    char message[JMSG_LENGTH_MAX];
    codec->err->format_message(codec, message);
    throw std::runtime_error(message);
}

} // namespace

Decoded libjpegDecoded(const std::vector<uint8_t> &jpeg) {
    jpeg_error_mgr errors{};
    jpeg_decompress_struct decoder{};
    decoder.err = jpeg_std_error(&errors);
    errors.error_exit = fail;
    errors.output_message = [](j_common_ptr) {};
    jpeg_create_decompress(&decoder);
    try {
        jpeg_mem_src(&decoder, jpeg.data(), jpeg.size());
        jpeg_read_header(&decoder, TRUE);
        Decoded decoded;
        decoded.components = decoder.num_components;
        decoded.isProgressive = decoder.progressive_mode != 0;
        const auto *divisors = decoder.quant_tbl_ptrs[0]->quantval;
        decoded.divisors.assign(divisors, divisors + DCTSIZE2);
        decoder.out_color_space = JCS_GRAYSCALE;
        jpeg_start_decompress(&decoder);
        decoded.width = decoder.output_width;
        decoded.height = decoder.output_height;
        decoded.pixels.resize(size_t{decoded.width} * decoded.height);
        while (decoder.output_scanline < decoder.output_height) {
            auto *row = decoded.pixels.data() + size_t{decoder.output_scanline} * decoded.width;
            jpeg_read_scanlines(&decoder, &row, 1);
        }
        jpeg_finish_decompress(&decoder);
        decoded.warnings = errors.num_warnings;
        jpeg_destroy_decompress(&decoder);
        return decoded;
    } catch (...) {
        jpeg_destroy_decompress(&decoder);
        throw;
    }
}

std::vector<uint8_t> libjpegEncoded(const std::vector<uint8_t> &pixels, uint32_t width, uint32_t height, int quality,
                                    bool hasFloats) {
    jpeg_error_mgr errors{};
    jpeg_compress_struct encoder{};
    encoder.err = jpeg_std_error(&errors);
    jpeg_create_compress(&encoder);
    unsigned char *output = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&encoder, &output, &size);
    encoder.image_width = width;
    encoder.image_height = height;
    encoder.input_components = 1;
    encoder.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&encoder);
    jpeg_set_quality(&encoder, quality, TRUE);
    encoder.dct_method = hasFloats ? JDCT_FLOAT : JDCT_ISLOW;
    jpeg_start_compress(&encoder, TRUE);
    while (encoder.next_scanline < height) {
        auto *row = const_cast<uint8_t *>(pixels.data()) + size_t{encoder.next_scanline} * width;
        jpeg_write_scanlines(&encoder, &row, 1);
    }
    jpeg_finish_compress(&encoder);
    jpeg_destroy_compress(&encoder);
    std::vector<uint8_t> jpeg(output, output + size);
    std::free(output);
    return jpeg;
}
