/** Conversion of results to Java exceptions. */
#pragma once

#include <jni.h>
#include <stdbool.h>

#include "../sdk/ml2s.h"

/**
 * Throws the exception for a failure and returns true; returns false for success and timeout. Device failures throw
 * CaptureException, caller errors IllegalStateException or IllegalArgumentException. error may be null.
 */
bool failure_throw(JNIEnv *env, ml2s_result result, const ml2s_error *error);
