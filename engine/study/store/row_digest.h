// SHA-256 of a row with its child rows, stored beside it: by it, a value that the disk changed is
// detected, where SQLite checks little but the structure.
#pragma once

#include "base/sha256.h"
#include "engine/study/store/fields.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

namespace springdrive::study {

/// Each value follows its length or the number of its kind, so that no two rows have the same
/// bytes. A NaN counts as not known, as it is stored.
class RowDigest {
public:
    template <typename Row> RowDigest(std::string_view table, std::int64_t id, const Row &row) {
        add(table);
        add(id);
        add_row(row);
    }

    [[nodiscard]] std::string hex() { return sha256_.hex(); }

private:
    template <typename Row> void add_row(const Row &row) {
        for_each_field(row, [&](std::string_view, const auto &value) { add(value); });
        for_each_list(row, [&](std::string_view table, const auto &values) {
            add(table);
            add(values.size());
            for (const auto &value : values) {
                add_row(value);
            }
        });
    }

    void add(std::string_view text) { sha256_.add(text); }
    void add(const std::string &text) { sha256_.add(std::string_view(text)); }
    template <std::integral Integer> void add(Integer number) {
        sha256_.add(static_cast<std::uint64_t>(number));
    }
    void add(double number) { sha256_.add(std::bit_cast<std::uint64_t>(number)); }
    void add(UtcTime time) { add(time.time_since_epoch().count()); }
    void add(DeviceKind kind) { add(name_of(kind)); }
    void add(SessionEnding ending) { add(name_of(ending)); }
    void add(const TrialPlace &place) {
        add(place.block);
        add(place.position);
        add(place.attempt);
    }
    void add(const RecordLink &link) {
        add(link.path.string());
        add(link.sha256);
    }
    void add(const NoResponse & /*none*/) {}
    void add(const Chosen &chosen) { add(chosen.alternative); }
    void add(const YesNo &answer) { add(answer.yes); }
    void add(const Adjusted &adjusted) { add(adjusted.level); }
    template <typename... Kinds> void add(const std::variant<Kinds...> &value) {
        add(value.index());
        std::visit([&](const auto &one) { add(one); }, value);
    }
    void add(const std::optional<double> &number) {
        const bool is_known = number && !std::isnan(*number);
        add(is_known);
        if (is_known) {
            add(*number);
        }
    }
    template <typename Value> void add(const std::optional<Value> &value) {
        add(value.has_value());
        if (value) {
            add(*value);
        }
    }

    Sha256 sha256_;
};

} // namespace springdrive::study
