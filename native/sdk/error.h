/** Error messages, formatted without stdio. */
#pragma once

#include <stdbool.h>

#include "ml2s.h"

/** Returns true if error can be written, or is null, which discards the message. */
static inline bool error_is_valid(const ml2s_error *error) { return !error || error->struct_size >= sizeof *error; }

/**
 * Writes message, truncated to fit, and vendor_code if error is not null. Returns result. Formats: %s %d %u %x %lld.
 */
__attribute__((format(printf, 4, 5))) ml2s_result error_set(ml2s_error *error, ml2s_result result, int32_t vendor_code,
                                                            const char *format, ...);
