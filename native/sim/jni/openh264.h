// The functions of dev.ml2sensors.simulator.simulated.OpenH264.
#pragma once

#include <jni.h>

/** Registers them; returns false if that fails. */
bool registerOpenH264(JNIEnv *env);
