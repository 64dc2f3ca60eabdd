#include "engine/control/tuning_file.h"

#include "base/strict_toml.h"
#include "engine/control/parameters.h"

#include <optional>
#include <string>

namespace springdrive {

namespace {

MotionMap read_map(StrictTomlTable &file) {
    const std::string name = file.text("map");
    const std::optional<MotionMap> map = motion_map_named(name);
    if (!map) {
        file.refuse("map", "is \"" + name + "\"; it must be inverse or transpose");
    }
    return *map;
}

AlphaMode read_alpha_mode(StrictTomlTable &file) {
    const std::string name = file.text("alpha_mode");
    const std::optional<AlphaMode> mode = alpha_mode_named(name);
    if (!mode) {
        file.refuse("alpha_mode", "is \"" + name + "\"; it must be on_the_fly, global or by_hand");
    }
    return *mode;
}

} // namespace

Tuning read_tuning_file(const std::filesystem::path &path) {
    StrictTomlTable file = StrictTomlTable::read(path);
    Tuning tuning;
    static_cast<void>(file.text("description"));
    for (const Parameter &parameter : kParameters) {
        tuning.*parameter.value =
            file.number(parameter.name, {parameter.lowest, parameter.highest});
    }
    tuning.map = read_map(file);
    tuning.alpha_mode = read_alpha_mode(file);
    file.refuse_unknown_keys();
    return tuning;
}

} // namespace springdrive
