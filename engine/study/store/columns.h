// Values in the columns of SQLite, and back.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/study_contents.h"

#include <algorithm>
#include <concepts>

namespace springdrive::study {

template <std::integral Integer> void store(Statement &row, Integer value) { row.bind(value); }
inline void store(Statement &row, const std::string &value) { row.bind(value); }
inline void store(Statement &row, const std::optional<double> &value) { row.bind(value); }
inline void store(Statement &row, UtcTime value) { row.bind(utc_text(value)); }
inline void store(Statement &row, DeviceKind value) { row.bind(name_of(value)); }
inline void store(Statement &row, SessionEnding value) { row.bind(name_of(value)); }
inline void store(Statement &row, const std::variant<double, std::string> &value) {
    std::visit([&](const auto &one) { row.bind(one); }, value);
}
inline void store(Statement &row, const TrialPlace &value) {
    row.bind(value.block).bind(value.position).bind(value.attempt);
}
inline void store(Statement &row, const RecordLink &value) {
    row.bind(value.path.string()).bind(value.sha256);
}
void store(Statement &row, const Response &value);

/// How many columns a value takes.
template <typename Value> inline constexpr int kColumns = 1;
template <> inline constexpr int kColumns<TrialPlace> = 3;
template <> inline constexpr int kColumns<RecordLink> = 2;

template <typename Value> void store(Statement &row, const std::optional<Value> &value) {
    if (value) {
        return store(row, *value);
    }
    for (int i = 0; i < kColumns<Value>; ++i) {
        row.bind_null();
    }
}

template <std::integral Integer> void load(Statement &row, Integer &value) {
    value = static_cast<Integer>(row.integer());
}
inline void load(Statement &row, std::string &value) { value = row.text(); }
inline void load(Statement &row, double &value) { value = row.real(); }
void load(Statement &row, UtcTime &value);
void load(Statement &row, DeviceKind &value);
void load(Statement &row, SessionEnding &value);
void load(Statement &row, std::variant<double, std::string> &value);
void load(Statement &row, TrialPlace &value);
void load(Statement &row, RecordLink &value);
void load(Statement &row, Response &value);

template <typename Value> void load(Statement &row, std::optional<Value> &value) {
    if (row.is_null()) {
        row.skip(kColumns<Value>);
        value.reset();
    } else {
        load(row, value.emplace());
    }
}

} // namespace springdrive::study
