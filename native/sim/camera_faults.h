// Faults in the structures that a camera hands to its caller, equal for all cameras.
#pragma once

#include <cmath>
#include <limits>

#include "settings.h"

namespace ml2sim {

/** Replaces the value of field while the fault is on. */
template <typename T> void replaceByFault(CameraKind kind, Fault what, T &field) {
    const double value = fault(kind, what);
    if (value >= 0)
        field = static_cast<T>(value);
}

/** bytesPerPixel is a field of the buffer; its name differs between the vendor's cameras. */
template <typename Buffer> void corruptBuffer(CameraKind kind, Buffer &buffer, uint32_t &bytesPerPixel) {
    replaceByFault(kind, Fault::Size, buffer.size);
    replaceByFault(kind, Fault::Stride, buffer.stride);
    replaceByFault(kind, Fault::Width, buffer.width);
    replaceByFault(kind, Fault::BytesPerPixel, bytesPerPixel);
    if (hasFault(kind, Fault::NullData))
        buffer.data = nullptr;
}

/** Puts NaN and infinity into the pose and the focal length. */
template <typename Frame> void corruptPose(CameraKind kind, Frame &frame) {
    if (!hasFault(kind, Fault::NotFinite))
        return;
    frame.camera_pose.rotation.w = std::numeric_limits<float>::quiet_NaN();
    frame.camera_pose.position.x = std::numeric_limits<float>::infinity();
    frame.intrinsics.focal_length.x = std::numeric_limits<float>::quiet_NaN();
}

/** An identifier that no camera has. */
constexpr uint32_t kNoId = 0x40;

inline uint32_t corruptId(CameraKind kind, uint32_t id) { return hasFault(kind, Fault::Id) ? kNoId : id; }

/** The ways in which one frame of a capture can differ from what the vendor describes. */
enum class OddFrame { UnknownId, Empty, Duplicate, Size, Nothing };

/** Returns the fault of frame number `frame` of the `count` frames in a capture. */
inline OddFrame oddFrameAt(CameraKind kind, int64_t capture, size_t frame, size_t count) {
    const auto every = static_cast<int64_t>(fault(kind, Fault::OddEvery));
    if (every == 0 || capture % every != 0)
        return OddFrame::Nothing;
    const auto turn = static_cast<size_t>(capture / every);
    return turn / 4 % count == frame ? static_cast<OddFrame>(turn % 4) : OddFrame::Nothing;
}

template <typename Buffer> void applyOddFrame(OddFrame odd, Buffer &buffer) {
    if (odd == OddFrame::Empty) {
        buffer.width = buffer.height = buffer.size = 0;
        buffer.data = nullptr;
    } else if (odd == OddFrame::Size) {
        buffer.height /= 2;
    }
}

/** Corrupts the structure that lists the frames of a capture. */
template <typename Data> void corruptData(CameraKind kind, Data &data) {
    replaceByFault(kind, Fault::FrameCount, data.frame_count);
    if (hasFault(kind, Fault::NullFrames))
        data.frames = nullptr;
    if (hasFault(kind, Fault::Version))
        data.version += 7;
}

} // namespace ml2sim
