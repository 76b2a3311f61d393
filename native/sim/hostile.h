// Faults that lie in the structures a caller gets, for the cameras alike.
#pragma once

#include <cmath>
#include <limits>

#include "settings.h"

namespace ml2sim {

template <typename T> void lie(CameraKind kind, Fault what, T &field) {
    const double value = fault(kind, what);
    if (value >= 0)
        field = static_cast<T>(value);
}

/** bytesPerPixel is the buffer's own field, which the vendor names differently. */
template <typename Buffer> void spoilBuffer(CameraKind kind, Buffer &buffer, uint32_t &bytesPerPixel) {
    lie(kind, Fault::Size, buffer.size);
    lie(kind, Fault::Stride, buffer.stride);
    lie(kind, Fault::Width, buffer.width);
    lie(kind, Fault::BytesPerPixel, bytesPerPixel);
    if (hasFault(kind, Fault::NullData))
        buffer.data = nullptr;
}

template <typename Frame> void spoilPose(CameraKind kind, Frame &frame) {
    if (!hasFault(kind, Fault::NotFinite))
        return;
    frame.camera_pose.rotation.w = std::numeric_limits<float>::quiet_NaN();
    frame.camera_pose.position.x = std::numeric_limits<float>::infinity();
    frame.intrinsics.focal_length.x = std::numeric_limits<float>::quiet_NaN();
}

/** Names no camera. */
constexpr uint32_t kNoId = 0x40;

inline uint32_t spoiltId(CameraKind kind, uint32_t id) { return hasFault(kind, Fault::Id) ? kNoId : id; }

/** What is odd about one frame of a capture. */
enum class Odd { UnknownId, Empty, Duplicate, Size, Nothing };

/** Of the frame that is number `frame` of `count` in the capture of an index. */
inline Odd oddOf(CameraKind kind, int64_t index, size_t frame, size_t count) {
    const auto every = static_cast<int64_t>(fault(kind, Fault::OddEvery));
    if (every == 0 || index % every != 0)
        return Odd::Nothing;
    const auto turn = static_cast<size_t>(index / every);
    return turn / 4 % count == frame ? static_cast<Odd>(turn % 4) : Odd::Nothing;
}

template <typename Buffer> void makeOdd(Odd odd, Buffer &buffer) {
    if (odd == Odd::Empty) {
        buffer.width = buffer.height = buffer.size = 0;
        buffer.data = nullptr;
    } else if (odd == Odd::Size) {
        buffer.height /= 2;
    }
}

template <typename Data> void spoilData(CameraKind kind, Data &data) {
    lie(kind, Fault::FrameCount, data.frame_count);
    if (hasFault(kind, Fault::NullFrames))
        data.frames = nullptr;
    if (hasFault(kind, Fault::Version))
        data.version += 7;
}

} // namespace ml2sim
