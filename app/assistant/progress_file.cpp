#include "app/assistant/progress_file.h"

#include "app/host/user_folder.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/quoting.h"
#include "base/strict_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <string_view>
#include <system_error>
#include <vector>

namespace springdrive::app::assistant {

namespace {

struct StepList {
    const char *key = "";
    StepSet Progress::*steps = nullptr;
};
constexpr std::array<StepList, 2> kStepLists{
    {{"done", &Progress::done}, {"failed", &Progress::failed}}};

constexpr auto kStepNames = [] {
    std::array<std::string_view, kSteps> names;
    std::ranges::transform(kStepTitles, names.begin(), &StepTitle::name);
    return names;
}();

} // namespace

std::filesystem::path progress_folder() {
    const std::filesystem::path state = user_folder("XDG_STATE_HOME", ".local/state");
    return state.empty() ? state : state / "assistant";
}

std::string progress_name(const std::string &kind, const std::string &serial) {
    constexpr std::string_view kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    std::string name;
    for (const char letter : kind + "-" + serial) {
        name += kPlain.find(letter) != std::string_view::npos
                    ? std::string(1, letter)
                    : fmt::format("%{:02x}", static_cast<unsigned char>(letter));
    }
    return name + ".toml";
}

Progress read_progress(const std::filesystem::path &file) {
    Progress progress;
    std::error_code ignored;
    if (file.empty() || !std::filesystem::exists(file, ignored)) {
        return progress;
    }
    try {
        StrictTomlTable table = StrictTomlTable::read(file);
        for (const StepList &list : kStepLists) {
            for (const std::size_t step : table.choices(list.key, kStepNames)) {
                (progress.*list.steps).set(step);
            }
        }
        table.refuse_unknown_keys();
        return progress;
    } catch (const InputError &error) {
        throw InputError(std::string(error.what()) + "; remove the file to begin anew");
    }
}

void write_progress(const std::filesystem::path &file, const Progress &progress) {
    std::error_code ignored; // without the folder, the file cannot be created, which is said
    std::filesystem::create_directories(file.parent_path(), ignored);
    write_file(
        file,
        [&](std::ostream &out) {
            for (const StepList &list : kStepLists) {
                std::vector<std::string_view> names;
                for (std::size_t i = 0; i < kSteps; ++i) {
                    if ((progress.*list.steps).test(i)) {
                        names.push_back(kStepNames[i]);
                    }
                }
                out << list.key << " = " << toml_list(names) << '\n';
            }
        },
        Existing::replace);
}

} // namespace springdrive::app::assistant
