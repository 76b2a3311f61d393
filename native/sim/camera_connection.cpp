#include "camera_connection.h"

#include <unistd.h>

#include <algorithm>
#include <limits>

#include "counters.h"
#include "head_path.h"

namespace ml2sim {
namespace {

/** Android's DEAD_OBJECT. The vendor does not list it. */
constexpr MLResult kDeadObject = -32;

int64_t deadlineAfter(uint64_t timeout_ms) {
    const int64_t now = mlTimeNow();
    const auto most = static_cast<uint64_t>(std::numeric_limits<int64_t>::max() - now);
    return now + static_cast<int64_t>(std::min(timeout_ms, most / 1000000) * 1000000);
}

} // namespace

MLHandle newHandle() {
    static std::atomic<MLHandle> next{0x4d4c325300000001};
    return next++;
}

MLResult CameraConnection::open(MLHandle *out) {
    *out = ML_INVALID_HANDLE;
    if (hasFault(kind_, Fault::Permission))
        return MLResult_PermissionDenied;
    if (hasFault(kind_, Fault::Connect) || hasFault(kind_, Fault::Disconnected))
        return MLResult_UnspecifiedFailure;
    MLHandle expected = ML_INVALID_HANDLE;
    const MLHandle handle = newHandle();
    if (!handle_.compare_exchange_strong(expected, handle)) {
        misuse(ML2SIM_MISUSE_CLIENTS, "%s camera: connected while handle %#lx is open", name_, expected);
        return MLResult_UnspecifiedFailure;
    }
    owner_ = gettid();
    isDisconnected_ = false;
    leasedTo_ = nullptr;
    timing_ = {};
    leftOut_ = 0;
    adjust(Counter::Handles, 1);
    *out = handle;
    return MLResult_Ok;
}

int64_t CameraConnection::newestDelivered() const {
    return captureIndex(mlTimeNow() - timing_.delayNanos, timing_.rate_hz);
}

void CameraConnection::start(CaptureTiming timing, bool isDrawn) {
    const int64_t newest = captureIndex(mlTimeNow(), timing.rate_hz);
    if (isDrawn && timing.rate_hz == timing_.rate_hz)
        leaveOutUntil(newest);
    timing_ = timing;
    lastIndex_ = newest;
}

void CameraConnection::leaveOut(int64_t captures) {
    if (captures <= 0)
        return;
    leftOut_ += captures;
    countLeftOut(name_, captures);
}

bool CameraConnection::isDropped(int64_t index) const {
    const auto every = static_cast<int64_t>(fault(kind_, Fault::DropEvery));
    return every > 0 && (index - leftOut_) % every == 0;
}

void CameraConnection::leaveOutUntil(int64_t index) {
    leaveOut(index - lastIndex_);
    lastIndex_ = std::max(lastIndex_, index);
}

/** Leaves out the captures between two that are not drawn. */
void CameraConnection::leaveOutUndrawn(const CaptureFrames &frames, int64_t from, int64_t to) {
    int64_t undrawn = 0;
    for (int64_t index = from + 1; index < to; index++)
        undrawn += FrameCache::areDrawn(frames(index)) ? 0 : 1;
    leaveOut(undrawn);
}

/** Finds the newest capture that is drawn. What fell due until `missed` was there for the caller, who did not come. */
bool CameraConnection::findDrawn(const CaptureFrames &frames, int64_t newest, int64_t missed) {
    drawer_.begin(frames, timing_.rate_hz, timing_.delayNanos);
    int64_t latest = newest;
    while (latest > lastIndex_ && !FrameCache::areDrawn(frames(latest)))
        latest--;
    if (latest <= lastIndex_)
        return false;
    leaveOutUndrawn(frames, std::max(lastIndex_, missed), latest);
    lastIndex_ = latest;
    leftOutUntil_ = newest;
    return !isDropped(latest);
}

/** Draws the newest capture, for a clock that stands still meanwhile. */
bool CameraConnection::drawNewest(const CaptureFrames &frames, int64_t newest) {
    int64_t latest = newest;
    while (latest > lastIndex_ && isDropped(latest))
        latest--;
    if (latest <= lastIndex_)
        return false;
    lastIndex_ = leftOutUntil_ = latest;
    if (FrameCache::draw(frames(latest)))
        leftOutUntil_ = newestDelivered() - 1;
    return true;
}

MLResult CameraConnection::awaitFrame(uint64_t timeout_ms, const CaptureFrames &frames, int64_t *index,
                                      bool (*delivers)()) {
    const int64_t deadline = deadlineAfter(timeout_ms);
    const int64_t missed = newestDelivered();
    while (true) {
        const uint64_t seen = wakeCount();
        if (isDisconnected())
            return MLResult_UnspecifiedFailure;
        if (hasFault(kind_, Fault::Get))
            return fault(kind_, Fault::Get) == 1 ? MLResult{MLResult_UnspecifiedFailure} : kDeadObject;
        const int64_t now = mlTimeNow();
        const int64_t newest = newestDelivered();
        const bool isStalled = hasFault(kind_, Fault::Stalled) || !delivers();
        if (!isStalled && (drawsAhead() ? findDrawn(frames, newest, missed) : drawNewest(frames, newest))) {
            *index = lastIndex_;
            return MLResult_Ok;
        }
        if (now >= deadline) {
            if (!isStalled && drawsAhead()) {
                leaveOutUndrawn(frames, std::max(lastIndex_, missed), newest + 1);
                lastIndex_ = std::max(lastIndex_, newest);
            }
            return MLResult_Timeout;
        }
        const int64_t next = captureTime(std::max(newest, lastIndex_) + 1, timing_.rate_hz) + timing_.delayNanos;
        waitUntil(isStalled ? deadline : std::min(deadline, next), seen);
    }
}

bool CameraConnection::isDisconnected() {
    if (hasFault(kind_, Fault::Disconnected))
        isDisconnected_ = true;
    return isDisconnected_;
}

MLResult CameraConnection::beginGet() {
    if (leasedTo_ == nullptr)
        return MLResult_Ok;
    misuse(ML2SIM_MISUSE_GET_TWICE, "%s camera: data got again before it was released", name_);
    return MLResult_IllegalState;
}

FrameLease &CameraConnection::lease(const void *data, size_t bytes) {
    lease_.begin(bytes);
    leasedTo_ = data;
    adjust(Counter::Gets, 1);
    return lease_;
}

MLResult CameraConnection::release(const void *data) {
    if (leasedTo_ == nullptr || leasedTo_ != data) {
        misuse(ML2SIM_MISUSE_RELEASE, "%s camera: released %p, %s", name_, data,
               leasedTo_ == nullptr ? "but nothing is got" : "but other data was got");
        return MLResult_InvalidParam;
    }
    lease_.end();
    leasedTo_ = nullptr;
    adjust(Counter::Gets, -1);
    return MLResult_Ok;
}

void CameraConnection::close() {
    if (leasedTo_ != nullptr) {
        misuse(ML2SIM_MISUSE_UNRELEASED, "%s camera: disconnected before its data was released", name_);
        release(leasedTo_);
    }
    handle_ = ML_INVALID_HANDLE;
    adjust(Counter::Handles, -1);
}

void CameraConnection::reset() {
    if (lease_.isActive())
        lease_.end();
    leasedTo_ = nullptr;
    handle_ = ML_INVALID_HANDLE;
}

CameraCall::CameraCall(CameraConnection &connection, MLHandle handle, const char *function)
    : connection_(connection), result_(MLResult_IllegalState) {
    passHold(function);
    if (handle != connection.handle_ || handle == ML_INVALID_HANDLE) {
        misuse(ML2SIM_MISUSE_HANDLE, "%s: handle %#lx is not open", function, handle);
        result_ = MLResult_InvalidParam;
    } else if (connection.owner_ != gettid()) {
        misuse(ML2SIM_MISUSE_THREAD, "%s: called from thread %d, the handle is of %d%s", function, gettid(),
               connection.owner_.load(), connection.isBusy_ ? ", which is in a call" : "");
    } else {
        isInside_ = true;
        connection.isBusy_ = true;
        result_ = MLResult_Ok;
    }
}

CameraCall::~CameraCall() {
    if (isInside_)
        connection_.isBusy_ = false;
}

void passHold(const char *function) {
    const auto isHeld = [function] {
        const auto held = text(Key::Held);
        return !held.empty() && ("+" + held + "+").find("+" + std::string(function) + "+") != std::string::npos;
    };
    for (uint64_t seen = wakeCount(); isHeld(); seen = wakeCount())
        waitUntil(mlTimeNow() + kSecond, seen);
}

MLResult refuseArgument(const char *function, const char *what) {
    misuse(ML2SIM_MISUSE_ARGUMENT, "%s: %s", function, what);
    return MLResult_InvalidParam;
}

MLResult refuseVersion(const char *function, uint32_t expected, uint32_t found) {
    misuse(ML2SIM_MISUSE_VERSION, "%s: expected version %u, found %u", function, expected, found);
    return MLResult_InvalidParam;
}

} // namespace ml2sim
