#include "app/commands/study/opened_study.h"

#include "app/host/folders.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/store/study_store.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <string_view>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStudyEnding = ".study";

std::string text_in(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

bool is_sqlite_file(const fs::path &file) {
    constexpr std::string_view kBegin("SQLite format 3\0", 16);
    std::array<char, kBegin.size()> begin{};
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) { // a pipe would wait for its writer
        return false;
    }
    std::ifstream stream(file, std::ios::binary);
    return stream.read(begin.data(), begin.size()) &&
           std::string_view(begin.data(), begin.size()) == kBegin;
}

/// The protocol as it was typed, which can be run.
study::Protocol checked_protocol(const fs::path &file) {
    const study::Protocol protocol = typed_protocol(file);
    study::CheckOptions options;
    options.simulates = false;
    study::ProtocolFindings findings;
    try {
        findings = study::check_protocol(protocol, folders_beside(file), options).findings;
    } catch (const InputError &error) { // of a file that it names
        throw InputError(file.string() + ": " + error.what());
    }
    const auto errors =
        std::ranges::count(findings, study::Severity::error, &study::ProtocolFinding::severity);
    if (errors > 0) {
        throw InputError(fmt::format("{}: has {} error{}, which springdrive study check shows; "
                                     "nobody should sit down before",
                                     file.string(), errors, errors == 1 ? "" : "s"));
    }
    return protocol;
}

/// A study looks for the device and scenes of its protocol beside itself.
void require_files_beside(const fs::path &study, const study::Protocol &protocol,
                          const fs::path &typed) {
    std::string problem;
    try {
        for (const study::PlacedCondition &condition :
             study::study_setting(protocol, folders_beside(study)).conditions) {
            problem = problem.empty() ? condition.problem : problem;
        }
    } catch (const InputError &error) {
        problem = error.what();
    }
    if (!problem.empty()) {
        throw InputError(fmt::format("{}: what the protocol names has to be beside the study: {}; "
                                     "keep the study in the folder of {}",
                                     study.string(), problem, typed.string()));
    }
}

std::size_t trials_on_kind(const study::StudyContents &contents, study::DeviceKind kind) {
    return study::trials_on(contents, kind).size();
}

/// "1 trial", "96 trials"
std::string trials_text(std::size_t trials) {
    return fmt::format("{} trial{}", trials, trials == 1 ? "" : "s");
}

} // namespace

std::string unfinished_removal_text(const study::StudyContents &contents,
                                    const std::filesystem::path &file) {
    return contents.unfinished_removals.empty()
               ? std::string()
               : fmt::format("{0}: the deletion of {1} was interrupted; springdrive study remove "
                             "{0} {1} --yes completes it",
                             file.string(), contents.unfinished_removals.front());
}

void warn_of_study(const study::StudyContents &contents, const std::filesystem::path &file) {
    const fs::path records = resolved_name(file).parent_path() / contents.facts.records_folder;
    for (const std::string &warning : {unfinished_removal_text(contents, file),
                                       others_access_text(file), others_access_text(records)}) {
        if (!warning.empty()) {
            std::cerr << "springdrive: " << warning << '\n';
        }
    }
    const std::vector<study::Participant> &all = contents.participants;
    for (auto one = all.begin(); one != all.end(); ++one) {
        for (auto other = all.begin(); other != one; ++other) {
            if (study::is_mistaken_for(one->code, other->code)) {
                std::cerr << fmt::format("springdrive: {}: {} and {} are two participants, with "
                                         "results apart; if they are one person, they stay so\n",
                                         file.string(), other->code, one->code);
            }
        }
    }
}

OpenedStudy read_opened_study(const std::filesystem::path &file) {
    OpenedStudy opened;
    opened.contents = study::read_study(file);
    opened.protocol = protocol_in(opened.contents, file);
    warn_of_study(opened.contents, file);
    for (const study::ProtocolFinding &finding : study::check_names(opened.protocol)) {
        std::cerr << fmt::format("springdrive: {}: {} {}; their results are apart\n", file.string(),
                                 finding.where, finding.what);
    }
    return opened;
}

