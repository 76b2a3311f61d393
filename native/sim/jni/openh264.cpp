// Cisco's encoder for a JVM: dev.ml2sensors.simulator.simulated.OpenH264, registered by JNI_OnLoad.
#include <dlfcn.h>
#include <jni.h>
#include <wels/codec_api.h>

#include <cstring>
#include <memory>
#include <vector>

#include "registration.h"

namespace {

constexpr char kClass[] = "dev/ml2sensors/simulator/simulated/OpenH264";

/** Found when it is first needed, and not part of what ships. */
struct Library {
    decltype(&WelsCreateSVCEncoder) create = nullptr;
    decltype(&WelsDestroySVCEncoder) destroy = nullptr;

    Library() {
        if (void *library = dlopen(OPENH264_LIBRARY, RTLD_NOW | RTLD_LOCAL)) {
            create = reinterpret_cast<decltype(create)>(dlsym(library, "WelsCreateSVCEncoder"));
            destroy = reinterpret_cast<decltype(destroy)>(dlsym(library, "WelsDestroySVCEncoder"));
        }
    }
    bool isUsable() const { return create != nullptr && destroy != nullptr; }
};

const Library &library() {
    static const Library loaded;
    return loaded;
}

struct Release {
    void operator()(ISVCEncoder *encoder) const {
        encoder->Uninitialize();
        library().destroy(encoder);
    }
};

struct Encoder {
    std::unique_ptr<ISVCEncoder, Release> codec;
    int width, height;
    std::vector<uint8_t> u, v;
};

SEncParamExt parameters(ISVCEncoder &codec, int width, int height, int rate_hz, int bits_per_second) {
    SEncParamExt all;
    codec.GetDefaultParams(&all);
    all.iUsageType = CAMERA_VIDEO_REAL_TIME;
    all.iPicWidth = width;
    all.iPicHeight = height;
    all.fMaxFrameRate = static_cast<float>(rate_hz);
    all.iTargetBitrate = all.iMaxBitrate = bits_per_second;
    all.iRCMode = RC_BITRATE_MODE;
    all.bEnableFrameSkip = true;
    all.iComplexityMode = LOW_COMPLEXITY;
    all.uiIntraPeriod = 0;
    all.eSpsPpsIdStrategy = CONSTANT_ID;
    all.iMultipleThreadIdc = 1;
    all.bEnableSceneChangeDetect = false;
    all.iLoopFilterDisableIdc = 1; // which saves an eighth of the time
    SSpatialLayerConfig &layer = all.sSpatialLayers[0];
    layer.iVideoWidth = width;
    layer.iVideoHeight = height;
    layer.fFrameRate = all.fMaxFrameRate;
    layer.iSpatialBitrate = layer.iMaxSpatialBitrate = bits_per_second;
    layer.uiProfileIdc = PRO_BASELINE;
    layer.sSliceArgument.uiSliceMode = SM_SINGLE_SLICE;
    layer.bVideoSignalTypePresent = true;
    layer.uiVideoFormat = VF_UNDEF;
    layer.bFullRange = true;
    return all;
}

jstring refusal(JNIEnv *env, jclass) {
    if (library().isUsable())
        return nullptr;
    return env->NewStringUTF("this machine has no encoder for h264: install openh264, as " OPENH264_LIBRARY);
}

jlong open(JNIEnv *, jclass, jint width, jint height, jint rate_hz, jint bits_per_second) {
    ISVCEncoder *made = nullptr;
    if (!library().isUsable() || library().create(&made) != 0)
        return 0;
    int quiet = WELS_LOG_QUIET;
    made->SetOption(ENCODER_OPTION_TRACE_LEVEL, &quiet);
    const SEncParamExt all = parameters(*made, width, height, rate_hz, bits_per_second);
    if (made->InitializeExt(&all) != cmResultSuccess) {
        library().destroy(made);
        return 0;
    }
    const std::vector<uint8_t> plane(static_cast<size_t>((width + 1) / 2) * static_cast<size_t>((height + 1) / 2));
    return reinterpret_cast<jlong>(
        new Encoder{std::unique_ptr<ISVCEncoder, Release>(made), width, height, plane, plane});
}

/** Parts the pairs of V and U in rows of stride bytes. */
void part(Encoder &encoder, const uint8_t *pairs, size_t stride) {
    const size_t width = (static_cast<size_t>(encoder.width) + 1) / 2, height = encoder.u.size() / width;
    for (size_t row = 0; row < height; row++)
        for (size_t column = 0; column < width; column++) {
            encoder.v[row * width + column] = pairs[row * stride + 2 * column];
            encoder.u[row * width + column] = pairs[row * stride + 2 * column + 1];
        }
}

/** Copies the units of an access unit one after another; returns their size, or -1 if they do not fit. */
jint gather(const SFrameBSInfo &info, uint8_t *output, size_t capacity) {
    size_t size = 0;
    for (int i = 0; i < info.iLayerNum; i++) {
        const SLayerBSInfo &layer = info.sLayerInfo[i];
        size_t bytes = 0;
        for (int j = 0; j < layer.iNalCount; j++)
            bytes += static_cast<size_t>(layer.pNalLengthInByte[j]);
        if (bytes > capacity - size)
            return -1;
        std::memcpy(output + size, layer.pBsBuf, bytes);
        size += bytes;
    }
    return static_cast<jint>(size);
}

jint encode(JNIEnv *env, jclass, jlong handle, jobject luma, jobject chroma, jint stride, jlong micros,
            jboolean as_key_frame, jobject output) {
    auto &encoder = *reinterpret_cast<Encoder *>(handle);
    part(encoder, static_cast<uint8_t *>(env->GetDirectBufferAddress(chroma)), static_cast<size_t>(stride));
    SSourcePicture picture{};
    picture.iColorFormat = videoFormatI420;
    picture.iPicWidth = encoder.width;
    picture.iPicHeight = encoder.height;
    picture.iStride[0] = stride;
    picture.iStride[1] = picture.iStride[2] = (encoder.width + 1) / 2;
    picture.pData[0] = static_cast<uint8_t *>(env->GetDirectBufferAddress(luma));
    picture.pData[1] = encoder.u.data();
    picture.pData[2] = encoder.v.data();
    picture.uiTimeStamp = micros / 1000;
    if (as_key_frame && encoder.codec->ForceIntraFrame(true) != cmResultSuccess)
        return -1;
    SFrameBSInfo info{};
    if (encoder.codec->EncodeFrame(&picture, &info) != cmResultSuccess)
        return -1;
    if (info.eFrameType == videoFrameTypeSkip)
        return 0;
    return gather(info, static_cast<uint8_t *>(env->GetDirectBufferAddress(output)),
                  static_cast<size_t>(env->GetDirectBufferCapacity(output)));
}

void close(JNIEnv *, jclass, jlong handle) { delete reinterpret_cast<Encoder *>(handle); }

} // namespace

extern "C" JNIEXPORT jint JNI_OnLoad(JavaVM *vm, void *) {
    const JNINativeMethod methods[] = {
        method("refusal", "()Ljava/lang/String;", refusal),
        method("open", "(IIII)J", open),
        method("encode", "(JLjava/nio/ByteBuffer;Ljava/nio/ByteBuffer;IJZLjava/nio/ByteBuffer;)I", encode),
        method("close", "(J)V", close),
    };
    return registerNatives(vm, kClass, methods);
}
