// liblog.so for Linux: prints what Android would log.
#include <stdarg.h>
#include <stdio.h>

int __android_log_print(int priority, const char *tag, const char *format, ...) {
    va_list values;
    va_start(values, format);
    flockfile(stderr);
    fprintf(stderr, "%d/%s: ", priority, tag);
    int written = vfprintf(stderr, format, values);
    fputc('\n', stderr);
    funlockfile(stderr);
    va_end(values);
    return written;
}
