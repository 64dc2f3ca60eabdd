// A study on disk: one SQLite file.
//
// Each call that writes is one transaction, which is on the disk when the call returns: it survives
// a killed program and a loss of power. See docs/study_store.md.
//
// Errors are InputErrors of one line. After one, the file holds what it held before, or the whole
// of what was to be written (where the disk failed in the act); the same call may be repeated.
#pragma once

#include "engine/study/store/study_contents.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::study {

struct DatabaseSettings; ///< engine/study/store/database.h: other than the default only in tests

struct NewStudy {
    std::string title;
    std::string protocol; ///< complete text of the protocol file
    std::string software; ///< version of the program
};

/// Creates a study file. It appears under its name when it is complete and on the disk.
/// @throw InputError if a file of that name exists, or it cannot be written.
void create_study(const std::filesystem::path &file, const NewStudy &study, UtcTime now);

/// Reads all of a study file, also beside a program that writes to it, and checks it on the way:
/// structure, relations and the SHA-256 of each row. The file is closed again.
/// @throw InputError for a file that is no study, of another version, damaged, or left in the
///        midst of a write where it cannot be repaired because it is write-protected.
[[nodiscard]] StudyContents read_study(const std::filesystem::path &file);

enum class Appended : std::uint8_t {
    now,
    before, ///< the same one was there already
};

/// What a deletion did beyond the participant's own data.
struct Removed {
    /// Notes, answers and trials' marks of others and of the study, in which the code was replaced.
    int redacted = 0;
    /// The study's own title, protocol or name has the code, and is as it was.
    bool is_in_study = false;
};

/// A study file opened for writing, by one program at a time. For one thread.
class StudyStore {
public:
    /// Opens an existing file: checks it as `read_study` does, closes sessions that were
    /// interrupted. A deletion that was is not completed, but told by
    /// `contents().unfinished_removals`: it would remove files that nobody named.
    /// @throw InputError as `read_study` does; also if the file or its folder is write-protected,
    ///        or another program has it open for writing, naming that.
    explicit StudyStore(const std::filesystem::path &file);
    StudyStore(const std::filesystem::path &file, const DatabaseSettings &settings);
    /// A study of no file, for what must not be kept: all of it is gone with the object. It takes
    /// no servo records.
    /// @param study  as for `create_study`
    [[nodiscard]] static StudyStore in_memory(const NewStudy &study, UtcTime now);
    ~StudyStore();
    StudyStore(StudyStore &&) noexcept;
    StudyStore &operator=(StudyStore &&) noexcept;

    [[nodiscard]] const std::filesystem::path &file() const; ///< empty: in memory

    /// All that is stored; to resume, among others.
    [[nodiscard]] StudyContents contents() const;

    /// @throw InputError for what is no code, for a code or number that is taken, and for a code
    ///        that is another's but for zeros.
    void add(const Participant &participant);

    /// Begins a session; its `id`, `ended` and `ending` are ignored.
    /// @throw InputError if its participant is unknown.
    [[nodiscard]] SessionId begin(const Session &session);

    /// @throw InputError if there is no such session, or it has ended.
    void end(SessionId session, SessionEnding ending, UtcTime at);

    /// Stores a trial. A trial of the same participant and place can be there already, if the
    /// program ended after the commit and before it took note of it: the same one is not stored
    /// again.
    /// @throw InputError if another trial has its place; if participant, session or the repeated
    ///        trial are unknown or another participant's; for a name that is empty or there twice;
    ///        for a record outside its participant's folder.
    Appended append(const Trial &trial);

    /// Stores an answer; what is asked, and which answers are possible, is for the caller to check.
    /// The same answer again, in that session, is not stored twice.
    /// @throw InputError if the session has another answer to the item; if participant or session
    ///        are unknown or another participant's; for what is no name, and without a question.
    Appended add(const QuestionnaireAnswer &answer);

    void append(const Note &note);

    /// Deletes a participant: servo records, then all rows, which are overwritten with zeros; the
    /// code in texts of others and of the study is replaced, and the file rebuilt. The same call
    /// completes a deletion that was interrupted; until then the participant's trials are not
    /// shown.
    /// @throw InputError if there is no such participant, a record cannot be deleted, their folder
    /// is
    ///        reached by a link only, or the study is in memory.
    Removed remove_participant(std::string_view code);

    /// Where the servo record of a trial is to be written, in its participant's folder, which is
    /// created: "STUDY.records/P01/block1-position017-attempt1.rec".
    /// @throw InputError of a study in memory, or if the folder cannot be made
    [[nodiscard]] std::filesystem::path new_record_file(std::string_view participant,
                                                        const TrialPlace &place) const;

    /// The link to a complete record, which is on the disk afterwards.
    /// @throw InputError if it cannot be read or is not in the study's folder of records.
    [[nodiscard]] RecordLink link_to(const std::filesystem::path &record) const;

private:
    struct Parts;
    explicit StudyStore(std::unique_ptr<Parts> parts);

    std::unique_ptr<Parts> parts_;
};

/// Files that may stand beside a study while it is open, or after a program was killed: its lock
/// and journals. Nobody else may write to them.
[[nodiscard]] std::vector<std::filesystem::path> files_beside(const std::filesystem::path &file);

/// What is wrong with the servo records of a study, a line for each: missing, or not the file that
/// was linked. Reads them all.
[[nodiscard]] std::vector<std::string> validate_records(const std::filesystem::path &file,
                                                        const StudyContents &contents);

} // namespace springdrive::study
