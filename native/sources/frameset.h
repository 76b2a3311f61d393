/**
 * The frames of one capture, at most one per stream. An odd frame is skipped and counted; the other frames are kept. A
 * frame is odd if it cannot be read, has no time, repeats a stream, belongs to no stream, or differs in size.
 */
#pragma once

#include <stdbool.h>

#include "frame.h"

struct frameset {
    ml2s_frame *frames; /**< SOURCE_MAX_FRAMES elements. */
    uint32_t count;
    uint64_t streams;        /**< ML2S_STREAM_BITs of the requested streams, at most SOURCE_MAX_FRAMES. */
    uint32_t unknown_frames; /**< Odd frames that belong to none of these streams. */
};

/** Returns the frame to fill for stream. If the set has one already, skips the duplicate and returns null. */
ml2s_frame *frameset_add(struct frameset *set, uint32_t stream, ml2s_error *error);

/** Completes the frame of the last frameset_add, or skips it if result is a failure. */
void frameset_complete(struct frameset *set, ml2s_frame *frame, ml2s_result result);

/** The frames of one of the vendor's cameras, which are structures of frame_bytes. */
struct camera {
    const char *name;       /**< Begins error messages. */
    const char *frame_name; /**< That of the structure. */
    uint32_t most_frames;
    uint32_t frame_bytes;
    /** Finds the stream of a frame; ML2S_STREAM_COUNT if settings want another exposure or range. */
    ml2s_result (*find_stream)(const ml2s_settings *settings, const void *from, uint32_t *stream, ml2s_error *error);
    /** Fills the frame of a stream. */
    ml2s_result (*copy)(const ml2s_settings *settings, const void *from, ml2s_frame *frame, ml2s_error *error);
    bool is_shown; /**< The first frame was dumped. */
};

/** Adds the frames of a capture. Ignores those of streams that are not requested, which can follow a change. */
void frameset_copy(struct frameset *set, struct camera *camera, const ml2s_settings *settings, const void *frames,
                   uint32_t count, ml2s_error *error);

/** Assigns unknown frames to streams, first to those without a frame. Returns true if a frame is usable. */
bool frameset_finish(struct frameset *set);

/**
 * Returns ML2S_VENDOR_FAILURE if the size differs from that of the previous frames. A new size is accepted from its
 * second frame in a row. For streams without a configured size. Called by the thread of the stream only.
 */
ml2s_result frameset_check_size(uint32_t stream, uint32_t width, uint32_t height, const char *name, ml2s_error *error);

/** Clears the known sizes of streams. Called when a sensor is opened. */
void frameset_forget_sizes(uint64_t streams);
