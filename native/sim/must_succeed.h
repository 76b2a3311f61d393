#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace ml2sim {

/** Ends the process, with errno and what failed, unless it is done. */
inline void mustSucceed(bool isDone, const std::string &what) {
    if (isDone)
        return;
    std::perror(("ml2sim: " + what).c_str());
    std::abort();
}

} // namespace ml2sim
