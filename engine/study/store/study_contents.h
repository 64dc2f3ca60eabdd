// What a study file holds, as values, and what can be seen to be wrong with them.
#pragma once

#include <array>
#include <chrono>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::study {

// Wall-clock times of a study: UTC, to the millisecond, as ISO 8601 in files.

using UtcTime = std::chrono::sys_time<std::chrono::milliseconds>;

/// By the system's clock.
[[nodiscard]] UtcTime utc_now();

/// "2024-05-31T12:34:56.789Z".
/// @pre the year has four digits
[[nodiscard]] std::string utc_text(UtcTime time);

/// What `utc_text` writes; nothing for any other text.
[[nodiscard]] std::optional<UtcTime> utc_time_of(std::string_view text);

// A participant's code, which stands for a person whose name is not stored.

/// Why a text is no participant's code; empty when it is one. A code is one to three capital
/// letters, one to four digits and nothing else, such as P01: a name cannot be typed by mistake.
[[nodiscard]] std::string validate_code(std::string_view code);

/// Whether two codes that are not the same differ by zeros alone, as P1 and P01 do.
[[nodiscard]] bool is_mistaken_for(std::string_view code, std::string_view other);

/// Whether a text has the code, in letters of either case and not as a part of another code:
/// "p01, left-handed" has P01; "P012" and "XP01" have not.
[[nodiscard]] bool has_code(std::string_view text, std::string_view code);

/// Puts "[removed]" in the place of the code. @return whether the text had it, see `has_code`
bool redact_code(std::string &text, std::string_view code);

// What a study file holds, as values.
//
// Participants are known by code and number only; there is no field for a name. A number that is
// not known is left out (std::nullopt); a NaN is stored as not known. All other numbers are read
// back bit for bit.

/// What a session ran on. Data of the first two are no person's.
enum class DeviceKind : std::uint8_t { simulated, emulated, usb };
inline constexpr std::array<std::string_view, 3> kDeviceKindNames{"simulated", "emulated", "usb"};

[[nodiscard]] constexpr std::string_view name_of(DeviceKind kind) {
    return kDeviceKindNames[static_cast<std::size_t>(kind)];
}

/// A named number or text: a parameter of the tuning, a fact about the host.
struct Setting {
    std::string name; ///< with its unit, as "dR_Ohm" or "servo_hz"
    std::variant<double, std::string> value;

    friend bool operator==(const Setting &, const Setting &) = default;
};

struct StudyFacts {
    std::string title;
    std::string protocol;        ///< complete text of the protocol file
    std::string protocol_sha256; ///< of that text, lower-case hex
    UtcTime created{};
    std::string software; ///< version of the program that created it
    /// Of the servo records: a folder beside the study file, with one folder per participant.
    std::string records_folder;
    int removed_participants = 0; ///< deleted on request; nothing else is known of them

    friend bool operator==(const StudyFacts &, const StudyFacts &) = default;
};

struct Participant {
    std::string code; ///< see `validate_code`
    int number = 1;   ///< from 1, for counterbalancing; no two share one
    UtcTime added{};

    friend bool operator==(const Participant &, const Participant &) = default;
};

/// How a session ended.
enum class SessionEnding : std::uint8_t {
    completed,
    stopped, ///< by the experimenter
    left,    ///< by the participant
    device_lost,
    safety_trip,
    failed,      ///< by an error of the program
    interrupted, ///< the program ended without a word: killed, or its machine lost power
};
inline constexpr std::array<std::string_view, 7> kSessionEndingNames{
    "completed", "stopped", "left", "device_lost", "safety_trip", "failed", "interrupted"};

[[nodiscard]] constexpr std::string_view name_of(SessionEnding ending) {
    return kSessionEndingNames[static_cast<std::size_t>(ending)];
}

/// From 1, by the order in which sessions began in the study.
using SessionId = std::int64_t;

