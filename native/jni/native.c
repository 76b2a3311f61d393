// The functions of dev.ml2sensors.capture.Native, registered by JNI_OnLoad.
#include <android/log.h>
#include <jni.h>
#include <stddef.h>

#include "../sdk/error.h"
#include "../sdk/memory.h"
#include "../sources/slots.h"
#include "failure.h"
#include "inboxes.h"
#include "layout.h"
#include "send_queue.h"

#define CLASS_NAME "dev/ml2sensors/capture/Native"
#define ERROR(name) ml2s_error name = {.struct_size = sizeof name}

static jlong now(JNIEnv *, jobject) { return ml2s_now(); }

static jlong boottime_of(JNIEnv *env, jobject, jlong device_nanos) {
    ERROR(error);
    int64_t nanos = 0;
    failure_throw(env, ml2s_boottime_of(device_nanos, &nanos, &error), &error);
    return nanos;
}

static void check(JNIEnv *env, jobject, jint sensor, jint backend) {
    ERROR(error);
    failure_throw(env, ml2s_check((uint32_t)sensor, (uint32_t)backend, &error), &error);
}

/** Returns how many structures of size bytes a direct buffer holds, and sets struct_size of the first. */
static uint32_t structures_in(JNIEnv *env, jobject buffer, uint32_t size, void **memory) {
    *memory = (*env)->GetDirectBufferAddress(env, buffer);
    uint32_t count = *memory ? (uint32_t)((*env)->GetDirectBufferCapacity(env, buffer) / size) : 0;
    if (count) {
        *(uint32_t *)*memory = size;
    }
    return count;
}

/** The ml2s_settings in a direct buffer; null when it has no room for one. */
static const ml2s_settings *settings_in(JNIEnv *env, jobject buffer) {
    void *memory;
    return structures_in(env, buffer, sizeof(ml2s_settings), &memory) ? memory : NULL;
}

static jlong open(JNIEnv *env, jobject, jobject settings) {
    ERROR(error);
    ml2s_handle handle = 0;
    failure_throw(env, ml2s_open(settings_in(env, settings), &handle, &error), &error);
    return (jlong)handle;
}

static void configure(JNIEnv *env, jobject, jlong handle, jobject settings) {
    ERROR(error);
    failure_throw(env, ml2s_configure((ml2s_handle)handle, settings_in(env, settings), &error), &error);
}

static jint poll(JNIEnv *env, jobject, jlong handle, jlong timeout_nanos, jobject frames) {
    ERROR(error);
    void *memory;
    uint32_t capacity = structures_in(env, frames, sizeof(ml2s_frame), &memory);
    uint32_t count = 0;
    ml2s_result result = ml2s_poll((ml2s_handle)handle, (uint64_t)timeout_nanos, memory, capacity, &count, &error);
    return failure_throw(env, result, &error) ? 0 : (jint)count;
}

static jint poll_readings(JNIEnv *env, jobject, jlong handle, jobject readings) {
    ERROR(error);
    void *memory;
    uint32_t capacity = structures_in(env, readings, sizeof(ml2s_reading), &memory);
    uint32_t count = 0;
    ml2s_result result = ml2s_poll_readings((ml2s_handle)handle, memory, capacity, &count, &error);
    return failure_throw(env, result, &error) ? 0 : (jint)count;
}

static jboolean color_pose(JNIEnv *env, jobject, jlong handle, jlong device_nanos, jobject pose) {
    ERROR(error);
    void *memory;
    ml2s_result result = structures_in(env, pose, sizeof(ml2s_reading), &memory)
                             ? ml2s_color_pose((ml2s_handle)handle, device_nanos, memory, &error)
                             : ML2S_INVALID_ARGUMENT;
    return result != ML2S_NO_POSE && !failure_throw(env, result, &error);
}

static jintArray list_rates(JNIEnv *env, jobject, jlong handle) {
    ERROR(error);
    uint32_t rates[16];
    uint32_t count = 0;
    ml2s_result result = ml2s_list_rates((ml2s_handle)handle, rates, sizeof rates / sizeof *rates, &count, &error);
    return failure_throw(env, result, &error) ? NULL : layout_ints(env, (const jint *)rates, (jsize)count);
}

