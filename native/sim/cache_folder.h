// The folder that keeps rendered frames for later runs.
#pragma once

#include <cstddef>
#include <string>

namespace ml2sim {

/** The most that the files of the folder have together. */
constexpr size_t kMostCacheBytes = size_t{4} << 30;

/**
 * Opens the file `name` in the folder, sparse and of this size; makes it if there is none, or one of another size.
 * Removes the files that have not been used for longest, so that all together have at most kMostCacheBytes; who has
 * one open keeps it. A file that is larger by itself is removed, too, when this process ends. Several processes may do
 * so at once. Returns a descriptor, or -1 and errno.
 */
int openCacheFile(const std::string &folder, const std::string &name, size_t bytes);

} // namespace ml2sim
