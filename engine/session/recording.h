// What of a servo's run is kept in files: one for each device that it ran on.
//
//   touch.rec ──another device──► touch-2.rec ──another device──► touch-3.rec
#pragma once

#include "engine/record/recorder.h"
#include "engine/session/servo_run.h"

#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

namespace springdrive::session {

/// Of one thread.
class Recording {
public:
    /// @param servo  must outlive it
    explicit Recording(ServoRun &servo);

    /// Records every tick from now on. One that runs is stopped first.
    /// @throw InputError for a file that cannot be made
    void start(const std::filesystem::path &file, const record::RecordHeader &header);
    void stop();

    /// In lockstep: writes what came since.
    void pump() { recorder_->pump(); }

    /// Something that happened between two ticks, as JSON text; nothing where nothing is recorded.
    void note(std::string_view json) { recorder_->note(json); }

    /// Ends the file that runs, if one does, with all ticks up to now, and lets go of the servo.
    /// @param last_note  JSON text
    void end_part(std::string_view last_note);

    /// Goes on after `ServoRun::renew`: in a further file if one was ended; returns its name then.
    /// @throw InputError for one that cannot be made; the recording has ended then
    std::filesystem::path begin_part(const record::RecordHeader &header);

    [[nodiscard]] bool is_running() const { return recorder_->is_recording(); }
    /// Of all parts of the recording that runs, or else of the last one.
    [[nodiscard]] record::RecorderStatus status() const;
    /// The file that is written to, or else the last one; empty when there was none.
    [[nodiscard]] std::filesystem::path file() const {
        return parts_.empty() ? std::filesystem::path() : parts_.back();
    }
    /// In the order in which they were written.
    [[nodiscard]] const std::vector<std::filesystem::path> &parts() const { return parts_; }

private:
    void begin(const std::filesystem::path &file, const record::RecordHeader &header);

    ServoRun &servo_;
    std::unique_ptr<record::Recorder> recorder_; ///< on the servo's ring
    std::vector<std::filesystem::path> parts_;
    record::RecorderStatus ended_; ///< sum of the parts before
    bool goes_on_ = false;         ///< between the end of a part and the next one's begin
};

/// "touch-2.rec" after "touch.rec".
[[nodiscard]] std::filesystem::path name_of_part(const std::filesystem::path &first,
                                                 std::size_t number);

} // namespace springdrive::session
