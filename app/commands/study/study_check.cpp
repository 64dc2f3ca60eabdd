#include "app/commands/study/study_commands.h"

#include "app/commands/study/check_report.h"
#include "app/commands/study/opened_study.h"
#include "app/study/sitting/sitting.h"
#include "engine/study/protocol/protocol_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>

namespace springdrive::app {

namespace {

struct TypedProtocolCheck {
    std::filesystem::path protocol;
    bool simulates = true;
};

void check_typed(const TypedProtocolCheck &typed) {
    const study::Protocol protocol = typed_protocol(typed.protocol);
    study::CheckOptions options;
    options.simulates = typed.simulates;
    study::CheckedProtocol checked =
        study::check_protocol(protocol, folders_beside(typed.protocol), options);
    const study::StudySetting setting =
        study::study_setting(protocol, folders_beside(typed.protocol));
    std::ranges::move(study_screen::check_for_persons(protocol, setting),
                      std::back_inserter(checked.findings));
    std::ranges::stable_sort(checked.findings, {}, &study::ProtocolFinding::severity);
    write_study_check(std::cout, protocol, checked);
    const auto errors = std::ranges::count(checked.findings, study::Severity::error,
                                           &study::ProtocolFinding::severity);
    if (errors > 0) {
        std::cerr << fmt::format("springdrive: {}: {} error{}, see above; nobody should sit down "
                                 "before {} mended\n",
                                 typed.protocol.string(), errors, errors == 1 ? "" : "s",
                                 errors == 1 ? "it is" : "they are");
        end_with_status(EXIT_FAILURE);
    }
}

} // namespace

void add_study_check_command(Command &study) {
    Command command = study.add_subcommand(
        "check", "everything that can be said of a protocol before anybody sits down");
    const auto typed = std::make_shared<TypedProtocolCheck>();
    command.add_option("protocol", typed->protocol, "a protocol file").type_name("FILE").required();
    command.add_flag_callback(
        "--no-simulation", [typed] { typed->simulates = false; },
        "leave out the simulation of each condition");
    command.footer("Exit status: 0 no errors, 1 errors, or a file that is no protocol.");
    command.callback([typed] { check_typed(*typed); });
}

} // namespace springdrive::app
