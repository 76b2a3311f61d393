#pragma once
// jni.h includes this file and uses nothing of it.
