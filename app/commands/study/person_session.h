// A session with a person: the device, and the windows in which it takes place.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "app/study/experimenter/study_window.h"
#include "app/study/sitting/sitting.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"

#include <optional>
#include <string>

namespace springdrive::app {

/// The options hold references to this: it must stay where it is until the parse is over.
struct TypedSitting {
    std::string device = "sim";
    TypedEmulation emulation;
    bool starts_at_zero = false;
    bool is_in_lockstep = false;
    std::optional<int> cpu;
    bool keeps_records = true;
    bool plays_noise = true;
    study_screen::StudyWindowOptions window;
    bool reports = false; ///< answers requests on standard input, see ReportRequests

    void add_to(Command &command);
    void add_device_to(Command &command); ///< what `add_to` begins with
};

/// With the protocol's device and the first condition's scene, tuning and servo.
/// @throw InputError for a device that there is none of, or an option that is not for it
[[nodiscard]] session::SessionOptions session_options_of(const study::Protocol &protocol,
                                                         const study::ProtocolFolders &folders,
                                                         const TypedSitting &typed);

/// Runs it from the first word on the screen to the last.
/// @param code  a participant of the store
/// @throw InputError if device or windows cannot be opened, or as Sitting::run does
void run_person_session(study::StudyStore &store, const study::Protocol &protocol,
                        const study::StudySetting &setting, const study::ProtocolFolders &folders,
                        const std::string &code, const TypedSitting &typed);

} // namespace springdrive::app
