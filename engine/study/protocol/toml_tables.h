// Readers that all parts of a protocol file share.
#pragma once

#include "base/strict_toml.h"
#include "engine/study/protocol/protocol_keys.h"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

inline constexpr std::array<std::string_view, 2> kScaleNames{"linear", "logarithmic"};

/// Reads those numbers that are there; the others keep what `into` has.
template <typename Table, std::size_t count>
void read_numbers(StrictTomlTable &table, const std::array<NumberKey<Table>, count> &keys,
                  Table &into) {
    for (const NumberKey<Table> &key : keys) {
        if (!table.has_optional(key.key)) {
            continue;
        }
        if (key.whole != nullptr) {
            into.*key.whole = table.integer(key.key, static_cast<int>(key.minimum),
                                            static_cast<int>(key.maximum));
        } else {
            into.*key.number = table.number(key.key, {key.minimum, key.maximum});
        }
    }
}

/// One of the names, if the key is there.
template <typename Enum, std::size_t count>
void read_choice(StrictTomlTable &table, std::string_view key,
                 const std::array<std::string_view, count> &names, Enum &into) {
    if (table.has_optional(key)) {
        into = static_cast<Enum>(table.choice(key, names));
    }
}

/// A list of levels, if the key is there.
void read_levels(StrictTomlTable &table, std::string_view key, std::vector<double> &into);

/// A text of at least one visible letter, if the key is there.
void read_text(StrictTomlTable &table, std::string_view key, std::string &into);

/// Passes on a complaint of the values, "KEY is VALUE; it must be …", with the key's file and line;
/// KEY may lead into inner tables, "threshold.minimum". Does nothing with an empty one.
void refuse_as(StrictTomlTable &table, const std::string &complaint);

/// [task], [method], [practice] and [catch_trials].
void read_procedure(StrictTomlTable &file, Protocol &protocol);

/// Everything that is for the participant alone: [texts], [noise] and the tables [[questions]].
void read_for_participant(StrictTomlTable &file, Protocol &protocol);

} // namespace springdrive::study
