/** Sizes and offsets in bytes of the structures that Kotlin reads from shared memory. */
#pragma once

#include <jni.h>

/** Of ml2s_frame, in the order that FrameBlock.kt reads. */
jintArray layout_frame(JNIEnv *env, jclass class);

/** Of ml2s_pose, in the order that PoseBlock.kt reads. */
jintArray layout_pose(JNIEnv *env, jclass class);
