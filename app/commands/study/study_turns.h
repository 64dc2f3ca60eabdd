// A study that is open, while its participants take their turns: people, in the windows of a
// session, and simulated observers.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "app/commands/study/observer_options.h"
#include "app/study/experimenter/study_window.h"
#include "app/study/session/study_session.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// The options hold references to this: it must stay where it is until the parse is over.
struct TypedStudySession {
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
                                                         const TypedStudySession &typed);

/// Runs it from the first word on the screen to the last.
/// @param code  a participant of the store
/// @throw InputError if device or windows cannot be opened, or as StudySession::run does
void run_person_session(study::StudyStore &store, const study::Protocol &protocol,
                        const study::StudySetting &setting, const study::ProtocolFolders &folders,
                        const std::string &code, const TypedStudySession &typed);

struct TypedRun {
    std::filesystem::path file;  ///< a protocol or a study
    std::filesystem::path study; ///< with a protocol; empty: its name, with another ending
    std::string participant;
    int participants = 0; ///< 0: the one above
    std::string observer; ///< empty: a person
    TypedObserver truth;
    double spread = 0.0;
    std::optional<int> seed; ///< nothing: the protocol's
    study::FeltStimuli felt = study::FeltStimuli::each_simulated;
    TypedStudySession study_session; ///< of a person

    [[nodiscard]] bool is_simulated() const { return !observer.empty(); }
};

class StudyTurns {
public:
    /// @param typed  must outlive it
    /// @throw InputError if the study cannot be opened, or a condition cannot be used
    StudyTurns(const std::filesystem::path &file, const TypedRun &typed);

    [[nodiscard]] std::vector<study::Progress> progress() const;
    [[nodiscard]] bool is_through(const std::string &code) const;
    /// Whether the sessions are a person's, not a simulated observer's; of somebody new, whether
    /// they would be as it is typed.
    [[nodiscard]] bool is_person(const std::string &code) const;

    /// Who comes next if nobody is named: added already but not begun, or new.
    [[nodiscard]] std::string next_code() const;
    /// "P07"
    [[nodiscard]] static std::string code_of(int number);

    /// The participant's session, of the kind of the first one, else as typed; added to the study
    /// if they are new. Tells of it on standard output.
    /// @throw InputError if all trials are done; as `study::conduct` and `run_person_session` do
    /// @throw what `end_with_status` does, for an end that is no success
    void run(const std::string &code);
    /// The same, which must be a person's. @throw InputError if it is a simulated observer
    void run_person(const std::string &code);

private:
    [[nodiscard]] std::optional<study::Session> last_session(const std::string &code) const;
    /// Without a window, until they are through or the program is asked to end.
    void run_simulated(const study::Progress &before);
    [[nodiscard]] SimulatedObserver observer_of_participant(const study::Progress &progress) const;
    void tell(const std::string &code) const;

    const TypedRun &typed_;
    study::StudyStore store_;
    study::Protocol protocol_;
    study::StudySetting setting_;
};

} // namespace springdrive::app
