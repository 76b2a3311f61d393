/** The functions of dev.ml2sensors.capture.Native for inboxes. */
#pragma once

#include <jni.h>

jint inboxes_open(JNIEnv *env, jclass class, jint depth);
jboolean inboxes_add(JNIEnv *env, jclass class, jint inbox, jbyteArray bytes, jint offset, jint size_bytes,
                     jlong published_nanos, jint number);
jobject inboxes_await(JNIEnv *env, jclass class, jint inbox, jlongArray about);
void inboxes_release(JNIEnv *env, jclass class, jint inbox, jint slot);
void inboxes_close(JNIEnv *env, jclass class, jint inbox);
