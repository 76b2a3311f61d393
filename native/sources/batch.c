#include "batch.h"

#include <string.h>

#include "../sdk/error.h"
#include "source.h"

static struct size { uint32_t width, height; } usual[ML2S_STREAM_COUNT], last[ML2S_STREAM_COUNT];

static ml2s_frame *entry_of(struct batch *batch, uint32_t stream) {
    for (uint32_t i = 0; i < batch->count; i++) {
        if (batch->frames[i].stream == stream) {
            return &batch->frames[i];
        }
    }
    ml2s_frame *frame = &batch->frames[batch->count++];
    frame->skipped = 0;
    frame_begin(frame, stream, 0, 0);
    return frame;
}

static bool is_usable(const ml2s_frame *frame) { return frame->width; }

static void skip(struct batch *batch, uint32_t stream) { entry_of(batch, stream)->skipped++; }

ml2s_frame *batch_begin(struct batch *batch, uint32_t stream, ml2s_error *error) {
    ml2s_frame *frame = entry_of(batch, stream);
    if (!is_usable(frame)) {
        return frame;
    }
    error_set(error, ML2S_VENDOR_FAILURE, 0, "stream %u: two frames at once", stream);
    skip(batch, stream);
    return NULL;
}

void batch_end(struct batch *batch, ml2s_frame *frame, ml2s_result result) {
    if (result) {
        frame_begin(frame, frame->stream, 0, 0);
        skip(batch, frame->stream);
    }
}

void batch_skip(struct batch *batch) { batch->strays++; }

void batch_skip_all(struct batch *batch) {
    for (uint32_t stream = 0; stream < ML2S_STREAM_COUNT; stream++) {
        if (batch->streams & ML2S_STREAM_BIT(stream)) {
            skip(batch, stream);
        }
    }
}

/** A stream that has no frame yet, else the first. */
static uint32_t stream_of_stray(const struct batch *batch) {
    uint64_t missing = batch->streams;
    for (uint32_t i = 0; i < batch->count; i++) {
        missing &= ~ML2S_STREAM_BIT(batch->frames[i].stream);
    }
    return (uint32_t)__builtin_ctzll(missing ? missing : batch->streams);
}

bool batch_finish(struct batch *batch) {
    for (; batch->strays; batch->strays--) {
        skip(batch, stream_of_stray(batch));
    }
    bool any = false;
    for (uint32_t i = 0; i < batch->count; i++) {
        ml2s_frame *frame = &batch->frames[i];
        any |= is_usable(frame);
        frame->capture_nanos = is_usable(frame) ? frame->capture_nanos : ml2s_now();
    }
    return any;
}

static bool is_size(const struct size *size, uint32_t width, uint32_t height) {
    return size->width == width && size->height == height;
}

ml2s_result batch_check_size(uint32_t stream, uint32_t width, uint32_t height, const char *name, ml2s_error *error) {
    bool is_known =
        !usual[stream].width || is_size(&usual[stream], width, height) || is_size(&last[stream], width, height);
    last[stream] = (struct size){width, height};
    if (is_known) {
        usual[stream] = last[stream];
        return ML2S_OK;
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: a frame of %ux%u pixels among frames of %ux%u", name, width,
                     height, usual[stream].width, usual[stream].height);
}

void batch_forget_sizes(uint64_t streams) {
    for (uint32_t stream = 0; stream < ML2S_STREAM_COUNT; stream++) {
        if (streams & ML2S_STREAM_BIT(stream)) {
            usual[stream] = last[stream] = (struct size){0, 0};
        }
    }
}
