// The runtime's keys: faults and sizes, set by environment or by ml2sim_xr_set.
#pragma once

#include <map>
#include <string>

namespace ml2sim::xr {

class Keys {
  public:
    Keys();

    /// Empty, or what is wrong and what is allowed.
    std::string set(const std::string &key, const std::string &value);
    void reset();
    std::string describe() const;

    const std::string &text(const std::string &key) const;
    int64_t number(const std::string &key) const;

  private:
    struct Key {
        std::string value;
        std::string initial;
        std::string meaning;
        bool isNumber;
    };
    void declare(const char *key, const char *value, const char *meaning, bool isNumber);
    void readEnvironment();

    std::map<std::string, Key> keys_;
};

} // namespace ml2sim::xr
