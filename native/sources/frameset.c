#include "frameset.h"

#include <string.h>

#include "../sdk/dump.h"
#include "../sdk/error.h"

static struct size { uint32_t width, height; } usual[ML2S_STREAM_COUNT], last[ML2S_STREAM_COUNT];

static ml2s_frame *find_or_add(struct frameset *set, uint32_t stream) {
    for (uint32_t i = 0; i < set->count; i++) {
        if (set->frames[i].stream == stream) {
            return &set->frames[i];
        }
    }
    ml2s_frame *frame = &set->frames[set->count++];
    frame->skipped = 0;
    frame_begin(frame, stream, 0, 0);
    return frame;
}

static bool is_usable(const ml2s_frame *frame) { return frame->width; }

static void skip(struct frameset *set, uint32_t stream) { find_or_add(set, stream)->skipped++; }

ml2s_frame *frameset_add(struct frameset *set, uint32_t stream, ml2s_error *error) {
    ml2s_frame *frame = find_or_add(set, stream);
    if (!is_usable(frame)) {
        return frame;
    }
    error_set(error, ML2S_VENDOR_FAILURE, 0, "stream %u: two frames in one capture", stream);
    skip(set, stream);
    return NULL;
}

void frameset_complete(struct frameset *set, ml2s_frame *frame, ml2s_result result) {
    if (result) {
        frame_begin(frame, frame->stream, 0, 0);
        skip(set, frame->stream);
    }
}

/** Skips one frame of every stream, if the capture cannot be read at all. */
static void skip_all(struct frameset *set) {
    for (uint32_t stream = 0; stream < ML2S_STREAM_COUNT; stream++) {
        if (set->streams & ML2S_STREAM_BIT(stream)) {
            skip(set, stream);
        }
    }
}

static ml2s_result check_array(const void *frames, uint32_t count, uint32_t most, const char *name, ml2s_error *error) {
    if (count > most) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %u frames at once, expected at most %u", name, count,
                         most);
    }
    if (count && !frames) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: %u frames, but the pointer to them is null", name, count);
    }
    return ML2S_OK;
}

void frameset_copy(struct frameset *set, struct camera *camera, const ml2s_settings *settings, const void *frames,
                   uint32_t count, ml2s_error *error) {
    if (check_array(frames, count, camera->most_frames, camera->name, error)) {
        skip_all(set);
        return;
    }
    if (count) {
        dump_once(&camera->is_shown, camera->frame_name, frames, camera->frame_bytes, 0);
    }
    const uint8_t *from = frames;
    for (uint32_t i = 0; i < count; i++, from += camera->frame_bytes) {
        uint32_t stream = ML2S_STREAM_COUNT;
        if (camera->find_stream(settings, from, &stream, error)) {
            set->unknown_frames++;
        } else if (stream < ML2S_STREAM_COUNT && set->streams & ML2S_STREAM_BIT(stream)) {
            ml2s_frame *frame = frameset_add(set, stream, error);
            if (frame) {
                frameset_complete(set, frame, camera->copy(settings, from, frame, error));
            }
        }
    }
}

/** Returns a stream without a frame, or else the first stream. */
static uint32_t stream_of_unknown(const struct frameset *set) {
    uint64_t missing = set->streams;
    for (uint32_t i = 0; i < set->count; i++) {
        missing &= ~ML2S_STREAM_BIT(set->frames[i].stream);
    }
    return (uint32_t)__builtin_ctzll(missing ? missing : set->streams);
}

bool frameset_finish(struct frameset *set) {
    for (; set->unknown_frames; set->unknown_frames--) {
        skip(set, stream_of_unknown(set));
    }
    bool any = false;
    for (uint32_t i = 0; i < set->count; i++) {
        ml2s_frame *frame = &set->frames[i];
        any |= is_usable(frame);
        frame->capture_nanos = is_usable(frame) ? frame->capture_nanos : ml2s_now();
    }
    return any;
}

static bool is_size(const struct size *size, uint32_t width, uint32_t height) {
    return size->width == width && size->height == height;
}

ml2s_result frameset_check_size(uint32_t stream, uint32_t width, uint32_t height, const char *name, ml2s_error *error) {
    bool is_known =
        !usual[stream].width || is_size(&usual[stream], width, height) || is_size(&last[stream], width, height);
    last[stream] = (struct size){width, height};
    if (is_known) {
        usual[stream] = last[stream];
        return ML2S_OK;
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: a frame has %ux%u pixels, those before have %ux%u", name,
                     width, height, usual[stream].width, usual[stream].height);
}

void frameset_forget_sizes(uint64_t streams) {
    for (uint32_t stream = 0; stream < ML2S_STREAM_COUNT; stream++) {
        if (streams & ML2S_STREAM_BIT(stream)) {
            usual[stream] = last[stream] = (struct size){0, 0};
        }
    }
}
