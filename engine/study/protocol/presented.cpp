#include "engine/study/protocol/presented.h"

#include <fmt/core.h>

#include <algorithm>

namespace springdrive::study {

namespace {

void add(std::vector<Presented> &all, const Protocol &protocol, std::size_t condition,
         std::optional<double> level) {
    Condition parameters =
        level ? comparison(protocol, condition, *level) : standard(protocol, condition);
    if (const std::optional<control::Tuning> free = free_space_tuning(protocol, parameters)) {
        all.push_back({condition, level, std::move(parameters), *free});
    }
}

bool is_in_a_block(const Protocol &protocol, std::size_t condition) {
    return std::ranges::any_of(protocol.blocks, [condition](const ProtocolBlock &block) {
        return std::ranges::count(block.conditions, condition) > 0;
    });
}

} // namespace

bool is_used(const Protocol &protocol, std::size_t condition) {
    return is_in_a_block(protocol, condition) || standard_condition_of(protocol) == condition;
}

std::vector<Presented> all_presented(const Protocol &protocol) {
    std::vector<Presented> all;
    const std::optional<std::size_t> shared = standard_condition_of(protocol);
    if (shared) {
        add(all, protocol, *shared, std::nullopt);
    }
    const std::vector<double> levels = presentable_levels(protocol);
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (!is_in_a_block(protocol, i)) {
            continue;
        }
        if (!shared) {
            add(all, protocol, i, std::nullopt);
        }
        for (const double level : levels) {
            add(all, protocol, i, level);
        }
    }
    return all;
}

std::vector<Presented> extremes(const std::vector<Presented> &all) {
    std::vector<Presented> some;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool is_first =
            i == 0 || all[i - 1].condition != all[i].condition || !all[i - 1].level.has_value();
        const bool is_last = i + 1 == all.size() || all[i + 1].condition != all[i].condition ||
                             !all[i + 1].level.has_value();
        if (!all[i].level || is_first || is_last) {
            some.push_back(all[i]);
        }
    }
    return some;
}

std::string name_of(const Protocol &protocol, const Presented &presented) {
    const std::string name =
        fmt::format("condition \"{}\"", protocol.conditions[presented.condition].name);
    if (!presented.level) {
        return name + ", the standard";
    }
    const ParameterFacts &variable = variable_of(protocol);
    return fmt::format("{} at level {:g} ({} {:g})", name, *presented.level, variable.name,
                       variable.get(presented.parameters));
}

} // namespace springdrive::study
