#include "app/assistant/progress_file.h"

#include "app/host/user_folder.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/one_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <ostream>
#include <system_error>

namespace springdrive::app::assistant {

namespace {

constexpr const char *kHeading = "springdrive assistant 1";

struct Mark {
    std::string_view word;
    StepSet Progress::*steps = nullptr;
};
constexpr std::array<Mark, 2> kMarks{{{"done ", &Progress::done}, {"failed ", &Progress::failed}}};

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
    return name;
}

Progress read_progress(const std::filesystem::path &file) {
    Progress progress;
    std::error_code ignored;
    if (file.empty() || !std::filesystem::exists(file, ignored)) {
        return progress;
    }
    std::ifstream stream(file);
    std::string line;
    int number = 1;
    if (!std::getline(stream, line) || line != kHeading) {
        throw InputError(fmt::format("{}:1: must be '{}'; remove the file to begin anew",
                                     file.string(), kHeading));
    }
    while (std::getline(stream, line)) {
        ++number;
        const auto *const mark = std::ranges::find_if(
            kMarks, [&](const Mark &some) { return line.starts_with(some.word); });
        const std::string_view name =
            std::string_view(line).substr(mark == kMarks.end() ? 0 : mark->word.size());
        const auto *const step = std::ranges::find(kStepTitles, name, &StepTitle::name);
        if (mark == kMarks.end() || step == kStepTitles.end()) {
            throw InputError(fmt::format("{}:{}: {} names no step; remove the file to begin anew",
                                         file.string(), number, in_quotes(line)));
        }
        (progress.*mark->steps).set(static_cast<std::size_t>(step - kStepTitles.begin()));
    }
    return progress;
}

void write_progress(const std::filesystem::path &file, const Progress &progress) {
    std::error_code ignored; // without the folder, the file cannot be created, which is said
    std::filesystem::create_directories(file.parent_path(), ignored);
    write_file(
        file,
        [&](std::ostream &out) {
            out << kHeading << '\n';
            for (const Mark &mark : kMarks) {
                for (std::size_t i = 0; i < kSteps; ++i) {
                    if ((progress.*mark.steps).test(i)) {
                        out << mark.word << kStepTitles[i].name << '\n';
                    }
                }
            }
        },
        Existing::replace);
}

} // namespace springdrive::app::assistant
