/** Arrays for Kotlin: of any numbers, and of sizes and offsets in bytes of the structures it reads from shared memory.
 */
#pragma once

#include <jni.h>

jintArray layout_ints(JNIEnv *env, const jint *values, jsize count);

/** Of ml2s_frame, in the order that FrameBlock.kt reads. */
jintArray layout_frame(JNIEnv *env, jclass class);

/** Of ml2s_pose, in the order that PoseBlock.kt reads. */
jintArray layout_pose(JNIEnv *env, jclass class);
