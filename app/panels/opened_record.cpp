#include "app/panels/opened_record.h"

#include "base/input_error.h"

#include <exception>
#include <system_error>
#include <utility>

namespace springdrive::app {

void OpenedRecord::open(const std::filesystem::path &path) {
    error_.clear();
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) {
        load(path, std::nullopt);
        return;
    }
    try {
        Run run{path, session::read_run(path)};
        if (run.facts.records.empty()) {
            throw InputError(path.string() + ": has no records");
        }
        const std::filesystem::path file = path / run.facts.records.front().file;
        load(file, std::move(run));
    } catch (const std::exception &error) { // also of a folder that is too large for memory
        error_ = error.what();
    }
}

void OpenedRecord::open_part(std::size_t part) {
    Run run = run_.value();
    run.part = part;
    const std::filesystem::path file = run.folder / run.facts.records.at(part).file;
    load(file, std::move(run));
}

void OpenedRecord::open_from(double from_s) { load(playback_.record().file, run_, from_s); }

void OpenedRecord::load(const std::filesystem::path &file, std::optional<Run> run, double from_s) {
    error_.clear();
    run_of_next_ = std::move(run);
    loads_ = true;
    playback_.open(file, from_s);
}

void OpenedRecord::close() {
    playback_.close();
    run_.reset();
    loads_ = false;
    asks = false;
    error_.clear();
    behind_.reset();
    behind_of_ = nullptr;
}

void OpenedRecord::update(double frame_s, const control::Tuning &tuning) {
    playback_.advance(frame_s);
    if (loads_ && !playback_.is_loading()) {
        loads_ = false;
        if (playback_.error().empty()) { // what was open before stays otherwise
            run_ = std::exchange(run_of_next_, {});
            view = RecordView::instead_of;
            ++number_;
        }
    }
    if (!playback_.is_open()) {
        return;
    }
    if (asks) {
        playback_.ask(tuning);
    } else if (playback_.asked()) {
        playback_.stop_asking();
    }
    renew_behind();
}

/// Behind the record is the answer, behind the present the record.
void OpenedRecord::renew_behind() {
    const bool of_record = view == RecordView::behind;
    const record::ChannelStore *const wanted = of_record ? &playback_.store() : playback_.answer();
    if (wanted == nullptr) {
        behind_.reset();
    } else if (!behind_ || behind_of_ != wanted) {
        behind_ = PlotTrace{*wanted, {}, {}};
    }
    behind_of_ = wanted;
    if (behind_) {
        behind_->name = of_record ? playback_.record().file.filename().string()
                        : playback_.is_answer_current() ? "with the active tuning"
                                                        : "with the tuning before it";
        behind_->window = {playback_.position_s(), playback_.position_s()};
    }
}

PlotSubject OpenedRecord::subject(const session::Session &session) const {
    const session::TelemetryHistory &present = session.servo().history();
    const PlotTrace *const behind =
        behind_ && playback_.is_open() && view != RecordView::present ? &*behind_ : nullptr;
    if (is_shown()) {
        return {playback_.store(), playback_.record().header.servo_hz, playback_.position_s(),
                behind, number_};
    }
    return {present.store(), present.servo_hz(), std::nullopt, behind};
}

} // namespace springdrive::app
