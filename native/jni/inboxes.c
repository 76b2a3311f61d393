#include "inboxes.h"

#include <stddef.h>
#include <stdint.h>

#include "../sdk/ml2s.h"
#include "failure.h"

jint inboxes_open(JNIEnv *env, jobject, jint depth) {
    uint32_t inbox = 0;
    failure_throw(env, ml2s_inbox_open((uint32_t)depth, &inbox), NULL);
    return (jint)inbox;
}

jboolean inboxes_add(JNIEnv *env, jobject, jint inbox, jbyteArray bytes, jint offset, jint size_bytes,
                     jlong published_nanos, jint number) {
    ml2s_message message = {.struct_size = sizeof message,
                            .size_bytes = (uint64_t)size_bytes,
                            .published_nanos = published_nanos,
                            .number = (uint32_t)number};
    ml2s_memory memory;
    ml2s_result result = ml2s_inbox_take((uint32_t)inbox, message.size_bytes, &message.slot, &memory);
    if (result == ML2S_INVALID_ARGUMENT) {
        failure_throw(env, result, NULL);
    }
    if (result) {
        return JNI_FALSE;
    }
    (*env)->GetByteArrayRegion(env, bytes, offset, size_bytes, (jbyte *)memory.data);
    if ((*env)->ExceptionCheck(env)) {
        ml2s_inbox_release((uint32_t)inbox, message.slot);
        return JNI_FALSE;
    }
    return !ml2s_inbox_add((uint32_t)inbox, &message);
}

jobject inboxes_await(JNIEnv *env, jobject, jint inbox, jlongArray about) {
    ml2s_message message = {.struct_size = sizeof message};
    ml2s_result result;
    do {
        result = ml2s_inbox_wait((uint32_t)inbox);
        result = result ? result : ml2s_inbox_acquire((uint32_t)inbox, &message);
    } while (result == ML2S_TIMEOUT); // Another reader took it
    if (result) {
        return NULL;
    }
    jlong values[] = {message.slot, message.published_nanos, message.number, (jlong)message.left_out};
    (*env)->SetLongArrayRegion(env, about, 0, sizeof values / sizeof *values, values);
    jobject bytes =
        (*env)->ExceptionCheck(env) ? NULL : (*env)->NewDirectByteBuffer(env, message.data, (jlong)message.size_bytes);
    if (!bytes) {
        ml2s_inbox_release((uint32_t)inbox, message.slot);
    }
    return bytes;
}

void inboxes_release(JNIEnv *env, jobject, jint inbox, jint slot) {
    failure_throw(env, ml2s_inbox_release((uint32_t)inbox, (uint32_t)slot), NULL);
}

void inboxes_close(JNIEnv *env, jobject, jint inbox) { failure_throw(env, ml2s_inbox_close((uint32_t)inbox), NULL); }
