#include "futures.h"

#include "../clock.h"
#include "entry_points.h"

namespace ml2sim::xr {
namespace {

/** Belongs to the object of the call, with which it ends. */
struct Future : Object {
    std::string step;
    int64_t readyAt; ///< MLTime
    bool fails;
    std::function<void(bool succeeded)> end;
};

Future &futureOf(XrFutureEXT future, const char *what) {
    const auto found = runtime().objects.find(number(future));
    auto *begun = found == runtime().objects.end() ? nullptr : dynamic_cast<Future *>(found->second.get());
    if (begun == nullptr)
        misuse(ML2SIM_XR_MISUSE_FUTURE, XR_ERROR_FUTURE_INVALID_EXT, what);
    return *begun;
}

void endFuture(XrFutureEXT handle, const Future &future, bool succeeded) {
    const auto end = future.end;
    runtime().objects.erase(number(handle));
    end(succeeded);
}

} // namespace

XrFutureEXT beginFuture(uint64_t object, const char *step, std::function<void(bool succeeded)> end) {
    const auto &keys = runtime().keys;
    auto future = std::make_unique<Future>();
    future->diesWithParent = true;
    future->step = step;
    future->readyAt =
        keys.whole("fault.future.stuck") != 0 ? INT64_MAX : mlTimeNow() + keys.whole("future.delay_ms") * 1000000;
    future->fails = keys.text("fault.future.fails") == step;
    future->end = std::move(end);
    return registerObject<XrFutureEXT>(object, std::move(future));
}

XrResult completeFuture(uint64_t object, XrFutureEXT handle, const char *step, XrResult *futureResult) {
    const auto unknown = std::string("no future of ") + step + " to complete, or completed before";
    const auto &future = futureOf(handle, unknown.c_str());
    if (future.parent != object || future.step != step)
        misuse(ML2SIM_XR_MISUSE_FUTURE, XR_ERROR_FUTURE_INVALID_EXT, unknown);
    if (mlTimeNow() < future.readyAt)
        return XR_ERROR_FUTURE_PENDING_EXT;
    *futureResult = future.fails ? XR_ERROR_RUNTIME_FAILURE : XR_SUCCESS;
    endFuture(handle, future, !future.fails);
    return XR_SUCCESS;
}

XrResult xrPollFutureEXT(XrInstance instance, const XrFuturePollInfoEXT *pollInfo, XrFuturePollResultEXT *pollResult) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &info = requireType(pollInfo, XR_TYPE_FUTURE_POLL_INFO_EXT, "XrFuturePollInfoEXT");
        auto &out = requireType(pollResult, XR_TYPE_FUTURE_POLL_RESULT_EXT, "XrFuturePollResultEXT");
        const auto &future = futureOf(info.future, "no such future to poll");
        out.state = mlTimeNow() < future.readyAt ? XR_FUTURE_STATE_PENDING_EXT : XR_FUTURE_STATE_READY_EXT;
    });
}

XrResult xrCancelFutureEXT(XrInstance instance, const XrFutureCancelInfoEXT *cancelInfo) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &info = requireType(cancelInfo, XR_TYPE_FUTURE_CANCEL_INFO_EXT, "XrFutureCancelInfoEXT");
        endFuture(info.future, futureOf(info.future, "no such future to cancel"), false);
        ++runtime().counters.futures_cancelled;
    });
}

} // namespace ml2sim::xr
