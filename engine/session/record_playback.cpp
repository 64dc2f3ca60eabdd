#include "engine/session/record_playback.h"

#include "base/assertions.h"
#include "base/cancellation.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace springdrive::session {

namespace {

/// A tenth of a second's work, so that answers follow a slider: 20 s at 1 kHz.
constexpr std::uint64_t kRowsAnsweredFirst = 20'000;

} // namespace

void RecordPlayback::open(const std::filesystem::path &file, double from_s) {
    error_.clear();
    loading_.start([file, from_s](BackgroundTalk &talk) {
        return std::make_shared<const Record>(load_record(file, from_s, kMaxBytes, talk));
    });
}

void RecordPlayback::close() {
    loading_.give_up();
    drop_record();
    error_.clear();
    is_playing_ = false;
    position_s_ = 0.0;
}

const Record &RecordPlayback::record() const {
    SPRINGDRIVE_ASSERT(record_ != nullptr);
    return *record_;
}

RunScene RecordPlayback::scene() const {
    const auto noted = scenes_.find(sample().scene_id);
    return noted != scenes_.end()
               ? noted->second
               : RunScene{record().header.scene_file, record().header.scene_sha256};
}

void RecordPlayback::seek(double time_s) {
    if (is_open() && !std::isnan(time_s)) {
        const RowTimes times = record_->times();
        position_s_ = std::clamp(time_s, times.first_s, times.last_s);
    }
}

void RecordPlayback::step(int rows) {
    is_playing_ = false;
    if (!is_open()) {
        return;
    }
    const record::ChannelStore &store = record_->store;
    const std::uint64_t now = row();
    const std::uint64_t back = rows < 0 ? static_cast<std::uint64_t>(-std::int64_t{rows}) : 0;
    const std::uint64_t on = rows > 0 ? static_cast<std::uint64_t>(rows) : 0;
    const std::uint64_t then = now - std::min(back, now - store.begin());
    position_s_ = store.time_s(std::min(then + on, store.end() - 1));
}

void RecordPlayback::set_speed(double speed) {
    if (std::isfinite(speed)) {
        speed_ = std::clamp(speed, -kMaxSpeed, kMaxSpeed);
    }
}

void RecordPlayback::play(bool on) {
    is_playing_ = on && is_open();
    if (!is_playing_) {
        return;
    }
    const RowTimes times = record_->times();
    if (speed_ > 0.0 && position_s_ >= times.last_s) {
        position_s_ = times.first_s;
    } else if (speed_ < 0.0 && position_s_ <= times.first_s) {
        position_s_ = times.last_s;
    }
}

void RecordPlayback::advance(double frame_s) {
    take_record();
    move(frame_s);
    take_answer();
    go_on_answering();
}

void RecordPlayback::take_record() {
    try {
        if (std::optional<SharedRecord> loaded = loading_.take()) {
            drop_record();
            record_ = std::move(*loaded);
            position_s_ = record_->times().first_s;
            scenes_ = noted_scenes(*record_);
            is_playing_ = false;
        }
    } catch (const std::exception &error) {
        error_ = error.what();
    }
}

void RecordPlayback::move(double frame_s) {
    if (!is_playing_ || !std::isfinite(frame_s)) {
        return;
    }
    seek(position_s_ + speed_ * frame_s);
    const RowTimes times = record_->times();
    const bool is_at_end =
        speed_ > 0.0 ? position_s_ >= times.last_s : speed_ < 0.0 && position_s_ <= times.first_s;
    is_playing_ = !is_at_end;
}

/// Whoever drops the last reference to a record waits until its memory is returned.
void RecordPlayback::drop_record() {
    answering_.give_up();
    drop_answer();
    failed_.reset();
    if (record_) {
        release_record_.let_go(std::make_unique<SharedRecord>(std::move(record_)));
        record_.reset();
    }
}

void RecordPlayback::drop_answer() {
    if (answer_) {
        release_answer_.let_go(std::move(answer_));
    }
}

void RecordPlayback::ask(const control::Tuning &tuning) {
    if (asked_ == tuning || !control::is_valid(tuning)) {
        return;
    }
    stop_reporting_failure();
    asked_ = tuning;
    if (running_completes_) {
        answering_.ask_to_end();
    }
    go_on_answering();
}

void RecordPlayback::stop_asking() {
    stop_reporting_failure();
    asked_.reset();
    answering_.give_up();
    drop_answer();
}

void RecordPlayback::stop_reporting_failure() {
    if (failed_) {
        failed_.reset();
        error_.clear();
    }
}

void RecordPlayback::take_answer() {
    try {
        if (std::optional<std::unique_ptr<Answer>> found = answering_.take()) {
            drop_answer();
            answer_ = std::move(*found);
        }
    } catch (const Cancelled &) { // for a newer question
    } catch (const std::exception &error) {
        failed_ = running_tuning_;
        error_ = std::string("the record cannot be computed with this tuning: ") + error.what();
    }
}

RowRange RecordPlayback::rows_to_answer_first() const {
    const record::ChannelStore &store = record_->store;
    const std::uint64_t here = row();
    const std::uint64_t before = std::min(kRowsAnsweredFirst / 2, here - store.begin());
    const std::uint64_t from = here - before;
    return {from, std::min(store.end(), from + kRowsAnsweredFirst)};
}

/// Starts the next computation, if one is missing.
void RecordPlayback::go_on_answering() {
    if (!is_open() || !asked_ || asked_ == failed_ || answering_.is_busy()) {
        return;
    }
    const bool has_begun = answer_ && answer_->tuning == *asked_;
    if (has_begun && answer_->is_complete) {
        return;
    }
    const RowRange all = record_->rows;
    const RowRange rows = has_begun ? all : rows_to_answer_first();
    running_tuning_ = *asked_;
    running_completes_ = has_begun;
    const bool is_complete = rows.from == all.from && rows.to == all.to;
    answering_.start([record = record_, tuning = *asked_, rows, is_complete](BackgroundTalk &) {
        return std::make_unique<Answer>(
            Answer{tuning, is_complete, rows, what_if(*record, tuning, rows)});
    });
}

std::optional<servo::ServoSample> RecordPlayback::answered_sample() const {
    if (!answer_) {
        return std::nullopt;
    }
    const std::uint64_t shown = row();
    if (shown < answer_->rows.from || shown >= answer_->rows.to) {
        return std::nullopt;
    }
    return sample_at(answer_->store, answer_->store.begin() + (shown - answer_->rows.from));
}

} // namespace springdrive::session
