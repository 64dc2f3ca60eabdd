#include "base/field_toml.h"
#include "engine/study/protocol/protocol_fields.h"

#include <ostream>
#include <string_view>

namespace springdrive::study {

namespace {

void write_keys(std::ostream &out, std::string_view heading, const Table &keys) {
    out << '\n' << heading << "\n\n";
    write_markdown(out, keys);
}

Table condition_keys() {
    Table table = reference(kConditionFields);
    table.rows.push_back({"`point_m`", Cell(), "three numbers", "the scene's own spot",
                          "the spot, on the surface, in device coordinates [m]; with `normal`"});
    table.rows.push_back({"`normal`", Cell(), "three numbers", "the scene's own spot",
                          "out of the surface there; of any length"});
    for (const ParameterFacts &one : condition_parameters()) {
        table.rows.push_back({fmt::format("`{}`", one.name), one.unit,
                              fmt::format("{:g} to {:g}", one.minimum, one.maximum),
                              toml_number(one.default_value), one.help});
    }
    return table;
}

Table block_keys() {
    Table table = reference(kBlockFields);
    table.rows.push_back(
        {"`conditions`", Cell(), "names of conditions", "required",
         "whose trials are interleaved in it; without any [[block]] there is one of all"});
    return table;
}

} // namespace

void write_protocol_keys(std::ostream &out) {
    write_keys(out, "Before all tables:", reference(kProtocolFields));
    write_keys(out,
               "`[common]`, for all conditions, and `[[condition]]`, for one:", condition_keys());
    write_keys(out, "`[[condition]]` only:", reference(kConditionName));
    write_keys(out, "`[variable]`:", reference(kVariableFields));
    write_keys(out, "`[task]`:", reference(kTaskFields));
    write_keys(out, "`[method]`:", reference(kMethodFields));
    write_keys(out, "`[method]` of the kind constant_stimuli:", reference(kConstantStimuliFields));
    write_keys(out, "`[method]` of the kind staircases:", reference(kStaircaseFields));
    write_keys(out, "`[[method.steps]]` of staircases:", reference(kStepFields));
    write_keys(out, "`[method]` of the kind quest_plus:", reference(kQuestPlusFields));
    write_keys(out,
               "`[method.threshold]`, `[method.slope]`, `[method.guess]` and `[method.lapse]` of "
               "quest_plus, the last two optional:",
               reference(kPriorFields, kPriorAxisFields));
    write_keys(out, "`[method]` of the kind adjustment:", reference(kAdjustmentFields));
    write_keys(out, "`[[block]]`:", block_keys());
    write_keys(out, "`[[questions]]`:", reference(kQuestionFields, kScaleFields, kChoiceFields));
    Protocol any;
    visit_tables(any, [&out](std::string_view name, const auto &fields, const auto &) {
        write_keys(out, fmt::format("`[{}]`:", name), reference(fields));
    });
}

} // namespace springdrive::study
