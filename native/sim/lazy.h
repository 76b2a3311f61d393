#pragma once

#include <functional>
#include <mutex>
#include <optional>

namespace ml2sim {

/** A value that the first get() makes. Thread-safe. */
template <typename T> class Lazy {
  public:
    explicit Lazy(std::function<T()> make) : make_(std::move(make)) {}
    const T &get() {
        std::call_once(once_, [this] { value_.emplace(make_()); });
        return *value_;
    }

  private:
    std::function<T()> make_;
    std::once_flag once_;
    std::optional<T> value_;
};

} // namespace ml2sim
