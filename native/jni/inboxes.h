/** The functions of dev.ml2sensors.capture.Native for inboxes. */
#pragma once

#include <jni.h>

jint inboxes_open(JNIEnv *env, jobject, jint depth);
jboolean inboxes_add(JNIEnv *env, jobject, jint inbox, jbyteArray bytes, jint offset, jint size_bytes,
                     jlong published_nanos, jint number);
jobject inboxes_await(JNIEnv *env, jobject, jint inbox, jlongArray about);
void inboxes_release(JNIEnv *env, jobject, jint inbox, jint slot);
void inboxes_close(JNIEnv *env, jobject, jint inbox);
