#include "engine/record/recorder.h"

#include "base/input_error.h"

#include <algorithm>
#include <utility>

namespace springdrive::record {

namespace {

constexpr std::chrono::milliseconds kBetweenDrains{10};
constexpr std::chrono::milliseconds kOldestRow{30};

} // namespace

Recorder::~Recorder() { stop(); }

void Recorder::start(const std::filesystem::path &path, const RecordHeader &header, Mode mode,
                     FilePolicy policy) {
    stop();
    writer_ = std::make_unique<RecordWriter>(path, header, policy);
    mode_ = mode;
    ring_.drain([](const servo::ServoSample &) {});
    lost_before_ = ring_.lost();
    gaps_ = 0;
    last_tick_.reset();
    {
        const std::scoped_lock lock(mutex_);
        is_stopping_ = false;
        notes_.clear();
        status_ = {};
        is_recording_ = true;
    }
    publish_status();
    if (mode == Mode::own_thread) {
        thread_ = std::thread([this] { run(); });
    }
}

void Recorder::stop(std::string_view last_note) {
    if (thread_.joinable()) {
        {
            const std::scoped_lock lock(mutex_);
            is_stopping_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    if (!writer_) {
        return;
    }
    drain();
    guarded([&] {
        if (!last_note.empty()) {
            writer_->note(last_note);
        }
        writer_->close();
    });
    publish_status();
    writer_.reset();
    const std::scoped_lock lock(mutex_);
    is_recording_ = false;
}

void Recorder::pump() {
    if (writer_ && mode_ == Mode::pumped) {
        drain();
        publish_status();
    }
}

void Recorder::note(std::string_view json) {
    if (json.size() > RecordWriter::kMaxNote) {
        throw InputError("a note of " + std::to_string(json.size()) +
                         " bytes is too long; notes have up to 1048576");
    }
    const std::scoped_lock lock(mutex_);
    if (is_recording_) {
        notes_.emplace_back(json);
    }
}

bool Recorder::is_recording() const {
    const std::scoped_lock lock(mutex_);
    return is_recording_;
}

RecorderStatus Recorder::status() const {
    const std::scoped_lock lock(mutex_);
    return status_;
}

void Recorder::run() {
    for (;;) {
        drain();
        flush_what_is_old();
        publish_status();
        std::unique_lock lock(mutex_);
        if (wake_.wait_for(lock, kBetweenDrains, [this] { return is_stopping_; })) {
            return; // `stop` drains the rest
        }
    }
}

void Recorder::drain() {
    ring_.drain([this](const servo::ServoSample &sample) { take(sample); });
    write_notes();
}

void Recorder::take(const servo::ServoSample &sample) {
    if (!writer_->is_open()) {
        return; // the disk is full; the servo is not affected
    }
    if (last_tick_ && sample.tick > *last_tick_) {
        gaps_ += sample.tick - *last_tick_ - 1;
    }
    last_tick_ = sample.tick;
    if (writer_->rows_waiting() == 0) {
        waiting_since_ = Clock::now();
    }
    guarded([&] { writer_->write(sample); });
}

void Recorder::write_notes() {
    std::vector<std::string> notes;
    {
        const std::scoped_lock lock(mutex_);
        notes.swap(notes_);
    }
    for (const std::string &text : notes) {
        guarded([&] { writer_->note(text); });
    }
}

/// For a paused servo; a running one fills its chunks in 20 ms.
void Recorder::flush_what_is_old() {
    if (writer_->rows_waiting() > 0 && Clock::now() - waiting_since_ >= kOldestRow) {
        guarded([&] { writer_->flush(); });
    }
}

void Recorder::publish_status() {
    // Samples lost by the ring also show as a gap in the ticks, but only after a later sample.
    const std::uint64_t lost = std::max(gaps_, ring_.lost() - lost_before_);
    const std::scoped_lock lock(mutex_);
    status_.rows = writer_->rows_in_file();
    status_.bytes = writer_->bytes_in_file();
    status_.lost = lost;
}

/// Calls the writer, and stores its error message.
template <typename Step> void Recorder::guarded(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        const std::scoped_lock lock(mutex_);
        status_.error = error.what();
        if (!writer_->is_open()) {
            is_recording_ = false;
        }
    }
}

} // namespace springdrive::record
