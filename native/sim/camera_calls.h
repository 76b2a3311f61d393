// The vendor's calls that are equal for depth, world and eye cameras.
#pragma once

#include "camera_connection.h"
#include "camera_faults.h"

namespace ml2sim {

/** MLxxxCameraConnect. check returns the refusal of the settings, apply puts them in force. */
template <typename Check, typename Apply>
MLResult connectCamera(CameraConnection &connection, const char *function, MLHandle *out, const Check &check,
                       const Apply &apply) {
    passHold(function);
    if (out == nullptr)
        return refuseArgument(function, "the place for the handle is null");
    if (const auto result = check(function))
        return result;
    if (const auto result = connection.open(out))
        return result;
    apply();
    return MLResult_Ok;
}

/** MLxxxCameraUpdateSettings, with the functions of connectCamera. */
template <typename Check, typename Apply>
MLResult updateCamera(CameraConnection &connection, const char *function, MLHandle handle, const Check &check,
                      const Apply &apply) {
    const CameraCall call(connection, handle, function);
    if (call.isRefused())
        return call.result();
    if (const auto result = check(function))
        return result;
    if (connection.isDisconnected())
        return MLResult_UnspecifiedFailure;
    apply();
    return MLResult_Ok;
}

/** The captures of a camera, and the functions that deliver them. */
template <typename Data> struct CameraFilm {
    uint32_t version; ///< The version of Data.
    CaptureFrames framesOf;
    void (*lend)(int64_t index, Data *data);
    void (*begin)() = [] {};                  ///< Called in each get, before it waits.
    bool (*delivers)() = [] { return true; }; ///< Returns false while there are no captures.
};

/** MLxxxCameraGetLatestxxxData. */
template <typename Data>
MLResult getFrames(CameraConnection &connection, const char *function, MLHandle handle, uint64_t timeout_ms, Data *data,
                   const CameraFilm<Data> &film) {
    const CameraCall call(connection, handle, function);
    if (call.isRefused())
        return call.result();
    if (const auto result = checkStructure(function, data, film.version))
        return result;
    if (const auto result = connection.beginGet())
        return result;
    film.begin();
    int64_t index = 0;
    if (const auto result = connection.awaitFrame(timeout_ms, film.framesOf, &index, film.delivers))
        return result;
    film.lend(index, data);
    connection.delivered();
    return MLResult_Ok;
}

/** MLxxxCameraReleasexxxData. */
inline MLResult releaseFrames(CameraConnection &connection, const char *function, MLHandle handle, const void *data) {
    const CameraCall call(connection, handle, function);
    return call.isRefused() ? call.result() : connection.release(data);
}

/** MLxxxCameraDisconnect. */
inline MLResult disconnectCamera(CameraConnection &connection, const char *function, MLHandle handle) {
    const CameraCall call(connection, handle, function);
    if (!call.isRefused())
        connection.close();
    return call.result();
}

/** Lends `count` frames, each with bytesPerFrame bytes of pixels. A frame can come twice by a fault. */
template <typename Frame, typename Data, typename FrameOf>
void lendFrames(CameraConnection &connection, CameraKind kind, int64_t index, size_t count, size_t bytesPerFrame,
                Data *data, const FrameOf &frameOf) {
    FrameLease &lease = connection.lease(data, FrameLease::rounded((count + 1) * sizeof(Frame)) +
                                                   count * FrameLease::rounded(bytesPerFrame));
    data->frames = lease.allocate<Frame>(count + 1);
    data->frame_count = 0;
    for (size_t i = 0; i < count; i++) {
        const auto odd = oddFrameAt(kind, index, i, count);
        const auto frame = frameOf(i, odd, lease);
        data->frames[data->frame_count++] = frame;
        if (odd == OddFrame::Duplicate)
            data->frames[data->frame_count++] = frame;
    }
    corruptData(kind, *data);
}

} // namespace ml2sim
