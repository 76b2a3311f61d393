/**
 * The frames of one poll. A frame that is not as expected is odd: it is skipped and counted, and the others go on. An
 * odd frame is one that cannot be read, has no time, repeats a stream, names no stream or has a size of its own.
 */
#pragma once

#include <stdbool.h>

#include "frame.h"

struct frameset {
    ml2s_frame *frames; /**< Room for SOURCE_MAX_FRAMES. */
    uint32_t count;
    uint64_t streams;        /**< ML2S_STREAM_BITs that were asked for, at most SOURCE_MAX_FRAMES. */
    uint32_t unknown_frames; /**< Odd frames that name none of them. */
};

/** Returns where to write the frame of stream. Null if the batch has one: the second is a duplicate, and is skipped. */
ml2s_frame *frameset_add(struct frameset *set, uint32_t stream, ml2s_error *error);

/** Keeps the frame that frameset_add returned last, which is complete, or skips it if result is a failure. */
void frameset_complete(struct frameset *set, ml2s_frame *frame, ml2s_result result);

/** Skips a frame that names no stream. */
void frameset_skip_unknown(struct frameset *set);

/** Skips one frame of every stream: nothing can be said of what came. */
void frameset_skip_all(struct frameset *set);

/** Counts the unknown_frames against streams, first those that got no frame. Returns true if any frame is usable. */
bool frameset_finish(struct frameset *set);

/**
 * ML2S_VENDOR_FAILURE if the frame is alone with its size: the size of a stream is that of its frames so far, and a new
 * one counts from its second frame in a row. For streams whose size nobody configures; of the stream's own thread.
 */
ml2s_result frameset_check_size(uint32_t stream, uint32_t width, uint32_t height, const char *name, ml2s_error *error);

/** Forgets the sizes of streams, for sensors that begin anew. */
void frameset_forget_sizes(uint64_t streams);
