/** What the kernel holds of a TCP connection; the functions of dev.ml2sensors.transport.SendQueue. */
#pragma once

#include <jni.h>

/** Registers them; returns JNI_OK, or an error with an exception pending. */
jint send_queue_register(JNIEnv *env);
