// Asynchronous calls: each begins a future, which is polled and then completed or cancelled once.
#pragma once

#include <functional>

#include "runtime.h"

namespace ml2sim::xr {

/** Begins a call on an object. end is called once, when the call is completed (with its success) or cancelled. */
XrFutureEXT beginFuture(uint64_t object, const char *step, std::function<void(bool succeeded)> end);

/** Ends a call of the object and writes its result. Refuses a future of another call, or one that is not ready. */
XrResult completeFuture(uint64_t object, XrFutureEXT future, const char *step, XrResult *futureResult);

} // namespace ml2sim::xr
