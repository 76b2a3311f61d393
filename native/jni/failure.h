/** What went wrong, as a Java exception. */
#pragma once

#include <jni.h>
#include <stdbool.h>

#include "../sdk/ml2s.h"

/**
 * Whether result is an error; then the exception that stands for it is pending: a CaptureException for failures of the
 * world, IllegalStateException or IllegalArgumentException for misuse. error may be null.
 */
bool failure_throw(JNIEnv *env, ml2s_result result, const ml2s_error *error);