static void close(JNIEnv *env, jobject, jlong handle) {
    ERROR(error);
    ml2s_result result = ml2s_close((ml2s_handle)handle, &error);
    if (result == ML2S_CLOSED || result == ML2S_WRONG_THREAD) {
        failure_throw(env, result, &error);
    } else if (result) {
        __android_log_print(ANDROID_LOG_WARN, "ml2s", "closed with a failure: %s", error.message);
    }
}

static void reserve(JNIEnv *env, jobject, jint stream) { failure_throw(env, ml2s_reserve((uint32_t)stream), NULL); }

static void retire(JNIEnv *env, jobject, jint stream) { failure_throw(env, ml2s_retire((uint32_t)stream), NULL); }

static jint take(JNIEnv *env, jobject, jint stream, jint size_bytes) {
    uint32_t slot;
    ml2s_memory memory;
    ml2s_result result = ml2s_take((uint32_t)stream, (uint64_t)size_bytes, &slot, &memory);
    return result == ML2S_ALL_SLOTS_LEASED || failure_throw(env, result, NULL) ? -1 : (jint)slot;
}

static jobject bytes(JNIEnv *env, jobject, jint stream, jint slot, jint offset, jint size_bytes) {
    ml2s_memory memory = slots_memory((uint32_t)stream, (uint32_t)slot);
    bool is_inside = offset >= 0 && size_bytes > 0 && (uint64_t)offset + (uint64_t)size_bytes <= memory.size_bytes;
    if (!is_inside) {
        failure_throw(env, ML2S_INVALID_ARGUMENT, NULL);
        return NULL;
    }
    return (*env)->NewDirectByteBuffer(env, memory.data + offset, size_bytes);
}

static jlong mapped_bytes(JNIEnv *, jobject) { return (jlong)memory_mapped_bytes(); }

static void publish(JNIEnv *env, jobject, jobject frames, jint index) {
    void *memory;
    uint32_t count = structures_in(env, frames, sizeof(ml2s_frame), &memory);
    ml2s_frame *frame = (uint32_t)index < count ? (ml2s_frame *)memory + index : NULL;
    if (frame) {
        frame->struct_size = sizeof *frame;
    }
    failure_throw(env, ml2s_publish(frame), NULL);
}

static void unpublish(JNIEnv *env, jobject, jint stream) { failure_throw(env, ml2s_unpublish((uint32_t)stream), NULL); }

static void release(JNIEnv *env, jobject, jint stream, jint slot) {
    failure_throw(env, ml2s_release((uint32_t)stream, (uint32_t)slot), NULL);
}

static jint most_encoded_bytes(JNIEnv *env, jobject, jint codec, jint width, jint height) {
    ERROR(error);
    ml2s_image image = {
        .struct_size = sizeof image, .codec = (uint32_t)codec, .width = (uint32_t)width, .height = (uint32_t)height};
    uint64_t size_bytes = 0;
    ml2s_result result = ml2s_most_encoded_bytes(&image, &size_bytes, &error);
    if (!result && size_bytes > INT32_MAX) {
        result = error_set(&error, ML2S_INVALID_ARGUMENT, 0, "%d x %d pixels need more than 2 GiB", width, height);
    }
    return failure_throw(env, result, &error) ? 0 : (jint)size_bytes;
}

static jint encode(JNIEnv *env, jobject, jobject pixels, jint codec, jint quality, jint width, jint height,
                   jint stride_bytes, jint stream, jint slot) {
    ERROR(error);
    ml2s_image image = {.struct_size = sizeof image,
                        .codec = (uint32_t)codec,
                        .quality = (uint32_t)quality,
                        .width = (uint32_t)width,
                        .height = (uint32_t)height,
                        .stride_bytes = (uint32_t)stride_bytes,
                        .data = (*env)->GetDirectBufferAddress(env, pixels)};
    uint64_t size_bytes = 0;
    ml2s_result result;
    if (image.data) {
        image.size_bytes = (uint64_t)(*env)->GetDirectBufferCapacity(env, pixels);
        result = ml2s_encode(&image, slots_memory((uint32_t)stream, (uint32_t)slot), &size_bytes, &error);
    } else {
        result = error_set(&error, ML2S_INVALID_ARGUMENT, 0, "the image is not in a direct buffer");
    }
    return failure_throw(env, result, &error) ? 0 : (jint)size_bytes;
}