struct Session {
    SessionId id = 0; ///< given by the store
    std::string participant;
    UtcTime started{};
    std::optional<UtcTime> ended;        ///< not known while it runs or if it was interrupted
    std::optional<SessionEnding> ending; ///< nothing while it runs
    DeviceKind device = DeviceKind::simulated;
    std::string device_name;
    std::string device_serial;  ///< empty if it has none
    std::string software;       ///< version of the program
    std::string host;           ///< the machine
    std::vector<Setting> facts; ///< servo_hz, delay_periods, ...

    friend bool operator==(const Session &, const Session &) = default;
};

/// Where a trial stands in its participant's sequence; all from 1.
struct TrialPlace {
    int block = 1;
    int position = 1; ///< in the block
    int attempt = 1;  ///< 2 if it repeats the same position, ...

    // clang-tidy 14 takes the zero of its own comparison for a pointer.
    friend auto operator<=>(const TrialPlace &,
                            const TrialPlace &) = default; // NOLINT(modernize-use-nullptr)
};

/// "block 2, position 17, attempt 1"
[[nodiscard]] std::string text_of(const TrialPlace &place);

/// One measured property of a stimulus.
struct StimulusValue {
    std::string name; ///< with its unit: "stiffness_N_per_m", "direction_deg", "peak_force_N"
    std::optional<double> intended;
    std::optional<double> delivered;

    friend bool operator==(const StimulusValue &, const StimulusValue &) = default;
};

/// One interval or place in which a stimulus was presented; times by the servo's clock.
struct Presentation {
    std::optional<double> start_s;
    std::optional<double> end_s;
    std::vector<StimulusValue> values; ///< no name twice

    friend bool operator==(const Presentation &, const Presentation &) = default;
};

struct NoResponse { ///< too late, or the trial was broken off
    friend bool operator==(const NoResponse &, const NoResponse &) = default;
};
struct Chosen {
    int alternative = 1; ///< from 1, in the order of the presentations
    friend bool operator==(const Chosen &, const Chosen &) = default;
};
struct YesNo {
    bool yes = false;
    friend bool operator==(const YesNo &, const YesNo &) = default;
};
struct Adjusted {
    double level = 0.0; ///< in the unit of `Trial::level_name`
    friend bool operator==(const Adjusted &, const Adjusted &) = default;
};
using Response = std::variant<NoResponse, Chosen, YesNo, Adjusted>;

/// By their place in it, in stores and exports.
inline constexpr std::array<std::string_view, std::variant_size_v<Response>> kResponseNames{
    "none", "chosen", "yes_no", "adjusted"};

struct SafetyEvent {
    std::optional<double> time_s; ///< by the servo's clock
    std::string text;             ///< which monitor, which value, which limit

    friend bool operator==(const SafetyEvent &, const SafetyEvent &) = default;
};

/// A servo record that belongs to a trial.
struct RecordLink {
    std::filesystem::path path; ///< relative to the study file's folder, in `records_folder`
    std::string sha256;         ///< of the file, lower-case hex

    friend bool operator==(const RecordLink &, const RecordLink &) = default;
};

/// A trial that is to be run: what is known of it before.
struct PlannedTrial {
    TrialPlace place;      ///< no two trials of a participant share one
    std::string condition; ///< name in the protocol
    std::string track;     ///< of the method, such as a staircase; empty if it has one only
    bool is_practice = false;
    bool is_catch = false;
    std::uint64_t seed = 0; ///< key of everything random in it

    std::string level_name; ///< the variable under test, with its unit; empty: none
    std::optional<double> level;
    std::optional<int> target; ///< the alternative that is right, from 1; or 1 = yes, 0 = no
    /// The marked trial whose level is presented again.
    std::optional<TrialPlace> repetition_of;

    friend bool operator==(const PlannedTrial &, const PlannedTrial &) = default;
};

/// Filled from top to bottom: planned; presented; answered; stored, and marked if it does not
/// count.
struct Trial : PlannedTrial {
    Trial() = default;
    explicit Trial(PlannedTrial planned) : PlannedTrial(std::move(planned)) {}