study::Protocol protocol_in(const study::StudyContents &contents,
                            const std::filesystem::path &file) {
    return study::read_protocol_text(contents.facts.protocol, file.string() + " (its protocol)");
}

study::Protocol typed_protocol(const std::filesystem::path &file) {
    if (is_sqlite_file(file)) {
        throw InputError(fmt::format("{}: is a study, no protocol; name the TOML file that it was "
                                     "begun with, or springdrive study status {}",
                                     file.string(), file.string()));
    }
    return study::read_protocol_file(file);
}

std::vector<std::filesystem::path> files_of_study(const std::filesystem::path &file) {
    std::vector<std::filesystem::path> files = study::files_beside(file);
    files.push_back(file);
    return files;
}

study::ProtocolFolders folders_beside(const std::filesystem::path &file) {
    return {file.parent_path(), asset_folder()};
}

std::filesystem::path study_to_run(const std::filesystem::path &typed,
                                   const std::filesystem::path &study,
                                   const std::function<void(const study::Protocol &)> &accepts) {
    if (typed.extension() == kStudyEnding) {
        if (!study.empty()) {
            throw InputError("--study goes with a protocol; " + typed.string() +
                             " is a study already");
        }
        return typed;
    }
    const fs::path file = study.empty() ? fs::path(typed).replace_extension(kStudyEnding) : study;
    if (fs::exists(file)) {
        const std::string text = text_in(typed);
        static_cast<void>(study::read_protocol_text(text, typed));
        if (study::read_study(file).facts.protocol != text) {
            throw InputError(fmt::format("{}: was begun with another protocol than {}; go on with "
                                         "its own by springdrive study run {}, or begin a new "
                                         "study with --study FILE",
                                         file.string(), typed.string(), file.string()));
        }
        return file;
    }
    const study::Protocol protocol = checked_protocol(typed);
    accepts(protocol);
    require_files_beside(file, protocol, typed);
    study::create_study(file, {protocol.title, text_in(typed), SPRINGDRIVE_VERSION},
                        study::utc_now());
    std::cerr << "created: " << file.string() << '\n';
    return file;
}

void add_study_file_argument(Command &command, std::filesystem::path &file) {
    command.add_option("study", file, "a study file, as study run makes it")
        .type_name("FILE")
        .required();
}

void add_device_kind_option(Command &command, study::DeviceKind &device) {
    std::map<std::string, study::DeviceKind> kinds;
    std::string names;
    for (std::size_t i = 0; i < study::kDeviceKindNames.size(); ++i) {
        const std::string name(study::kDeviceKindNames[i]);
        kinds[name] = static_cast<study::DeviceKind>(i);
        names += (names.empty() ? "{" : ",") + name;
    }
    command
        .add_choice("--device", device, kinds,
                    "only trials on this kind of device; those of a simulated or emulated one are "
                    "no person's, and taken only if asked for [usb]")
        .type_name("KIND:" + names + "}");
}

std::string left_out_text(const study::StudyContents &contents, study::DeviceKind taken,
                          const std::filesystem::path &file) {
    std::string text;
    for (std::size_t i = 0; i < study::kDeviceKindNames.size(); ++i) {
        const auto kind = static_cast<study::DeviceKind>(i);
        const std::size_t trials = trials_on_kind(contents, kind);
        if (kind != taken && trials > 0) {
            text += fmt::format("{}{} on {} devices (--device {})", text.empty() ? "" : ", ",
                                trials_text(trials), study::name_of(kind), study::name_of(kind));
        }
    }
    return text.empty() ? text : file.string() + ": left out are " + text;
}

void refuse_without_trials(const study::StudyContents &contents, study::DeviceKind device,
                           const std::filesystem::path &file) {
    if (trials_on_kind(contents, device) > 0) {
        return;
    }
    const std::string left_out = left_out_text(contents, device, file);
    throw InputError(
        left_out.empty()
            ? file.string() + ": has no trials yet; springdrive study run adds some"
            : fmt::format("{}; there are none on {} devices", left_out, study::name_of(device)));
}

} // namespace springdrive::app
