#include "engine/study/protocol/texts.h"

#include "base/text.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace springdrive::study {

namespace {

/// "{}" and "{name}" of a text, in its order.
std::vector<std::string_view> placeholders_in(std::string_view text) {
    std::vector<std::string_view> found;
    for (std::size_t from = text.find('{'); from != std::string_view::npos;
         from = text.find('{', from + 1)) {
        const std::size_t to = text.find('}', from);
        if (to != std::string_view::npos) {
            found.push_back(text.substr(from, to + 1 - from));
        }
    }
    return found;
}

std::string wrong_placeholders(std::string_view key, std::string_view text,
                               std::string_view by_default) {
    const std::vector<std::string_view> needed = placeholders_in(by_default);
    const std::vector<std::string_view> found = placeholders_in(text);
    for (const std::string_view placeholder : needed) {
        if (const auto count = std::ranges::count(found, placeholder); count != 1) {
            return fmt::format("{} has {} {} times; it must have it once", key, placeholder, count);
        }
    }
    for (const std::string_view placeholder : found) {
        if (std::ranges::count(needed, placeholder) == 0) {
            return fmt::format("{} has {}, for which nothing is filled in; it must have {}{}", key,
                               in_quotes(placeholder),
                               needed.empty() ? "no text in braces"
                                              : "no other text in braces than ",
                               fmt::join(needed, " and "));
        }
    }
    return {};
}

constexpr std::size_t kMaxItemName = 40;

bool is_item_name(std::string_view name) {
    const auto is_small_letter = [](char c) { return c >= 'a' && c <= 'z'; };
    return !name.empty() && name.size() <= kMaxItemName && is_small_letter(name.front()) &&
           std::ranges::all_of(name, [&](char c) {
               return is_small_letter(c) || (c >= '0' && c <= '9') || c == '_';
           });
}

/// Columns of tables of answers have these names already.
constexpr std::array<std::string_view, 2> kTakenNames{"participant_id", "session_id"};

bool is_control(char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }

/// Something to read, on one line: of labels and choices.
bool is_label(std::string_view text) {
    return text.find_first_not_of(' ') != std::string_view::npos &&
           std::ranges::none_of(text, is_control);
}

std::string wrong_scale(const QuestionnaireItem &item) {
    if (item.highest <= item.lowest || item.highest - item.lowest > kMaxScaleSteps) {
        return fmt::format("highest is {}; it must be 1 to {} above lowest, {}", item.highest,
                           kMaxScaleSteps, item.lowest);
    }
    for (const auto &[key, label] :
         {std::pair("lowest_label", &item.lowest_label), {"highest_label", &item.highest_label}}) {
        if (!is_label(*label)) {
            return fmt::format("{} is {}; it must be one line that can be read", key,
                               in_quotes(*label));
        }
    }
    return {};
}

std::string wrong_choices(const QuestionnaireItem &item) {
    if (item.choices.size() < 2 || item.choices.size() > kMaxChoices) {
        return fmt::format("choices has {}; it must have 2 to {}", item.choices.size(),
                           kMaxChoices);
    }
    for (const std::string &choice : item.choices) {
        if (!is_label(choice)) {
            return fmt::format("choices has {}; each must be one line that can be read",
                               in_quotes(choice));
        }
        if (const std::string wrong = validate_name(choice); !wrong.empty()) {
            return fmt::format("choices has {}, which {}", in_quotes(choice), wrong);
        }
        if (std::ranges::count(item.choices, choice) > 1) {
            return fmt::format("choices has {} twice; each must be there once", in_quotes(choice));
        }
    }
    return {};
}

} // namespace

std::string validate(const Texts &texts) {
    const Texts by_default;
    for (const Field<Texts> &field : kTextFields) {
        const auto text = std::get<std::string Texts::*>(field.member);
        if (std::string wrong = wrong_placeholders(field.name, texts.*text, by_default.*text);
            !wrong.empty()) {
            return wrong;
        }
    }
    return {};
}

std::string filled(std::string text, std::string_view placeholder, std::string_view value) {
    const std::size_t at = text.find(placeholder);
    return at == std::string::npos ? text : text.replace(at, placeholder.size(), value);
}

std::string validate(const QuestionnaireItem &item) {
    if (!is_item_name(item.name)) {
        return fmt::format("name is {}; it must be 1 to {} of a-z, 0-9 and _, beginning with a "
                           "letter",
                           in_quotes(item.name), kMaxItemName);
    }
    if (std::ranges::count(kTakenNames, item.name) > 0) {
        return fmt::format("name is \"{}\"; it must be another, as tables of answers have such a "
                           "column",
                           item.name);
    }
    switch (item.kind) {
    case QuestionnaireKind::scale:
        return wrong_scale(item);
    case QuestionnaireKind::choice:
        return wrong_choices(item);
    case QuestionnaireKind::text:
        break;
    }
    return {};
}

std::vector<std::string> possible_answers(const QuestionnaireItem &item) {
    std::vector<std::string> all;
    switch (item.kind) {
    case QuestionnaireKind::scale:
        for (int number = item.lowest; number <= item.highest; ++number) {
            all.push_back(std::to_string(number));
        }
        return all;
    case QuestionnaireKind::choice:
        return item.choices;
    case QuestionnaireKind::text:
        break;
    }
    return all;
}

} // namespace springdrive::study
