// The functions of dev.ml2sensors.simulator.simulated.SimulatedSdk, registered by JNI_OnLoad.
#include <jni.h>

#include <cstdlib>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>

#include "ml2sim.h"
#include "openxr/ml2sim_xr.h"
#include "registration.h"

namespace {

/** The prefix of the names of the OpenXR runtime's keys. */
constexpr std::string_view kOpenXr = "openxr.";

constexpr char kClass[] = "dev/ml2sensors/simulator/simulated/SimulatedSdk";

/** The bytes of a Java string in modified UTF-8. */
class Utf {
  public:
    Utf(JNIEnv *env, jstring text) : env_(env), text_(text), bytes_(env->GetStringUTFChars(text, nullptr)) {}
    ~Utf() { env_->ReleaseStringUTFChars(text_, bytes_); }
    Utf(const Utf &) = delete;
    Utf &operator=(const Utf &) = delete;
    const char *bytes() const { return bytes_; }

  private:
    JNIEnv *env_;
    jstring text_;
    const char *bytes_;
};

jstring set(JNIEnv *env, jclass, jstring key, jstring value) {
    const Utf name(env, key), text(env, value);
    const bool isOpenXr = std::string_view(name.bytes()).substr(0, kOpenXr.size()) == kOpenXr;
    const char *problem =
        isOpenXr ? ml2sim_xr_set(name.bytes() + kOpenXr.size(), text.bytes()) : ml2sim_set(name.bytes(), text.bytes());
    return problem == nullptr ? nullptr : env->NewStringUTF(problem);
}

jstring describeKeys(JNIEnv *env, jclass) {
    std::string keys = ml2sim_describe_keys();
    std::istringstream lines(ml2sim_xr_describe_keys());
    for (std::string line; std::getline(lines, line);)
        keys.append(kOpenXr).append(line).append("\n");
    return env->NewStringUTF(keys.c_str());
}

void useRuntime(JNIEnv *env, jclass, jstring manifest) { setenv("XR_RUNTIME_JSON", Utf(env, manifest).bytes(), 1); }

void inertial(JNIEnv *env, jclass, jint unit, jlong boottime, jfloatArray out) {
    float values[9];
    if (ml2sim_imu(static_cast<uint32_t>(unit), boottime, values, values + 3, values + 6) == 0)
        env->SetFloatArrayRegion(out, 0, 9, values);
}

jfloat light(JNIEnv *, jclass, jlong boottime) { return ml2sim_light(boottime); }

jfloat pressure(JNIEnv *, jclass, jint unit, jlong boottime) {
    return ml2sim_pressure(static_cast<uint32_t>(unit), boottime);
}

jobject color(JNIEnv *env, jclass, jint width, jint height, jint rate_hz, jboolean with_hologram, jlong boottime,
              jlongArray numbers, jfloatArray intrinsics) {
    const ml2sim_color_request request = {static_cast<uint32_t>(width), static_cast<uint32_t>(height),
                                          static_cast<uint32_t>(rate_hz), with_hologram};
    ml2sim_color_frame frame;
    if (ml2sim_color(&request, boottime, &frame) != 0)
        return nullptr;
    const jlong values[] = {frame.frame_number, frame.capture_mltime, frame.exposure_nanos, frame.next_boottime};
    env->SetLongArrayRegion(numbers, 0, std::size(values), values);
    env->SetFloatArrayRegion(intrinsics, 0, std::size(frame.intrinsics), frame.intrinsics);
    return env->NewDirectByteBuffer(const_cast<uint8_t *>(frame.jpeg), frame.jpeg_bytes);
}

void colorPixels(JNIEnv *env, jclass, jobject jpeg, jobject nv21) {
    ml2sim_color_pixels(static_cast<uint8_t *>(env->GetDirectBufferAddress(jpeg)),
                        static_cast<uint32_t>(env->GetDirectBufferCapacity(jpeg)),
                        static_cast<uint8_t *>(env->GetDirectBufferAddress(nv21)));
}

} // namespace

extern "C" JNIEXPORT jint JNI_OnLoad(JavaVM *vm, void *) {
    const JNINativeMethod methods[] = {
        method("set", "(Ljava/lang/String;Ljava/lang/String;)Ljava/lang/String;", set),
        method("describeKeys", "()Ljava/lang/String;", describeKeys),
        method("useRuntime", "(Ljava/lang/String;)V", useRuntime),
        method("inertial", "(IJ[F)V", inertial),
        method("light", "(J)F", light),
        method("pressure", "(IJ)F", pressure),
        method("color", "(IIIZJ[J[F)Ljava/nio/ByteBuffer;", color),
        method("colorPixels", "(Ljava/nio/ByteBuffer;Ljava/nio/ByteBuffer;)V", colorPixels),
    };
    return registerNatives(vm, kClass, methods);
}
