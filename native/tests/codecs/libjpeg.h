#pragma once

#include <cstdint>
#include <vector>

/** A JPEG as libjpeg decodes it. */
struct Decoded {
    uint32_t width = 0, height = 0;
    int components = 0;
    bool isProgressive = false;
    long warnings = 0;
    std::vector<uint16_t> divisors;
    std::vector<uint8_t> pixels; /**< Grey, rows without padding. */
};

/** Decodes a JPEG; a fatal error throws std::runtime_error with libjpeg's message. */
Decoded libjpegDecoded(const std::vector<uint8_t> &jpeg);

/** Encodes grey rows without padding; the transform is that of integers, which libjpeg has by itself, or of floats. */
std::vector<uint8_t> libjpegEncoded(const std::vector<uint8_t> &pixels, uint32_t width, uint32_t height, int quality,
                                    bool hasFloats = false);
