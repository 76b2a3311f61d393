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

/** An identifier of no camera, when the fault says so. */
inline uint32_t spoiltId(CameraKind kind, uint32_t id) { return hasFault(kind, Fault::Id) ? 0x40 : id; }

template <typename Data> void spoilData(CameraKind kind, Data &data) {
    lie(kind, Fault::FrameCount, data.frame_count);
    if (hasFault(kind, Fault::NullFrames))
        data.frames = nullptr;
    if (hasFault(kind, Fault::Version))
        data.version += 7;
}

} // namespace ml2sim
