// Records a servo's run, in one file per device that it ran on.
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

/// For use by one thread.
class Recording {
public:
    /// @param servo  must outlive it
    explicit Recording(ServoRun &servo);

    /// Records every tick from now on. A running recording is stopped first.
    /// @param policy  whether a file of that name is replaced; further parts replace none
    /// @throw InputError if the file cannot be created
    void start(const std::filesystem::path &file, const record::RecordHeader &header,
               FilePolicy policy = Existing::keep);
    void stop();

    /// In lockstep: writes the new samples.
    void pump() {
        if (recorder_) {
            recorder_->pump();
        }
    }

    /// Records an event between two ticks, as JSON text; does nothing while not recording.
    void note(std::string_view json) {
        if (recorder_) {
            recorder_->note(json);
        }
    }

    /// Ends the current file, if any, with all ticks up to now, and detaches from the servo.
    /// @param last_note  JSON text
    void end_part(std::string_view last_note);

    /// Continues after `ServoRun::renew`: if a file was ended, starts a new one and returns its
    /// name.
    /// @throw InputError if the file cannot be created; the recording has then ended
    std::filesystem::path begin_part(const record::RecordHeader &header);

    [[nodiscard]] bool is_running() const { return recorder_ && recorder_->is_recording(); }
    /// The status of all parts of the current recording, or else of the last one.
    [[nodiscard]] record::RecorderStatus status() const;
    /// The current file, or else the last one; empty if there was none.
    [[nodiscard]] std::filesystem::path file() const {
        return parts_.empty() ? std::filesystem::path() : parts_.back();
    }
    /// All files, in the order in which they were written.
    [[nodiscard]] const std::vector<std::filesystem::path> &parts() const { return parts_; }

private:
    void begin(const std::filesystem::path &file, const record::RecordHeader &header,
               FilePolicy policy);

    ServoRun &servo_;
    std::unique_ptr<record::Recorder> recorder_; ///< on the servo's ring; null before the first
    std::vector<std::filesystem::path> parts_;
    Readers readers_ = Readers::all; ///< of the parts
    record::RecorderStatus ended_;   ///< sum of the previous parts
    bool goes_on_ = false;           ///< between the end of a part and the start of the next
};

} // namespace springdrive::session
