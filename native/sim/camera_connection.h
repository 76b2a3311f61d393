// The state that depth, world and eye cameras share: their one client, and their capture times.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>

#include "clock.h"
#include "drawer.h"
#include "frame_lease.h"
#include "ml_types.h"
#include "settings.h"

namespace ml2sim {

/** Returns a handle that was not used before. */
MLHandle newHandle();

/** The rate of a camera, and the delay from the centre of exposure to delivery (readout and transfer). */
struct CaptureTiming {
    uint32_t rate_hz;
    int64_t delayNanos;
};

/** A camera and its one client. Each call of a vendor function needs a CameraCall. */
class CameraConnection {
  public:
    CameraConnection(CameraKind kind, const char *name) : kind_(kind), name_(name) {}

    /** Connects the calling thread, unless a fault is on or there is another client. */
    MLResult open(MLHandle *out);

    /** Starts captures with this timing. If frames were rendered for new settings, leaves out those since the last. */
    void start(CaptureTiming timing, bool isDrawn = false);

    /**
     * Waits at most timeout_ms for the next capture whose frames are drawn; index is its number. There are no captures
     * while delivers returns false. Captures that fall due meanwhile and are not drawn are left out.
     */
    MLResult awaitFrame(
        uint64_t timeout_ms, const CaptureFrames &frames, int64_t *index, bool (*delivers)() = [] { return true; });
    /** Ends a get, when the frame numbers are written. */
    void delivered() { leaveOutUntil(leftOutUntil_); }

    int64_t frameNumber(int64_t index) const {
        return (index - leftOut_) * static_cast<int64_t>(number(Key::AssumeFrameNumbers));
    }

    /** Leaves out the captures that fell due while a first frame was drawn, except the newest. */
    void leaveOutOverdue() { leaveOutUntil(newestDelivered() - 1); }

    /** Checks that a get may begin. A second get before the release is a misuse. */
    MLResult beginGet();
    /** Ends the get whose frames are in the caller's structure. */
    MLResult release(const void *data);
    /** Leases memory for the frames in the caller's structure. */
    FrameLease &lease(const void *data, size_t bytes);

    void close();
    /** Removes the client, without a check for misuse. */
    void reset();

    bool isOpen() const { return handle_ != ML_INVALID_HANDLE; }
    /** Returns true if a fault has disconnected the camera since it was opened. */
    bool isDisconnected();

  private:
    friend class CameraCall;
    bool isDropped(int64_t index) const;
    int64_t newestDelivered() const;
    void leaveOut(int64_t captures);
    void leaveOutUntil(int64_t index);
    void leaveOutUndrawn(const CaptureFrames &frames, int64_t from, int64_t to);
    bool findDrawn(const CaptureFrames &frames, int64_t newest, int64_t missed);
    bool drawNewest(const CaptureFrames &frames, int64_t newest);

    const CameraKind kind_;
    const char *const name_;
    std::atomic<MLHandle> handle_{ML_INVALID_HANDLE};
    std::atomic<pid_t> owner_{0};
    std::atomic<bool> isBusy_{false};
    std::atomic<bool> isDisconnected_{false};
    CaptureTiming timing_{};
    int64_t lastIndex_ = 0;
    int64_t leftOut_ = 0;      ///< Since the camera was opened.
    int64_t leftOutUntil_ = 0; ///< Captures up to this one are left out when the present one is delivered.
    Drawer drawer_;
    const void *leasedTo_ = nullptr;
    FrameLease lease_;
};

/** A call of a vendor function. It is refused for a wrong handle, from a wrong thread, and during another call. */
class CameraCall {
  public:
    CameraCall(CameraConnection &connection, MLHandle handle, const char *function);
    ~CameraCall();
    CameraCall(const CameraCall &) = delete;
    CameraCall &operator=(const CameraCall &) = delete;

    bool isRefused() const { return result_ != MLResult_Ok; }
    MLResult result() const { return result_; }

  private:
    CameraConnection &connection_;
    bool isInside_ = false;
    MLResult result_;
};

/** Returns when the key held does not name the function. */
void passHold(const char *function);

/** Count a misuse and return the result for it. */
MLResult refuseArgument(const char *function, const char *what);
MLResult refuseVersion(const char *function, uint32_t expected, uint32_t found);

/** Refuses a structure of the caller that is null or has another version. */
template <typename Structure>
MLResult checkStructure(const char *function, const Structure *structure, uint32_t version) {
    if (structure == nullptr)
        return refuseArgument(function, "the structure is null");
    if (structure->version != version)
        return refuseVersion(function, version, structure->version);
    return MLResult_Ok;
}

bool isDepthCameraOpen();
bool isWorldCameraOpen();
bool isEyeCameraOpen();

/** Remove the client of a camera, for ml2sim_reset. */
void resetDepthCamera();
void resetWorldCamera();
void resetEyeCamera();

} // namespace ml2sim
