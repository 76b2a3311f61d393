#include "cache_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <vector>

namespace ml2sim {
namespace {

namespace fs = std::filesystem;

struct CacheFile {
    fs::path path;
    size_t bytes;
    fs::file_time_type used;
};

/** Returns the files of frames, of older versions too; other files that a user may have there are left alone. */
std::vector<CacheFile> filesIn(const std::string &folder) {
    std::vector<CacheFile> files;
    std::error_code gone; // Another process removes files, too.
    for (fs::directory_iterator entry(folder, gone), end; entry != end; entry.increment(gone)) {
        if (entry->path().filename().string().find(".frames") == std::string::npos || !entry->is_regular_file(gone))
            continue;
        std::error_code failure;
        const CacheFile file{entry->path(), static_cast<size_t>(entry->file_size(failure)),
                             entry->last_write_time(gone)};
        if (!failure && !gone)
            files.push_back(file);
    }
    return files;
}

/** Removes the oldest files until there is room for this many bytes besides `kept`. */
void makeRoom(const std::string &folder, const fs::path &kept, size_t bytes) {
    auto files = filesIn(folder);
    std::sort(files.begin(), files.end(), [](const auto &a, const auto &b) { return a.used > b.used; });
    size_t sum = bytes;
    for (const auto &file : files) {
        if (file.path == kept)
            continue;
        sum += file.bytes;
        std::error_code gone;
        if (sum > kMostCacheBytes)
            fs::remove(file.path, gone);
    }
}

} // namespace

int openCacheFile(const std::string &folder, const std::string &name, size_t bytes) {
    const auto path = folder + "/" + name;
    const auto size = static_cast<off_t>(bytes);
    struct stat found {};
    if (stat(path.c_str(), &found) == 0 && found.st_size != 0 && found.st_size != size)
        unlink(path.c_str());
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0)
        return -1;
    // Another process may do the same at the same time.
    if (ftruncate(file, size) != 0 || futimens(file, nullptr) != 0) {
        const int failure = errno;
        close(file);
        errno = failure;
        return -1;
    }
    if (bytes > kMostCacheBytes)
        unlink(path.c_str());
    else
        makeRoom(folder, path, bytes);
    return file;
}

} // namespace ml2sim
