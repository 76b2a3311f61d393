/** The native methods of dev.ml2sensors.transport.SendQueue: what the kernel still has to deliver, and may hold. */
#pragma once

#include <jni.h>

/** Registers these methods; returns JNI_OK, or an error with an exception pending. */
jint send_queue_register(JNIEnv *env);
