#include "engine/study/protocol/protocol_file.h"

#include "base/field_toml.h"
#include "engine/study/protocol/protocol_fields.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

namespace springdrive::study {

namespace {

constexpr std::size_t kMaxRows = 100;

/// In metres, from the device's zero pose: more than any device reaches.
constexpr double kFarthest_m = 2.0;

/// A table that may be left out.
template <typename Fields, typename Struct>
void read_table(StrictTomlTable &file, std::string_view name, const Fields &fields, Struct &into) {
    if (file.has_optional(name)) {
        StrictTomlTable table = file.table(name);
        read(table, fields, into);
        table.refuse_unknown_keys();
    }
}

template <typename Fields, typename Struct>
void read_table(StrictTomlTable &file, std::string_view name, const Fields &fields,
                std::optional<Struct> &into) {
    if (file.has_optional(name)) {
        read_table(file, name, fields, into.emplace());
    }
}

/// Passes on an error of the values, "KEY is VALUE; it must be …", with the key's file and line;
/// KEY may lead into inner tables, "threshold.minimum". Does nothing with an empty one.
void refuse_as(StrictTomlTable &table, const std::string &error) {
    if (error.empty()) {
        return;
    }
    const std::size_t end = std::min(error.find(' '), error.size());
    const std::string key = error.substr(0, end);
    const std::size_t dot = key.find('.');
    if (dot != std::string::npos && table.has(key.substr(0, dot))) {
        StrictTomlTable inner = table.table(key.substr(0, dot));
        refuse_as(inner, error.substr(dot + 1));
    }
    table.refuse(key, error.substr(std::min(end + 1, error.size())));
}

/// Refuses a row whose name is empty or another's.
template <typename Rows>
void check_name(const StrictTomlTable &row, const std::string &name, const Rows &others) {
    if (name.empty()) {
        row.refuse("name", "is empty; each must have one");
    }
    if (std::ranges::any_of(others, [&name](const auto &other) { return other.name == name; })) {
        row.refuse("name", "is \"" + name + "\" like that of another; each must have its own");
    }
}

/// The parameters of a condition that are there; the others keep what `into` has.
void read_parameters(StrictTomlTable &table, Condition &into) {
    read(table, kConditionFields, into);
    for (const ParameterFacts &parameter : condition_parameters()) {
        if (table.has_optional(parameter.name)) {
            parameter.set(into,
                          table.number(parameter.name, {parameter.minimum, parameter.maximum}));
        }
    }
    if (table.has_optional("point_m") || table.has_optional("normal")) {
        scene::TouchSpot &spot = into.spot.emplace();
        spot.point_m = table.vector("point_m", {-kFarthest_m, kFarthest_m});
        spot.normal = table.vector("normal", {-1e3, 1e3});
        if (!(spot.normal.norm() > 1e-6)) {
            table.refuse("normal", "has no length; it must point out of the surface");
        }
        spot.normal.normalize();
    }
}

void read_conditions(StrictTomlTable &file, Protocol &protocol) {
    Condition common;
    if (file.has_optional("common")) {
        StrictTomlTable table = file.table("common");
        read_parameters(table, common);
        table.refuse_unknown_keys();
    }
    file.rows("condition", kMaxRows, [&](StrictTomlTable &table) {
        Condition condition = common;
        read(table, kConditionName, condition);
        read_parameters(table, condition);
        table.refuse_unknown_keys();
        check_name(table, condition.name, protocol.conditions);
        protocol.conditions.push_back(std::move(condition));
    });
}

void read_blocks(StrictTomlTable &file, Protocol &protocol) {
    if (!file.has_optional("block")) {
        ProtocolBlock all{"all", std::vector<std::size_t>(protocol.conditions.size())};
        std::iota(all.conditions.begin(), all.conditions.end(), std::size_t{0});
        protocol.blocks.push_back(std::move(all));
        return;
    }
    file.rows("block", kMaxRows, [&protocol](StrictTomlTable &table) {
        ProtocolBlock block;
        read(table, kBlockFields, block);
        for (const std::string &name : table.texts("conditions", kMaxRows)) {
            const std::optional<std::size_t> condition = condition_named(protocol, name);
            if (!condition) {
                table.refuse("conditions", "has \"" + name +
                                               "\"; it must be one of the conditions: " +
                                               names_of(protocol.conditions));
            }
            block.conditions.push_back(*condition);
        }
        table.refuse_unknown_keys();
        check_name(table, block.name, protocol.blocks);
        protocol.blocks.push_back(std::move(block));
    });
}

void read_axis(StrictTomlTable table, PriorAxis &axis) {
    read(table, kPriorFields, axis.prior);
    read(table, kPriorAxisFields, axis);
    table.refuse_unknown_keys();
}

void read_method(StrictTomlTable &table, const Task &, ConstantStimuli &method) {
    read(table, kConstantStimuliFields, method);
}

void read_method(StrictTomlTable &table, const Task &, Staircases &method) {
    read(table, kStaircaseFields, method);
    table.rows("steps", kMaxRows, [&method](StrictTomlTable &row) {
        read(row, kStepFields, method.steps.emplace_back());
        row.refuse_unknown_keys();
    });
}

void read_method(StrictTomlTable &table, const Task &task, QuestPlus &method) {
    read(table, kQuestPlusFields, method);
    const GuessRange guess = guess_range(task);
    method.threshold.prior.scale = method.family.scale;
    method.slope.prior.scale = Scale::logarithmic;
    method.guess.prior.minimum = guess.minimum;
    method.guess.prior.maximum = guess.maximum;
    method.guess.points = guess.minimum == guess.maximum ? 1 : 5;
    method.lapse.prior = known(0.02);
    read_axis(table.table("threshold"), method.threshold);
    read_axis(table.table("slope"), method.slope);
    if (table.has_optional("guess")) {
        read_axis(table.table("guess"), method.guess);
    }
    if (table.has_optional("lapse")) {
        read_axis(table.table("lapse"), method.lapse);
    }
}

void read_method(StrictTomlTable &table, const Task &, Adjustment &method) {
    read(table, kAdjustmentFields, method);
}

void read_procedure(StrictTomlTable &file, Protocol &protocol) {
    StrictTomlTable task = file.table("task");
    read(task, kTaskFields, protocol.task);
    task.refuse_unknown_keys();
    StrictTomlTable table = file.table("method");
    read(table, kMethodFields, protocol);
    std::visit([&](auto &method) { read_method(table, protocol.task, method); }, protocol.method);
    table.refuse_unknown_keys();
}

/// The values of a kind of question. Another kind has none of them.
template <typename Fields>
void read_if(QuestionnaireKind kind, StrictTomlTable &table, const Fields &fields,
             QuestionnaireItem &item) {
    const auto name = [](QuestionnaireKind one) {
        return '"' + std::string(kQuestionnaireKindNames[static_cast<std::size_t>(one)]) + '"';
    };
    if (item.kind == kind) {
        read(table, fields, item);
        return;
    }
    for (const Field<QuestionnaireItem> &field : fields) {
        if (table.has_optional(field.name)) {
            table.refuse(field.name, "is there though kind is " + name(item.kind) +
                                         "; it must be left out, as it is of kind " + name(kind) +
                                         " alone");
        }
    }
}

void read_questions(StrictTomlTable &file, std::vector<QuestionnaireItem> &items) {
    if (!file.has_optional("questions")) {
        return;
    }
    file.rows("questions", kMaxRows, [&items](StrictTomlTable &table) {
        QuestionnaireItem item;
        read(table, kQuestionFields, item);
        read_if(QuestionnaireKind::scale, table, kScaleFields, item);
        read_if(QuestionnaireKind::choice, table, kChoiceFields, item);
        table.refuse_unknown_keys();
        refuse_as(table, validate(item));
        check_name(table, item.name, items);
        items.push_back(std::move(item));
    });
}

Protocol protocol_in(StrictTomlTable file) {
    Protocol protocol;
    read(file, kProtocolFields, protocol);
    visit_tables(protocol, [&file](std::string_view name, const auto &fields, auto &values) {
        read_table(file, name, fields, values);
    });
    read_conditions(file, protocol);
    StrictTomlTable variable = file.table("variable");
    read(variable, kVariableFields, protocol.variable);
    variable.refuse_unknown_keys();
    read_procedure(file, protocol);
    read_blocks(file, protocol);
    read_questions(file, protocol.questionnaire);
    file.refuse_unknown_keys();
    refuse_as(file, validate(protocol));
    return protocol;
}

} // namespace

Protocol read_protocol_file(const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::read(file));
}

Protocol read_protocol_text(const std::string &text, const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::parse(text, file));
}

} // namespace springdrive::study
