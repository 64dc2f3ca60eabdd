#include "engine/session/recording.h"

#include "base/input_error.h"
#include "base/new_file.h"

#include <utility>

namespace springdrive::session {

namespace {

/// The sum of two consecutive parts.
record::RecorderStatus sum(const record::RecorderStatus &first,
                           const record::RecorderStatus &second) {
    return {first.rows + second.rows, first.bytes + second.bytes, first.lost + second.lost,
            first.error.empty() ? second.error : first.error};
}

} // namespace

Recording::Recording(ServoRun &servo) : servo_(servo) {}

void Recording::begin(const std::filesystem::path &file, const record::RecordHeader &header,
                      FilePolicy policy) {
    if (!recorder_) {
        recorder_ = std::make_unique<record::Recorder>(servo_.servo().record_ring());
    }
    recorder_->start(file, header,
                     servo_.is_in_lockstep() ? record::Recorder::Mode::pumped
                                             : record::Recorder::Mode::own_thread,
                     policy);
    servo_.servo().feed_recorder(true);
}

void Recording::start(const std::filesystem::path &file, const record::RecordHeader &header,
                      FilePolicy policy) {
    begin(file, header, policy);
    parts_ = {file};
    readers_ = policy.readers;
    ended_ = {};
}

void Recording::stop() {
    servo_.servo().feed_recorder(false);
    if (recorder_) {
        recorder_->stop();
    }
}

void Recording::end_part(std::string_view last_note) {
    goes_on_ = is_running();
    servo_.servo().feed_recorder(false);
    if (recorder_) {
        recorder_->stop(last_note);
        ended_ = sum(ended_, recorder_->status());
        recorder_.reset();
    }
}

std::filesystem::path Recording::begin_part(const record::RecordHeader &header) {
    if (!std::exchange(goes_on_, false)) {
        return {};
    }
    // What exists from an earlier recording is not overwritten.
    std::filesystem::path file = unused_name(parts_.front(), parts_.size() + 1);
    try {
        begin(file, header, {Existing::keep, readers_});
    } catch (const InputError &error) {
        ended_.error = error.what();
        throw;
    }
    parts_.push_back(file);
    return file;
}

record::RecorderStatus Recording::status() const {
    return recorder_ ? sum(ended_, recorder_->status()) : ended_;
}

} // namespace springdrive::session
