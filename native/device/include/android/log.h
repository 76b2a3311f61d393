#pragma once
enum { ANDROID_LOG_INFO = 4, ANDROID_LOG_WARN = 5, ANDROID_LOG_ERROR = 6 };
__attribute__((format(printf, 3, 4))) int __android_log_print(int priority, const char *tag, const char *format, ...);
