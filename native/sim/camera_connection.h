// What the depth, world and eye cameras have in common: one strict client, and frames on a fixed grid of time.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>

#include "clock.h"
#include "frame_lease.h"
#include "ml_types.h"
#include "settings.h"

namespace ml2sim {

/** A handle that was never given before. */
MLHandle newHandle();

/** When a camera captures, and how long after the centre of exposure a frame can be got (readout and transfer). */
struct CaptureTiming {
    uint32_t rate_hz;
    int64_t delayNanos;
};

/** A camera and the one client that it may have. The vendor's functions are called on it under a Call. */
class CameraConnection {
  public:
    CameraConnection(CameraKind kind, const char *name) : kind_(kind), name_(name) {}

    /** Gives the camera to the calling thread, unless a fault or another client stands against it. */
    MLResult open(MLHandle *out);

    /** Frames from now on come so. */
    void start(CaptureTiming timing);

    /**
     * Waits for a capture that was not got before, for at most timeout_ms; index is its number on the grid. None come
     * while delivers is false.
     */
    MLResult awaitFrame(
        uint64_t timeout_ms, int64_t *index, bool (*delivers)() = [] { return true; });

    /** Whether a get may begin; a second one before release is a misuse. */
    MLResult beginGet();
    /** Ends a get of the caller's struct. */
    MLResult release(const void *data);
    /** Opens memory for the frames that go into the caller's struct. */
    FrameLease &lease(const void *data, size_t bytes);

    void close();
    /** Forgets the client without a word. */
    void reset();

    bool isOpen() const { return handle_ != ML_INVALID_HANDLE; }
    /** Whether the camera went away, by fault, since it was opened. */
    bool isDisconnected();

  private:
    friend class CameraCall;
    bool isDropped(int64_t index) const;

    const CameraKind kind_;
    const char *const name_;
    std::atomic<MLHandle> handle_{ML_INVALID_HANDLE};
    std::atomic<pid_t> owner_{0};
    std::atomic<bool> isBusy_{false};
    std::atomic<bool> isDisconnected_{false};
    CaptureTiming timing_{};
    int64_t lastIndex_ = 0;
    const void *leasedTo_ = nullptr;
    FrameLease lease_;
};

/** One call of a vendor function on a connection: refused from the wrong thread, for the wrong handle, or beside
 * another. */
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

/** Tells of an argument that the vendor's interface does not allow. */
MLResult refuseArgument(const char *function, const char *what);
MLResult refuseVersion(const char *function, uint32_t expected, uint32_t found);

} // namespace ml2sim
