// Replaces functions of a desktop's JVM that do what Android's JNI does not, in a function table of the test's own.
#include <jni.h>

#include <cstring>
#include <map>
#include <string>

#include "../sources/sensor.h"

extern "C" jint JNI_OnLoad(JavaVM *vm, void *reserved);

namespace {

std::map<std::string, void *> registered;
std::string thrown;

/** A string is a std::string of ASCII; what follows a copy of it is not a zero. */
const std::string &textOf(jstring text) { return *reinterpret_cast<const std::string *>(text); }
jsize lengthOf(JNIEnv *, jstring text) { return static_cast<jsize>(textOf(text).size()); }
void copyOf(JNIEnv *, jstring text, jsize start, jsize count, char *out) {
    std::memcpy(out, textOf(text).data() + start, static_cast<size_t>(count));
    out[count] = '!';
}

jclass findClass(JNIEnv *, const char *) { return reinterpret_cast<jclass>(&registered); }
jint throwNew(JNIEnv *, jclass, const char *message) {
    thrown = message;
    return JNI_OK;
}
jint registerNatives(JNIEnv *, jclass, const JNINativeMethod *methods, jint count) {
    for (jint i = 0; i < count; i++)
        registered[methods[i].name] = methods[i].fnPtr;
    return JNI_OK;
}

/** A process has one. */
JNIEnv *strictEnv() {
    static JNINativeInterface_ functions = {};
    functions.FindClass = findClass;
    functions.ThrowNew = throwNew;
    functions.RegisterNatives = registerNatives;
    functions.GetStringLength = lengthOf;
    functions.GetStringUTFLength = lengthOf;
    functions.GetStringUTFRegion = copyOf;
    static JNIEnv env = {&functions};
    return &env;
}

jint getEnv(JavaVM *, void **env, jint) {
    *env = strictEnv();
    return JNI_OK;
}

template <class Function> Function *method(const char *name) {
    static JNIInvokeInterface_ functions = {};
    functions.GetEnv = getEnv;
    JavaVM vm = {&functions};
    EXPECT_EQ(JNI_OnLoad(&vm, nullptr), JNI_VERSION_1_6);
    return reinterpret_cast<Function *>(registered.at(name));
}

} // namespace

TEST(StrictJni, ThePathOfTheLoaderEndsWhereTheStringEnds) {
    std::string path = "/no/such/loader.so";
    method<void(JNIEnv *, jobject, jstring, jobject)>("useOpenXr")(strictEnv(), nullptr,
                                                                   reinterpret_cast<jstring>(&path), nullptr);
    auto settings = settingsOf(ML2S_SENSOR_HEAD, ML2S_STREAM_BIT(ML2S_STREAM_HEAD_POSE));
    settings.backend = ML2S_BACKEND_OPENXR;
    const Sensor sensor(settings);
    EXPECT_EQ(thrown, "");
    EXPECT_EQ(sensor.result, ML2S_NOT_AVAILABLE);
    EXPECT_EQ(std::string(sensor.error.message).rfind("not available: /no/such/loader.so (", 0), 0u)
        << sensor.error.message;
}
