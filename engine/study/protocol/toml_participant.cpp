// The tables that are for the participant alone: texts, noise and questions.
#include "engine/study/protocol/toml_tables.h"

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::study {

namespace {

void read_texts(StrictTomlTable &file, Texts &texts) {
    if (!file.has_optional("texts")) {
        return;
    }
    StrictTomlTable table = file.table("texts");
    for (const ParticipantText &one : kParticipantTexts) {
        read_text(table, one.key, texts.*one.text);
    }
    table.refuse_unknown_keys();
    refuse_as(table, what_is_wrong_with(texts));
}

/// Refuses keys that say nothing about a question of this kind; they are known from now on.
void refuse_keys_of(StrictTomlTable &table, QuestionnaireKind kind,
                    std::initializer_list<std::string_view> keys, const QuestionnaireItem &item) {
    for (const std::string_view key : keys) {
        if (table.has_optional(key)) {
            table.refuse(key, "is there though kind is \"" +
                                  std::string(kQuestionnaireKindNames[std::size_t(item.kind)]) +
                                  "\"; it must be left out, as it is of kind \"" +
                                  std::string(kQuestionnaireKindNames[std::size_t(kind)]) +
                                  "\" alone");
        }
    }
}

QuestionnaireItem read_question(StrictTomlTable &table) {
    QuestionnaireItem item;
    item.name = table.text("name");
    item.when = static_cast<QuestionnaireTime>(table.choice("when", kQuestionnaireTimeNames));
    item.text = table.text("text");
    read_text(table, "text", item.text);
    item.kind = static_cast<QuestionnaireKind>(table.choice("kind", kQuestionnaireKindNames));
    if (item.kind == QuestionnaireKind::scale) {
        for (const NumberKey<QuestionnaireItem> &key : kQuestionKeys) {
            item.*key.whole = table.integer(key.key, static_cast<int>(key.minimum),
                                            static_cast<int>(key.maximum));
        }
        item.lowest_label = table.text("lowest_label");
        item.highest_label = table.text("highest_label");
    } else {
        refuse_keys_of(table, QuestionnaireKind::scale,
                       {"lowest", "highest", "lowest_label", "highest_label"}, item);
    }
    if (item.kind == QuestionnaireKind::choice) {
        item.choices = table.texts("choices", kMostChoices);
    } else {
        refuse_keys_of(table, QuestionnaireKind::choice, {"choices"}, item);
    }
    table.refuse_unknown_keys();
    refuse_as(table, what_is_wrong_with(item));
    return item;
}

void read_questions(StrictTomlTable &file, std::vector<QuestionnaireItem> &items) {
    if (!file.has_optional("questions")) {
        return;
    }
    file.rows("questions", kMostQuestions, [&items](StrictTomlTable &table) {
        QuestionnaireItem item = read_question(table);
        if (std::ranges::count(items, item.name, &QuestionnaireItem::name) > 0) {
            table.refuse("name",
                         "is \"" + item.name + "\" like that of another; each must have its own");
        }
        items.push_back(std::move(item));
    });
}

} // namespace

void read_for_participant(StrictTomlTable &file, Protocol &protocol) {
    read_texts(file, protocol.texts);
    read_questions(file, protocol.questionnaire);
    if (file.has_optional("noise")) {
        StrictTomlTable table = file.table("noise");
        read_numbers(table, kNoiseKeys, protocol.noise.emplace());
        table.refuse_unknown_keys();
    }
}

} // namespace springdrive::study
