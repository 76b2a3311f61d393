#include "error.h"

#include <stdarg.h>
#include <string.h>

static void append(ml2s_error *error, uint32_t *length, char character) {
    if (*length + 1 < sizeof error->message) {
        error->message[(*length)++] = character;
    }
}

static void append_text(ml2s_error *error, uint32_t *length, const char *text) {
    while (*text) {
        append(error, length, *text++);
    }
}

static void append_number(ml2s_error *error, uint32_t *length, uint64_t magnitude, bool is_negative, uint32_t base) {
    char digits[24];
    uint32_t count = 0;
    do {
        digits[count++] = "0123456789abcdef"[magnitude % base];
        magnitude /= base;
    } while (magnitude);
    if (is_negative) {
        append(error, length, '-');
    }
    while (count) {
        append(error, length, digits[--count]);
    }
}

static void append_signed(ml2s_error *error, uint32_t *length, int64_t value) {
    append_number(error, length, value < 0 ? 0 - (uint64_t)value : (uint64_t)value, value < 0, 10);
}

ml2s_result error_set(ml2s_error *error, ml2s_result result, int32_t vendor_code, const char *format, ...) {
    if (!error) {
        return result;
    }
    va_list values;
    va_start(values, format);
    uint32_t length = 0;
    for (const char *at = format; *at; at++) {
        if (*at != '%') {
            append(error, &length, *at);
        } else if (*++at == 's') {
            append_text(error, &length, va_arg(values, const char *));
        } else if (*at == 'd') {
            append_signed(error, &length, va_arg(values, int));
        } else if (*at == 'u' || *at == 'x') {
            append_number(error, &length, va_arg(values, unsigned), false, *at == 'x' ? 16 : 10);
        } else {
            append_signed(error, &length, va_arg(values, long long));
            at += 2;
        }
    }
    va_end(values);
    error->message[length] = 0;
    error->vendor_code = vendor_code;
    return result;
}
