/** Error messages, formatted without stdio. */
#pragma once

#include "ml2s.h"

/**
 * Writes message, truncated to fit, and vendor_code if error is not null. Returns result. Formats: %s %d %u %x %lld.
 */
__attribute__((format(printf, 4, 5))) ml2s_result error_set(ml2s_error *error, ml2s_result result, int32_t vendor_code,
                                                            const char *format, ...);
