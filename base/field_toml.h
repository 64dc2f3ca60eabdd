// Lists of fields in TOML files, and the reference of a file's keys.
#pragma once

#include "base/field.h"
#include "base/strict_toml.h"
#include "base/table.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace springdrive {

/// Reads those values that the table has; the others keep what `value` has.
/// @throw InputError as `StrictTomlTable` does, also where a required one is missing
template <typename Fields, typename Struct>
void read(StrictTomlTable &table, const Fields &fields, Struct &value) {
    for (const Field<Struct> &field : fields) {
        if (!table.has_optional(field.name) && field.presence != kRequired) {
            continue;
        }
        const auto [minimum, maximum] = field.range;
        const auto take = [&, minimum = minimum, maximum = maximum](const auto &member) {
            using Member = std::decay_t<decltype(member)>;
            if constexpr (std::is_same_v<Member, Choice<Struct>>) {
                member.set(value, table.choice(field.name, member.names));
            } else if constexpr (std::is_same_v<Member, double Struct::*>) {
                value.*member = table.number(field.name, field.range);
            } else if constexpr (std::is_same_v<Member, int Struct::*>) {
                value.*member =
                    table.integer(field.name, static_cast<int>(minimum), static_cast<int>(maximum));
            } else if constexpr (std::is_same_v<Member, bool Struct::*>) {
                value.*member = table.flag(field.name);
            } else if constexpr (std::is_same_v<Member, std::string Struct::*>) {
                value.*member = table.text(field.name, field.range);
            } else if constexpr (std::is_same_v<Member, std::vector<double> Struct::*>) {
                constexpr std::size_t kMaxNumbers = 1000;
                value.*member = table.numbers(field.name, field.range, kMaxNumbers);
            } else {
                value.*member = table.texts(field.name, static_cast<std::size_t>(maximum));
            }
        };
        std::visit(take, field.member);
    }
}

/// A value as TOML, with every digit of a number.
template <typename Struct>
[[nodiscard]] std::string toml_value(const Field<Struct> &field, const Struct &value) {
    const auto text_of = [&value](const auto &member) -> std::string {
        using Member = std::decay_t<decltype(member)>;
        if constexpr (std::is_same_v<Member, Choice<Struct>>) {
            return toml_string(member.names[member.get(value)]);
        } else if constexpr (std::is_same_v<Member, double Struct::*>) {
            return toml_number(value.*member);
        } else if constexpr (std::is_same_v<Member, std::string Struct::*>) {
            return toml_string(value.*member);
        } else if constexpr (std::is_same_v<Member, std::vector<std::string> Struct::*>) {
            return toml_list(value.*member);
        } else if constexpr (std::is_same_v<Member, std::vector<double> Struct::*>) {
            std::string list;
            for (const double number : value.*member) {
                list += (list.empty() ? "" : ", ") + toml_number(number);
            }
            return '[' + list + ']';
        } else {
            return fmt::format("{}", value.*member);
        }
    };
    return std::visit(text_of, field.member);
}

/// "NAME = VALUE", each on a line.
template <typename Fields, typename Struct>
void write(std::ostream &out, const Fields &fields, const Struct &value) {
    for (const Field<Struct> &field : fields) {
        out << field.name << " = " << toml_value(field, value) << '\n';
    }
}

/// What a file may have as a value: "0.1 to 10".
template <typename Struct> [[nodiscard]] std::string allowed(const Field<Struct> &field) {
    const std::string range = fmt::format("{:g} to {:g}", field.range.minimum, field.range.maximum);
    if (const auto *const choice = std::get_if<Choice<Struct>>(&field.member)) {
        const std::string list = toml_list(choice->names);
        return list.substr(1, list.size() - 2);
    }
    if (field.is_number()) {
        return std::holds_alternative<int Struct::*>(field.member) ? range + ", whole" : range;
    }
    if (std::holds_alternative<bool Struct::*>(field.member)) {
        return "true, false";
    }
    return std::holds_alternative<std::string Struct::*>(field.member)           ? "text"
           : std::holds_alternative<std::vector<double> Struct::*>(field.member) ? "numbers"
                                                                                 : range + " texts";
}

/// A cell of `reference`: "0.1 to 10 s (0.5)"; what is empty is left out.
[[nodiscard]] inline std::string with_unit_and_default(std::string text, std::string_view unit,
                                                       std::string_view default_value) {
    if (!unit.empty()) {
        text += fmt::format(" {}", unit);
    }
    if (!default_value.empty()) {
        text += fmt::format(" ({})", default_value);
    }
    return text;
}

/// The keys of one or more lists, each with the default that its struct has.
template <typename... Lists> [[nodiscard]] Table reference(const Lists &...lists) {
    Table table = Table::with_columns("key,allowed (default),meaning");
    const auto add = [&table]<typename Struct>(const Field<Struct> &field) {
        const std::string default_value = field.presence == kRequired ? "required"
                                          : field.presence == kDerived
                                              ? ""
                                              : toml_value(field, Struct());
        table.rows.push_back({fmt::format("`{}`", field.name),
                              with_unit_and_default(allowed(field), field.unit, default_value),
                              field.help});
    };
    (std::ranges::for_each(lists, add), ...);
    return table;
}

} // namespace springdrive
