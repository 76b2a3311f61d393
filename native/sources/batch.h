/**
 * The frames of one poll. A frame that is not as expected is odd: it is skipped and counted, and the others go on. An
 * odd frame is one that cannot be read, has no time, repeats a stream, names no stream or has a size of its own.
 */
#pragma once

#include <stdbool.h>

#include "frame.h"

struct batch {
    ml2s_frame *frames; /**< Room for SOURCE_MAX_FRAMES. */
    uint32_t count;
    uint64_t streams; /**< ML2S_STREAM_BITs that were asked for, at most SOURCE_MAX_FRAMES. */
    uint32_t strays;  /**< Odd frames that name none of them. */
};

/** Returns where to write the frame of stream. Null if the batch has one: the second is a duplicate, and is skipped. */
ml2s_frame *batch_begin(struct batch *batch, uint32_t stream, ml2s_error *error);

/** Keeps the frame that batch_begin returned last, which is complete, or skips it if result is a failure. */
void batch_end(struct batch *batch, ml2s_frame *frame, ml2s_result result);

/** Skips a frame that names no stream. */
void batch_skip(struct batch *batch);

/** Skips one frame of every stream: nothing can be said of what came. */
void batch_skip_all(struct batch *batch);

/** Counts the strays against streams, first those that got no frame. Returns true if any frame is usable. */
bool batch_finish(struct batch *batch);

/**
 * ML2S_VENDOR_FAILURE if the frame is alone with its size: the size of a stream is that of its frames so far, and a new
 * one counts from its second frame in a row. For streams whose size nobody configures; of the stream's own thread.
 */
ml2s_result batch_check_size(uint32_t stream, uint32_t width, uint32_t height, const char *name, ml2s_error *error);

/** Forgets the sizes of streams, for sensors that begin anew. */
void batch_forget_sizes(uint64_t streams);
