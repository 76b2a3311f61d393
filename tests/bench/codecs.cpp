// Times the encoders of libml2sensors in turns with libjpeg-turbo or with a plain loop, on the same images.
// Usage: codecs WORLD EYE DEPTH, files of raw pixels. Prints JSON.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

// Needs stdio before it.
#include <jpeglib.h>

#include "../../native/sdk/ml2s.h"

namespace {

constexpr int kTurns = 60;
constexpr uint32_t kQuality = 80;

struct Raw {
    std::vector<char> bytes;
    uint32_t width, height, bytesPerPixel;
};

Raw read(const char *path, uint32_t width, uint32_t height, uint32_t bytesPerPixel) {
    std::ifstream file(path, std::ios::binary);
    Raw raw{{std::istreambuf_iterator<char>(file), {}}, width, height, bytesPerPixel};
    if (raw.bytes.size() != size_t(width) * height * bytesPerPixel) {
        std::fprintf(stderr, "%s: expected %u x %u pixels, found %zu bytes\n", path, width, height, raw.bytes.size());
        std::exit(1);
    }
    return raw;
}

uint64_t encode(const Raw &raw, uint32_t codec, std::vector<uint8_t> &output) {
    ml2s_image image = {sizeof image,
                        codec,
                        codec == ML2S_CODEC_GREY_JPEG ? kQuality : 0,
                        raw.width,
                        raw.height,
                        raw.width * raw.bytesPerPixel,
                        reinterpret_cast<const uint8_t *>(raw.bytes.data()),
                        raw.bytes.size()};
    uint64_t size = 0;
    if (output.empty() && !ml2s_most_encoded_bytes(&image, &size, nullptr)) {
        output.resize(size);
    }
    if (ml2s_encode(&image, {output.data(), output.size()}, &size, nullptr)) {
        std::abort();
    }
    return size;
}

uint64_t encodeByLibjpeg(const Raw &raw, std::vector<uint8_t> &output) {
    jpeg_compress_struct jpeg;
    jpeg_error_mgr errors;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char *memory = output.data();
    unsigned long size = output.size();
    jpeg_mem_dest(&jpeg, &memory, &size);
    jpeg.image_width = raw.width;
    jpeg.image_height = raw.height;
    jpeg.input_components = 1;
    jpeg.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, kQuality, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < raw.height) {
        auto *row = reinterpret_cast<JSAMPLE *>(const_cast<char *>(raw.bytes.data())) + jpeg.next_scanline * raw.width;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return size;
}

/** RVL as its paper prints it, pixel by pixel. */
uint64_t encodeByLoop(const Raw &raw, std::vector<uint8_t> &output) {
    const auto *metres = reinterpret_cast<const float *>(raw.bytes.data());
    const size_t count = size_t(raw.width) * raw.height;
    std::vector<uint16_t> levels(count);
    for (size_t i = 0; i < count; i++) {
        const float millimetres = metres[i] * 1000;
        levels[i] = millimetres > 0 && millimetres < 65535.5f ? uint16_t(std::lround(millimetres)) : 0;
    }
    auto *next = reinterpret_cast<uint32_t *>(output.data());
    uint32_t word = 0, nibbles = 0;
    const auto put = [&](uint32_t number) {
        do {
            const uint32_t rest = number >> 3;
            word = word << 4 | (number & 7) | (rest ? 8 : 0);
            number = rest;
            if (++nibbles == 8) {
                *next++ = word;
                nibbles = word = 0;
            }
        } while (number);
    };
    int previous = 0;
    for (size_t i = 0; i < count;) {
        size_t zeros = i, values;
        for (; zeros < count && !levels[zeros]; zeros++) {
        }
        for (values = zeros; values < count && levels[values]; values++) {
        }
        put(uint32_t(zeros - i));
        put(uint32_t(values - zeros));
        for (i = zeros; i < values; i++) {
            const int difference = levels[i] - previous;
            previous = levels[i];
            put(uint32_t(difference << 1) ^ uint32_t(difference >> 31));
        }
    }
    if (nibbles) {
        *next++ = word << 4 * (8 - nibbles);
    }
    return uint64_t(reinterpret_cast<uint8_t *>(next) - output.data());
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/** Prints the median of each in milliseconds, and how many bytes the first writes. */
void print(const char *name, const std::vector<std::pair<const char *, std::function<uint64_t()>>> &encoders) {
    std::vector<std::vector<double>> times(encoders.size());
    uint64_t bytes = 0;
    for (int turn = 0; turn < kTurns; turn++) {
        for (size_t i = 0; i < encoders.size(); i++) {
            const auto begin = std::chrono::steady_clock::now();
            const uint64_t size = encoders[i].second();
            times[i].push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
            bytes = i ? bytes : size;
        }
    }
    std::printf("\"%s\": {\"bytes\": %llu", name, static_cast<unsigned long long>(bytes));
    for (size_t i = 0; i < encoders.size(); i++) {
        std::printf(", \"%s_ms\": %.3f", encoders[i].first, median(times[i]));
    }
    std::printf("}");
}

void printJpeg(const char *name, const Raw &raw) {
    std::vector<uint8_t> own, others(raw.bytes.size() * 2 + 1024);
    print(name, {{"own", [&] { return encode(raw, ML2S_CODEC_GREY_JPEG, own); }},
                 {"libjpeg_turbo", [&] { return encodeByLibjpeg(raw, others); }}});
}

} // namespace

int main(int count, char **paths) {
    if (count != 4) {
        return 2;
    }
    const Raw world = read(paths[1], 1016, 1016, 1), eye = read(paths[2], 400, 400, 1);
    const Raw depth = read(paths[3], 544, 480, 4);
    std::printf("{");
    printJpeg("world_jpeg", world);
    std::printf(", ");
    printJpeg("eye_jpeg", eye);
    std::printf(", ");
    std::vector<uint8_t> own, others(depth.bytes.size() * 2);
    print("depth16", {{"own", [&] { return encode(depth, ML2S_CODEC_DEPTH_RVL, own); }},
                      {"plain_loop", [&] { return encodeByLoop(depth, others); }}});
    std::printf("}\n");
}
