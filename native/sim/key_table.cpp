#include "key_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <sstream>

namespace ml2sim {
namespace {

/** Returns the number of characters to insert, delete or change to turn one name into the other. */
size_t editDistance(const std::string &a, const std::string &b) {
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (size_t i = 1; i <= a.size(); i++) {
        size_t diagonal = row[0]++;
        for (size_t j = 1; j <= b.size(); j++) {
            const size_t changed = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
        }
    }
    return row[b.size()];
}

std::string shortest(double value) {
    std::ostringstream out;
    out.precision(17);
    out << value;
    return out.str();
}

std::string joined(const std::vector<std::string> &words, const char *separator) {
    std::string out;
    for (const auto &word : words)
        out += (&word == &words.front() ? "" : separator) + word;
    return out;
}

std::string defaultText(const KeyTable::Row &row) { return row.choices.empty() ? "" : row.choices.front(); }

} // namespace

KeyTable::KeyTable(std::vector<Row> rows) : rows_(std::move(rows)), numbers_(rows_.size()), texts_(rows_.size()) {
    for (size_t i = 0; i < rows_.size(); i++) {
        numbers_[i] = rows_[i].standard;
        texts_[i] = defaultText(rows_[i]);
    }
}

size_t KeyTable::indexOf(const std::string &name) const {
    const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const Row &row) { return row.name == name; });
    return static_cast<size_t>(found - rows_.begin());
}

std::string KeyTable::text(size_t index) const {
    const std::lock_guard lock(mutex_);
    return texts_[index];
}

std::string KeyTable::value(size_t index) const {
    return rows_[index].kind == Kind::Text ? text(index) : shortest(number(index));
}

std::string KeyTable::set(const std::string &name, const std::string &value) {
    const size_t index = indexOf(name);
    if (index == rows_.size())
        return "unknown key \"" + name + "\"; the nearest is \"" + nearestName(name) + "\"";
    return rows_[index].kind == Kind::Text ? setText(index, value) : setNumber(index, value);
}

std::string KeyTable::setText(size_t index, const std::string &value) {
    const auto &[name, choices] = std::tie(rows_[index].name, rows_[index].choices);
    if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end())
        return name + ": expected one of \"" + joined(choices, "\", \"") + "\", found \"" + value + "\"";
    const std::lock_guard lock(mutex_);
    texts_[index] = value;
    return "";
}

std::string KeyTable::setNumber(size_t index, const std::string &value) {
    const auto &row = rows_[index];
    char *end = nullptr;
    const double number = std::strtod(value.c_str(), &end);
    const bool isOfKind = row.kind == Kind::Real || number == std::floor(number);
    if (value.empty() || *end != '\0' || !(number >= row.least && number <= row.most) || !isOfKind)
        return row.name + (row.kind == Kind::Real ? ": expected a number from " : ": expected a whole number from ") +
               shortest(row.least) + " to " + shortest(row.most) + ", found \"" + value + "\"";
    numbers_[index] = number;
    return "";
}

std::string KeyTable::nearestName(const std::string &name) const {
    return std::min_element(
               rows_.begin(), rows_.end(),
               [&](const Row &a, const Row &b) { return editDistance(a.name, name) < editDistance(b.name, name); })
        ->name;
}

std::string KeyTable::reset(const char *environmentVariable) {
    for (const auto &row : rows_)
        set(row.name, row.kind == Kind::Text ? defaultText(row) : shortest(row.standard));
    const char *environment = std::getenv(environmentVariable);
    std::istringstream pairs(environment == nullptr ? "" : environment);
    std::string pair;
    while (std::getline(pairs, pair, ',')) {
        const auto equals = pair.find('=');
        if (equals == std::string::npos)
            return "expected key=value, found \"" + pair + "\"";
        const auto problem = set(pair.substr(0, equals), pair.substr(equals + 1));
        if (!problem.empty())
            return problem;
    }
    return "";
}

std::string KeyTable::describe() const {
    std::string out;
    for (size_t i = 0; i < rows_.size(); i++) {
        const auto &row = rows_[i];
        const bool isText = row.kind == Kind::Text;
        out += row.name + "\t" + value(i) + "\t" + (isText ? defaultText(row) : shortest(row.standard)) + "\t" +
               (isText                   ? "text"
                : row.kind == Kind::Real ? "real"
                                         : "whole") +
               "\t" + shortest(row.least) + "\t" + shortest(row.most) + "\t" + joined(row.choices, "|") + "\t" +
               row.meaning + "\n";
    }
    return out;
}

} // namespace ml2sim