    std::vector<Presentation> presentations;          ///< intended beside delivered
    std::vector<Setting> tuning;                      ///< in force in contact; no name twice
    std::vector<std::optional<double>> windings_degC; ///< by motor, at the end
    std::vector<SafetyEvent> safety_events; ///< one at least if the safety monitor tripped
    std::uint64_t missed_deadlines = 0;
    std::optional<RecordLink> record;

    Response response;
    std::optional<bool> is_correct;
    std::optional<double> response_time_s; ///< from the end of the last presentation

    std::string participant;
    SessionId session = 0;
    UtcTime at{}; ///< when it ended
    std::string software;
    std::vector<std::string> marks; ///< why it does not count; empty: it does
    /// It did not happen for the method, which presents its level again.
    bool is_presented_again = false;
    std::optional<TrialPlace> repeated_by; ///< as read; ignored by `append`

    friend bool operator==(const Trial &, const Trial &) = default;
};

/// What a participant answered to one question of the protocol, before or after the trials.
struct QuestionnaireAnswer {
    std::string participant;
    SessionId session = 0; ///< of that participant
    std::string item;      ///< its name in the protocol; a session has one answer to it
    std::string question;  ///< its text, as it was asked
    std::string answer;    ///< a number in digits, a choice as it was read, or free text
    UtcTime at{};

    friend bool operator==(const QuestionnaireAnswer &, const QuestionnaireAnswer &) = default;
};

/// The longest note or answer that is stored.
inline constexpr std::size_t kMaxBytesOfText = 10'000;

/// Something that happened outside a trial.
struct Note {
    UtcTime at{};
    std::string kind; ///< "note", "pause", "safety", ...
    std::string text;
    std::optional<std::string> participant; ///< nobody: about the study
    std::optional<SessionId> session;       ///< of that participant

    friend bool operator==(const Note &, const Note &) = default;
};

/// Everything in a study file, each list in the order in which it was stored.
struct StudyContents {
    StudyFacts facts;
    std::vector<Participant> participants;
    std::vector<Session> sessions;
    std::vector<Trial> trials;
    std::vector<QuestionnaireAnswer> answers;
    std::vector<Note> notes;
    /// Whose deletion was interrupted: nothing else of them is here.
    std::vector<std::string> unfinished_removals;

    friend bool operator==(const StudyContents &, const StudyContents &) = default;
};

/// One more than the highest number so far.
[[nodiscard]] int next_participant_number(const StudyContents &contents);

/// "has no participant 'P04'; springdrive study status lists them"
[[nodiscard]] std::string no_participant_text(std::string_view code);

/// @throw InputError if there is no such participant or session.
[[nodiscard]] const Participant &participant_of(const StudyContents &contents,
                                                std::string_view code);
[[nodiscard]] const Session &session_of(const StudyContents &contents, SessionId id);

/// The trials of one participant, in their order.
[[nodiscard]] std::vector<Trial> trials_of(const StudyContents &contents,
                                           std::string_view participant);

/// Trials of sessions on one kind of device, in their order. An analysis takes those of `usb`,
/// others only when asked for by name.
[[nodiscard]] std::vector<Trial> trials_on(const StudyContents &contents, DeviceKind device);

/// Whether the trial is one for the analysis: no practice, no catch trial, not marked.
[[nodiscard]] bool counts(const Trial &trial);

// What can be seen to be wrong with a row before it is stored. What leads to files is seen again
// when it is read: the file may come from anybody.

// Each is empty for a row that can be stored; one line otherwise.

/// The folder of servo records: NAME.records, beside the study.
[[nodiscard]] std::string validate_records_folder(std::string_view name);
[[nodiscard]] std::string validate(const Participant &participant);
[[nodiscard]] std::string validate(const Session &session);
/// @param records_folder  of the study
[[nodiscard]] std::string validate(const Trial &trial, std::string_view records_folder);
/// The trial's record, if it has one, which must be in its participant's folder.
[[nodiscard]] std::string validate_record(const Trial &trial, std::string_view records_folder);
[[nodiscard]] std::string validate(const QuestionnaireAnswer &answer);
[[nodiscard]] std::string validate(const Note &note);

} // namespace springdrive::study
