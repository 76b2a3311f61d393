/** Sizes and offsets in bytes of the structures that Kotlin reads from direct buffers. */
#pragma once

#include <jni.h>

/** Makes a Java array of values. */
jintArray layout_ints(JNIEnv *env, const jint *values, jsize count);

/** Returns the size of ml2s_frame and its offsets, in the order in which FrameBlock.kt reads them. */
jintArray layout_frame(JNIEnv *env, jobject);

/** Returns the size of ml2s_reading and its offsets, in the order in which ReadingBlock.kt reads them. */
jintArray layout_reading(JNIEnv *env, jobject);

/** Returns the size of ml2s_settings and its offsets, in the order in which NativeSettings.kt reads them. */
jintArray layout_settings(JNIEnv *env, jobject);