/** Keeps a global reference to context for the life of the process. */
static void use_openxr(JNIEnv *env, jobject, jstring loader_path, jobject context) {
    char path[512];
    ERROR(error);
    ml2s_openxr openxr = {.struct_size = sizeof openxr, .loader_path = path};
    jsize length = (*env)->GetStringUTFLength(env, loader_path);
    if (length >= (jsize)sizeof path) {
        failure_throw(env, ML2S_INVALID_ARGUMENT, NULL);
        return;
    }
    (*env)->GetStringUTFRegion(env, loader_path, 0, (*env)->GetStringLength(env, loader_path), path);
    path[length] = 0; // Android's GetStringUTFRegion does not terminate it.
    if (context) {
        JavaVM *vm = NULL;
        (*env)->GetJavaVM(env, &vm);
        openxr.java_vm = vm;
        openxr.activity = (*env)->NewGlobalRef(env, context);
    }
    failure_throw(env, ml2s_use_openxr(&openxr, &error), &error);
}

#define METHOD(name, signature, function)                                                                              \
    { (char *)(name), (char *)(signature), (void *)(function) }

JNIEXPORT jint JNI_OnLoad(JavaVM *vm, void *) {
    static const JNINativeMethod methods[] = {
        METHOD("now", "()J", now),
        METHOD("boottimeOf", "(J)J", boottime_of),
        METHOD("frameLayout", "()[I", layout_frame),
        METHOD("readingLayout", "()[I", layout_reading),
        METHOD("settingsLayout", "()[I", layout_settings),
        METHOD("check", "(II)V", check),
        METHOD("open", "(Ljava/nio/ByteBuffer;)J", open),
        METHOD("configure", "(JLjava/nio/ByteBuffer;)V", configure),
        METHOD("poll", "(JJLjava/nio/ByteBuffer;)I", poll),
        METHOD("pollReadings", "(JLjava/nio/ByteBuffer;)I", poll_readings),
        METHOD("colorPose", "(JJLjava/nio/ByteBuffer;)Z", color_pose),
        METHOD("listRates", "(J)[I", list_rates),
        METHOD("close", "(J)V", close),
        METHOD("reserve", "(I)V", reserve),
        METHOD("retire", "(I)V", retire),
        METHOD("take", "(II)I", take),
        METHOD("bytes", "(IIII)Ljava/nio/ByteBuffer;", bytes),
        METHOD("mappedBytes", "()J", mapped_bytes),
        METHOD("publish", "(Ljava/nio/ByteBuffer;I)V", publish),
        METHOD("unpublish", "(I)V", unpublish),
        METHOD("release", "(II)V", release),
        METHOD("openInbox", "(I)I", inboxes_open),
        METHOD("addMessage", "(I[BIIJI)Z", inboxes_add),
        METHOD("awaitMessage", "(I[J)Ljava/nio/ByteBuffer;", inboxes_await),
        METHOD("releaseMessage", "(II)V", inboxes_release),
        METHOD("closeInbox", "(I)V", inboxes_close),
        METHOD("mostEncodedBytes", "(III)I", most_encoded_bytes),
        METHOD("encode", "(Ljava/nio/ByteBuffer;IIIIIII)I", encode),
        METHOD("useOpenXr", "(Ljava/lang/String;Ljava/lang/Object;)V", use_openxr),
    };
    JNIEnv *env;
    if ((*vm)->GetEnv(vm, (void **)&env, JNI_VERSION_1_6) != JNI_OK) {
        return JNI_ERR;
    }
    jclass class = (*env)->FindClass(env, CLASS_NAME);
    if (!class || (*env)->RegisterNatives(env, class, methods, sizeof methods / sizeof *methods) != JNI_OK) {
        return JNI_ERR;
    }
    return send_queue_register(env) == JNI_OK ? JNI_VERSION_1_6 : JNI_ERR;
}
