// ml2sim.h for Kotlin: the functions of the test object dev.ml2sensors.capture.Simulation.
#include <dlfcn.h>
#include <jni.h>
#include <pthread.h>
#include <stddef.h>

#include "../../sdk/ml2s.h"
#include "ml2sim.h"

static jstring set(JNIEnv *env, jobject, jstring key, jstring value) {
    char texts[2][256];
    jstring strings[] = {key, value};
    for (int i = 0; i < 2; i++) {
        (*env)->GetStringUTFRegion(env, strings[i], 0, (*env)->GetStringLength(env, strings[i]), texts[i]);
        texts[i][(*env)->GetStringUTFLength(env, strings[i])] = 0;
    }
    const char *problem = ml2sim_set(texts[0], texts[1]);
    return problem ? (*env)->NewStringUTF(env, problem) : NULL;
}

static void reset(JNIEnv *, jobject) { ml2sim_reset(); }

static void advance(JNIEnv *, jobject, jlong nanos) { ml2sim_advance(nanos); }

static jint open_handles(JNIEnv *, jobject) {
    ml2sim_counters counters;
    ml2sim_get_counters(&counters);
    return (jint)(counters.open_handles + counters.outstanding_gets + counters.outstanding_snapshots);
}

static jstring last_misuse(JNIEnv *env, jobject) {
    ml2sim_counters counters;
    ml2sim_get_counters(&counters);
    return (*env)->NewStringUTF(env, counters.last_misuse);
}

static jlong mltime(JNIEnv *, jobject, jlong boottime_nanos) { return ml2sim_mltime_of_boottime(boottime_nanos); }

/** Rotation x, y, z, w and position of a camera, or of the head when there is no such camera. */
static jdoubleArray true_pose(JNIEnv *env, jobject, jint camera, jlong boottime_nanos) {
    ml2sim_pose pose;
    int64_t mltime = ml2sim_mltime_of_boottime(boottime_nanos);
    if (ml2sim_true_pose((uint32_t)camera, mltime, &pose)) {
        ml2sim_true_head(mltime, &pose);
    }
    jdoubleArray values = (*env)->NewDoubleArray(env, 7);
    if (values) {
        (*env)->SetDoubleArrayRegion(env, values, 0, 4, pose.rotation);
        (*env)->SetDoubleArrayRegion(env, values, 4, 3, pose.position);
    }
    return values;
}

/** Returns a function of the library that is loaded already, as P/Invoke finds it, by its name. */
static void *loaded(const char *name) {
    void *library = dlopen("libml2sensors.so", RTLD_NOW | RTLD_NOLOAD);
    return library ? dlsym(library, name) : NULL;
}

/** Returns the oldest message of an inbox, or null. */
static jbyteArray take_message(JNIEnv *env, jobject, jint inbox) {
    ml2s_result (*acquire)(uint32_t, ml2s_message *) = NULL;
    ml2s_result (*release)(uint32_t, uint32_t) = NULL;
    *(void **)&acquire = loaded("ml2s_inbox_acquire");
    *(void **)&release = loaded("ml2s_inbox_release");
    ml2s_message message = {.struct_size = sizeof message};
    if (!acquire || !release || acquire((uint32_t)inbox, &message) != ML2S_OK) {
        return NULL;
    }
    jbyteArray bytes = (*env)->NewByteArray(env, (jsize)message.size_bytes);
    if (bytes) {
        (*env)->SetByteArrayRegion(env, bytes, 0, (jsize)message.size_bytes, (const jbyte *)message.data);
    }
    release((uint32_t)inbox, message.slot);
    return bytes;
}

static jboolean acquire_latest(JNIEnv *env, jobject, jint stream, jlong after_nanos, jobject frame) {
    ml2s_result (*acquire)(uint32_t, int64_t, ml2s_frame *) = NULL;
    *(void **)&acquire = loaded("ml2s_acquire_latest");
    ml2s_frame *memory = (*env)->GetDirectBufferAddress(env, frame);
    memory->struct_size = sizeof *memory;
    return acquire && acquire((uint32_t)stream, after_nanos, memory) == ML2S_OK;
}

struct call {
    JavaVM *vm;
    jclass class;
    jstring argument;
    char name[64];
    jthrowable thrown;
};

static void *call_attached(void *context) {
    struct call *call = context;
    JNIEnv *env;
    if ((*call->vm)->AttachCurrentThread(call->vm, (void **)&env, NULL) != JNI_OK) {
        return NULL;
    }
    const char *signature = call->argument ? "(Ljava/lang/String;)V" : "()V";
    jmethodID method = (*env)->GetStaticMethodID(env, call->class, call->name, signature);
    if (method) {
        (*env)->CallStaticVoidMethod(env, call->class, method, call->argument);
    }
    jthrowable thrown = (*env)->ExceptionOccurred(env);
    (*env)->ExceptionClear(env);
    call->thrown = (*env)->NewGlobalRef(env, thrown);
    (*call->vm)->DetachCurrentThread(call->vm);
    return context;
}

/** Calls a static method from a thread that no class has begun, with a text or null; returns what it threw. */
static jthrowable call_natively(JNIEnv *env, jobject, jclass of, jstring name, jstring argument) {
    struct call call = {.class = (*env)->NewGlobalRef(env, of), .argument = (*env)->NewGlobalRef(env, argument)};
    (*env)->GetJavaVM(env, &call.vm);
    (*env)->GetStringUTFRegion(env, name, 0, (*env)->GetStringLength(env, name), call.name);
    pthread_t thread;
    void *done = NULL;
    if (pthread_create(&thread, NULL, call_attached, &call) || pthread_join(thread, &done) || !done) {
        (*env)->FatalError(env, "no native thread was attached");
    }
    (*env)->DeleteGlobalRef(env, call.class);
    (*env)->DeleteGlobalRef(env, call.argument);
    return call.thrown;
}

#define METHOD(name, signature, function)                                                                              \
    { (char *)(name), (char *)(signature), (void *)(function) }

JNIEXPORT jint JNI_OnLoad(JavaVM *vm, void *) {
    static const JNINativeMethod methods[] = {
        METHOD("set", "(Ljava/lang/String;Ljava/lang/String;)Ljava/lang/String;", set),
        METHOD("reset", "()V", reset),
        METHOD("advance", "(J)V", advance),
        METHOD("openHandles", "()I", open_handles),
        METHOD("lastMisuse", "()Ljava/lang/String;", last_misuse),
        METHOD("takeMessage", "(I)[B", take_message),
        METHOD("acquireLatest", "(IJLjava/nio/ByteBuffer;)Z", acquire_latest),
        METHOD("callNatively", "(Ljava/lang/Class;Ljava/lang/String;Ljava/lang/String;)Ljava/lang/Throwable;",
               call_natively),
        METHOD("mlTime", "(J)J", mltime),
        METHOD("truePose", "(IJ)[D", true_pose),
    };
    JNIEnv *env;
    if ((*vm)->GetEnv(vm, (void **)&env, JNI_VERSION_1_6) != JNI_OK) {
        return JNI_ERR;
    }
    jclass class = (*env)->FindClass(env, "dev/ml2sensors/capture/Simulation");
    if (!class || (*env)->RegisterNatives(env, class, methods, sizeof methods / sizeof *methods) != JNI_OK) {
        return JNI_ERR;
    }
    return JNI_VERSION_1_6;
}
