// Registers native functions of a Kotlin object.
#pragma once

#include <jni.h>

#include <cstddef>

template <typename F> JNINativeMethod method(const char *name, const char *signature, F *function) {
    return {const_cast<char *>(name), const_cast<char *>(signature), reinterpret_cast<void *>(function)};
}

/** Registers the functions, and returns the result for JNI_OnLoad: JNI_ERR if the class does not declare them. */
template <size_t N> jint registerNatives(JavaVM *vm, const char *name, const JNINativeMethod (&methods)[N]) {
    JNIEnv *env;
    if (vm->GetEnv(reinterpret_cast<void **>(&env), JNI_VERSION_1_6) != JNI_OK)
        return JNI_ERR;
    const jclass type = env->FindClass(name);
    if (type == nullptr || env->RegisterNatives(type, methods, N) != JNI_OK)
        return JNI_ERR;
    return JNI_VERSION_1_6;
}
