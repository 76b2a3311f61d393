#pragma once

#include <cstddef>
#include <cstdint>

namespace ml2sim {

/** Encodes RGB rows without padding as 4:2:0 JPEG and returns its size. Aborts if capacity is too small. */
size_t encodeJpeg(const uint8_t *rgb, uint32_t width, uint32_t height, uint8_t *out, size_t capacity);

/** Decodes a 4:2:0 JPEG of ours to NV21: rows of brightness, then rows of pairs of V and U; all without padding. */
void decodeNv21(const uint8_t *jpeg, size_t bytes, uint8_t *out);

} // namespace ml2sim
