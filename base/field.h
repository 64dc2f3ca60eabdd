// Lists of the values of a struct. Files, checks and reference pages follow from one list:
// base/field_toml.h reads and writes them.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive {

/// The allowed range of a number. Bounds are inclusive.
struct NumberRange {
    double minimum = -std::numeric_limits<double>::max();
    double maximum = std::numeric_limits<double>::max();
};

/// An enumeration in a struct, as one of several names, by its number: see `choice_of`.
template <typename Struct> struct Choice {
    std::span<const std::string_view> names;
    std::size_t (*get)(const Struct &) = nullptr;
    void (*set)(Struct &, std::size_t) = nullptr;
};

/// The struct of a pointer to a member.
template <auto member> struct StructOf;
template <typename Struct, typename Value, Value Struct::*member> struct StructOf<member> {
    using Type = Struct;
};

/// `choice_of<&Task::kind>(kTaskKindNames)`; further pointers lead into a member that is a struct.
template <auto member, auto... inner>
[[nodiscard]] constexpr auto choice_of(std::span<const std::string_view> names) {
    using Struct = typename StructOf<member>::Type;
    return Choice<Struct>{
        names,
        [](const Struct &value) { return static_cast<std::size_t>(((value.*member).*....*inner)); },
        [](Struct &value, std::size_t number) {
            auto &chosen = ((value.*member).*....*inner);
            chosen = static_cast<std::remove_reference_t<decltype(chosen)>>(number);
        }};
}

enum class Presence : std::uint8_t {
    optional,
    derived, ///< optional; what holds without it is not the struct's default: its help says it
    required ///< a file must have it
};
inline constexpr Presence kDerived = Presence::derived;
inline constexpr Presence kRequired = Presence::required;

/// The range of a text of which something can be seen [bytes].
inline constexpr NumberRange kReadable{1.0, 10'000.0};

/// One value of a struct.
template <typename Struct> struct Field {
    using Member = std::variant<double Struct::*, int Struct::*, bool Struct::*,
                                std::string Struct::*, std::vector<double> Struct::*,
                                std::vector<std::string> Struct::*, Choice<Struct>>;

    std::string_view name; ///< in files, with its unit
    Member member;
    std::string_view help;
    NumberRange range;     ///< of a number, or of each in a list; how many texts; a text's bytes
    std::string_view unit; ///< UTF-8; empty: none
    Presence presence = Presence::optional;

    constexpr Field(std::string_view its_name, Member its_member, std::string_view its_help,
                    NumberRange its_range, std::string_view its_unit = "",
                    Presence its_presence = Presence::optional)
        : name(its_name), member(its_member), help(its_help), range(its_range), unit(its_unit),
          presence(its_presence) {}
    constexpr Field(std::string_view its_name, Member its_member, std::string_view its_help,
                    double minimum, double maximum, std::string_view its_unit = "",
                    Presence its_presence = Presence::optional)
        : Field(its_name, its_member, its_help, {minimum, maximum}, its_unit, its_presence) {}
    constexpr Field(std::string_view its_name, Member its_member, std::string_view its_help,
                    Presence its_presence = Presence::optional)
        : Field(its_name, its_member, its_help, NumberRange(), "", its_presence) {}

    /// @pre it is a number
    [[nodiscard]] double number(const Struct &value) const {
        const auto *const whole = std::get_if<int Struct::*>(&member);
        return whole != nullptr ? value.**whole : value.*std::get<double Struct::*>(member);
    }
    [[nodiscard]] bool is_number() const { return member.index() < 2; }
};

/// "NAME is VALUE; it must be from MINIMUM to MAXIMUM" if it is not, also for a NaN; else empty.
[[nodiscard]] inline std::string unless_from_to(std::string_view name, double value, double minimum,
                                                double maximum) {
    return value >= minimum && value <= maximum // written so that a NaN lies in no range
               ? std::string()
               : fmt::format("{} is {:g}; it must be from {:g} to {:g}", name, value, minimum,
                             maximum);
}

/// The same of the first number of a struct that is out of its range.
template <typename Fields, typename Struct>
[[nodiscard]] std::string out_of_range(const Fields &fields, const Struct &value) {
    for (const Field<Struct> &field : fields) {
        if (field.is_number()) {
            std::string wrong = unless_from_to(field.name, field.number(value), field.range.minimum,
                                               field.range.maximum);
            if (!wrong.empty()) {
                return wrong;
            }
        }
    }
    return {};
}

} // namespace springdrive
