#pragma once

#include <cstddef>
#include <cstdint>

namespace ml2sim {

/** Encodes R G B rows without padding, 4:2:0, into memory of capacity bytes; the bytes used. Aborts when it is too
 * small. */
size_t encodeJpeg(const uint8_t *rgb, uint32_t width, uint32_t height, uint8_t *out, size_t capacity);

} // namespace ml2sim
