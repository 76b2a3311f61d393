/** The native methods of dev.ml2sensors.transport.SendQueue: how many bytes the kernel still has to deliver, and sends later. */
#pragma once

#include <jni.h>

/** Registers these methods; returns JNI_OK, or an error with an exception pending. */
jint send_queue_register(JNIEnv *env);
