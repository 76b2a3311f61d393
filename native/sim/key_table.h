// Keys of a simulation: name, kind, allowed values, default and current value of each.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace ml2sim {

/** A table of keys whose values are set as text. Thread-safe. */
class KeyTable {
  public:
    enum class Kind { Whole, Real, Text };

    /** One key. A number has a range. Text has a list of choices, the first of them its default, or takes any text. */
    struct Row {
        std::string name;
        Kind kind;
        double standard;
        double least;
        double most;
        std::string meaning;
        bool shapesTheScene = false;
        std::vector<std::string> choices = {};
    };

    explicit KeyTable(std::vector<Row> rows);

    const std::vector<Row> &rows() const { return rows_; }

    /** Returns the index of the key, or the number of keys if there is none of this name. */
    size_t indexOf(const std::string &name) const;

    double number(size_t index) const { return numbers_[index]; }
    std::string text(size_t index) const;

    /** Return the value of the key of this name, which must exist. */
    int64_t whole(const std::string &name) const { return static_cast<int64_t>(numbers_.at(indexOf(name))); }
    std::string text(const std::string &name) const { return text(indexOf(name)); }

    /** Returns the value of a key as set() takes it. */
    std::string value(size_t index) const;

    /** Sets a key. Returns an empty text, or an error that names what was expected. */
    std::string set(const std::string &name, const std::string &value);

    /** Sets all keys to their defaults, then to "key=value,key=value" of an environment variable; errors as set(). */
    std::string reset(const char *environmentVariable);

    /** One line for each key: name, value, default, kind, least, most, choices and meaning, with tabs between. */
    std::string describe() const;

  private:
    std::string setText(size_t index, const std::string &value);
    std::string setNumber(size_t index, const std::string &value);
    std::string nearestName(const std::string &name) const;

    const std::vector<Row> rows_;
    std::vector<std::atomic<double>> numbers_;
    mutable std::mutex mutex_;
    std::vector<std::string> texts_;
};

} // namespace ml2sim
