#include "app/panels/session_keeper.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/print.h"
#include "engine/record/record_file.h"
#include "engine/session/servo_run.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

namespace springdrive::app {

namespace {

servo::SafetyState state_at(const record::ChannelStore &store, std::uint64_t row) {
    static const std::size_t kState = session::channel_named("safety_state").value();
    return static_cast<servo::SafetyState>(static_cast<int>(store.value(kState, row)));
}

/// Where a recording ends by itself or is stopped, its last ticks may not be in its file: so many
/// are written again, which harms nothing.
constexpr std::uint64_t kOverlap = 2000;

std::chrono::sys_seconds now() {
    return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

} // namespace

void EventLog::add(double time_s, Kind kind, std::string what) {
    events_.push_back({time_s, kind, std::move(what)});
    if (events_.size() > kMaxEvents) {
        events_.pop_front();
    }
}

void EventLog::watch_safety(const session::Session &session) {
    const record::ChannelStore &store = session.servo().history().store();
    for (std::uint64_t row = std::max(next_row_, store.begin()); row < store.end(); ++row) {
        const servo::SafetyState now = state_at(store, row);
        const servo::SafetyState before = std::exchange(state_, now);
        if (now == before) {
            continue;
        }
        const double time_s = store.time_s(row);
        if (now == servo::SafetyState::tripped) {
            add(time_s, Kind::trip,
                "stopped: " + servo::description(session::sample_at(store, row).safety));
        } else if (before == servo::SafetyState::tripped) {
            add(time_s, Kind::note, "reset");
        } else if (now == servo::SafetyState::running) {
            add(time_s, Kind::note, "motors running");
        } else if (now == servo::SafetyState::releasing) {
            add(time_s, Kind::note, "releasing the device");
        }
    }
    next_row_ = store.end();
}

void EventLog::watch_tuning(const session::TuningHistory &tuning) {
    for (; journal_ < tuning.journal().size(); ++journal_) {
        const session::TuningEvent &event = tuning.journal()[journal_];
        add(event.time_s, Kind::change, event.what);
    }
}

/// Of a simulated device.
void EventLog::watch_plant(const session::Session &session, double now_s) {
    if (!session.device().has_world()) {
        plant_.reset();
        return;
    }
    const simulated::SimulationOptions &now = session.simulation();
    if (plant_ && plant_->delay_periods != now.delay_periods) {
        add(now_s, Kind::note, fmt::format("delay of {:g} periods", now.delay_periods));
    }
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        if (plant_ && plant_->effects.*effect.on != now.effects.*effect.on) {
            add(now_s, Kind::note,
                fmt::format("{} {}", effect.name, now.effects.*effect.on ? "on" : "off"));
        }
    }
    if (plant_ && plant_->hand_stiffness_N_per_m != now.hand.stiffness_N_per_m) {
        add(now_s, Kind::note, fmt::format("hand of {:.0f} N/m", now.hand.stiffness_N_per_m));
    }
    plant_ = Plant{now.delay_periods, now.effects, now.hand.stiffness_N_per_m};
    const bool follows = session.hand().follows_path();
    if (std::exchange(follows_path_, follows) != follows) {
        add(now_s, Kind::note, follows ? "the hand follows a path" : "the hand's path is over");
    }
}

void EventLog::watch_rest(const session::Session &session, double now_s) {
    const std::uint32_t scene_id = session.scenes().id();
    if (std::exchange(scene_id_, scene_id) != scene_id) {
        add(now_s, Kind::note, "scene " + session.scenes().now().scene.file.filename().string());
    }
    const std::string &device = session.description().name;
    if (std::exchange(device_, device) != device) {
        add(now_s, Kind::note, "device " + device);
    }
    const double rate_hz = session.servo().rate_hz();
    if (std::exchange(rate_hz_, rate_hz) != rate_hz) {
        add(now_s, Kind::note, fmt::format("servo at {:g} Hz", rate_hz));
    }
    const bool records = session.recording().is_running();
    const std::size_t parts = session.recording().parts().size();
    if (records && (!recording_ || parts != parts_)) {
        add(now_s, Kind::note, "recording to " + session.recording().file().string());
    } else if (!records && recording_) {
        add(now_s, Kind::note, "record ended");
    }
    recording_ = records;
    parts_ = parts;
    const auto &warnings = session.warnings().all();
    for (; warnings_ < warnings.size(); ++warnings_) {
        add(now_s, Kind::note, warnings[warnings_]);
    }
}

void EventLog::update(const session::Session &session) {
    const auto before = static_cast<std::ptrdiff_t>(events_.size());
    watch_safety(session);
    watch_tuning(session.tuning());
    const double now_s = session.plot_time_s();
    watch_plant(session, now_s);
    watch_rest(session, now_s);
    std::stable_sort(events_.begin() + std::min(before, std::ssize(events_)), events_.end(),
                     [](const Event &a, const Event &b) { return a.time_s < b.time_s; });
}

SessionKeeper::SessionKeeper(std::filesystem::path parent)
    : parent_(std::move(parent)), started_(now()) {}

void SessionKeeper::keep(session::Session &session, const EventLog &log) {
    error_.clear();
    try {
        std::error_code ignored;
        if (!folder_ || !std::filesystem::exists(folder_->path(), ignored)) {
            begin_folder(session);
        }
        record_from_now_on(session);
        write_uncovered(session);
        save(session, log);
        wants_picture_ = true;
    } catch (const InputError &error) {
        error_ = error.what();
        std::error_code ignored;
        if (folder_ && std::filesystem::remove(folder_->path(), ignored)) { // if it is empty
            folder_.reset();
        }
    }
}

/// The first one, or another one if that was deleted.
void SessionKeeper::begin_folder(session::Session &session) {
    if (folder_) {
        writing_.give_up();
        if (session.recording().file().parent_path() == folder_->path()) {
            session.recording().stop(); // into a file that is gone
        }
        folder_.reset();
    }
    records_.clear();
    being_written_.clear();
    pictures_.clear();
    covered_to_row_ = 0;
    was_recording_ = false;
    std::error_code ignored; // without the parent, the folder cannot be made, which is said
    std::filesystem::create_directories(parent_, ignored);
    folder_ = session::RunFolder::create(parent_);
}

/// "past.rec", "past-2.rec", ...
std::filesystem::path SessionKeeper::name_of_new(const std::string &stem) const {
    return unused_name(stem + ".rec", [this](const std::filesystem::path &name) {
        std::error_code ignored;
        return std::filesystem::exists(folder_->path() / name, ignored) ||
               std::ranges::find(being_written_, name, &Kept::file) != being_written_.end();
    });
}

/// Begun before the past is taken from memory: no tick is between them.
void SessionKeeper::record_from_now_on(session::Session &session) {
    if (!session.recording().is_running()) {
        note_end_of_recording();
        session.start_recording(folder_->path() / name_of_new("record"));
    }
    session.servo().take_in();
}

void SessionKeeper::write_uncovered(const session::Session &session) {
    take_written();
    if (writing_.is_busy()) {
        return; // what it writes ends where the recording began
    }
    if (was_recording_ && session.recording().is_running()) {
        note_recording(session);
    }
    const std::uint64_t begin = session.servo().history().store().begin();
    if (covered_to_row_ != 0 && covered_to_row_ < begin) {
        error_ = fmt::format("{}: {} ticks are in no record: they were no longer in memory",
                             folder_->path().string(), begin - covered_to_row_);
    }
    auto records = std::make_shared<std::vector<session::Record>>();
    for (session::Record &past : session.past()) {
        past.rows.from = std::max(past.rows.from, covered_to_row_);
        if (past.rows.from >= past.rows.to) {
            continue;
        }
        const std::filesystem::path name = name_of_new("past");
        being_written_.push_back({name, past.ran_on, past.start_s, past.rows.from});
        past.file = folder_->path() / name;
        records->push_back(std::move(past));
    }
    note_recording(session);
    if (!records->empty()) {
        writing_.start([records](BackgroundTalk &talk) {
            for (const session::Record &each : *records) {
                session::write_record(each.file, each, talk);
            }
            return true;
        });
    }
}

/// Of several that were to be written, all count or none: those after a failure are missing.
void SessionKeeper::take_written() {
    try {
        if (writing_.take()) {
            records_.insert(records_.end(), being_written_.begin(), being_written_.end());
            being_written_.clear();
        }
    } catch (const std::exception &error) {
        error_ = error.what();
        std::error_code ignored;
        for (const Kept &kept : std::exchange(being_written_, {})) {
            covered_to_row_ = std::min(covered_to_row_, kept.from_row);
            std::filesystem::remove(folder_->path() / kept.file, ignored);
        }
        was_recording_ = false; // what it records is written again
    }
}

/// What is recorded now, in this folder or elsewhere, is covered.
void SessionKeeper::note_recording(const session::Session &session) {
    const std::uint64_t end = session.servo().history().store().end();
    if (session.recording().is_running()) {
        std::filesystem::path file = session.recording().file();
        file = file.parent_path() == folder_->path() ? file.filename()
                                                     : std::filesystem::absolute(file);
        if (std::ranges::find(records_, file, &Kept::file) == records_.end()) {
            const std::vector<session::Record> past = session.past();
            if (past.empty() || past.back().start_s != session.servo().history().start_s()) {
                return; // there is no tick of this device yet
            }
            records_.push_back({file, past.back().ran_on, past.back().start_s, end});
        }
        covered_to_row_ = end;
        was_recording_ = true;
    } else {
        note_end_of_recording();
    }
}

void SessionKeeper::note_end_of_recording() {
    if (std::exchange(was_recording_, false)) {
        covered_to_row_ -= std::min(covered_to_row_, kOverlap);
    }
}

std::uint64_t SessionKeeper::bytes_to_write(const session::Session &session) const {
    static const record::RecordHeader layout = record::record_header(1000.0); // of any rate
    const record::ChannelStore &store = session.servo().history().store();
    const std::uint64_t from_row = std::clamp(covered_to_row_, store.begin(), store.end());
    return record::bytes_of_rows(store.end() - from_row, layout);
}

void SessionKeeper::update(const session::Session &session) {
    if (!folder_) {
        return;
    }
    take_written();
    if (!writing_.is_busy() && error_.empty()) {
        note_recording(session);
    }
    if (const std::string why = session.recording().status().error; !why.empty()) {
        error_ = why;
    }
}

session::RunFacts SessionKeeper::facts(const session::Session &session, const EventLog &log) const {
    session::RunFacts facts;
    facts.software = session.program_version();
    facts.started = started_;
    facts.kept = now();
    facts.until_s = session.plot_time_s();
    facts.servo_hz = session.servo().rate_hz();
    facts.delay_periods = session.device().device().delay_periods();
    const session::LoadedScene &scene = session.scenes().now();
    facts.scene = {scene.scene.file.string(), scene.sha256, scene.scene.surface.triangles.size()};
    facts.slots = session.tuning().slots();
    const auto &journal = session.tuning().journal();
    facts.journal.assign(journal.begin(), journal.end());
    for (const EventLog::Event &event : log.events()) {
        facts.events.push_back({event.time_s, event.what});
    }
    facts.notes = notes;
    facts.screenshots = pictures_;

    std::vector<Kept> records = records_;
    records.insert(records.end(), being_written_.begin(), being_written_.end());
    std::ranges::stable_sort(records, {}, &Kept::from_row);
    const std::vector<session::Record> past = session.past();
    std::vector<double> began_s; // of each device: no two begin at the same time
    for (const Kept &kept : records) {
        if (began_s.empty() || began_s.back() != kept.start_s) {
            began_s.push_back(kept.start_s);
            facts.devices.push_back(kept.device);
        }
        facts.records.push_back({kept.file, kept.start_s, facts.devices.size() - 1});
    }
    if (!past.empty() && !began_s.empty() && began_s.back() == past.back().start_s) {
        facts.devices.back() = past.back().ran_on; // as it is now
    }
    return facts;
}

void SessionKeeper::save(const session::Session &session, const EventLog &log) {
    folder_->save(facts(session, log));
}

void SessionKeeper::finish(session::Session &session, const EventLog &log) {
    if (!folder_ && notes.empty()) {
        return;
    }
    error_.clear();
    try {
        if (!folder_) {
            begin_folder(session);
        }
        wait_for_writing();
        if (was_recording_ && session.recording().status().error.empty()) {
            covered_to_row_ = session.servo().history().store().end(); // it ended with the session
            was_recording_ = false;
        }
        note_end_of_recording();
        write_uncovered(session);
        wait_for_writing();
        save(session, log);
    } catch (const InputError &error) {
        error_ = error.what();
    }
}

void SessionKeeper::wait_for_writing() {
    while (writing_.is_busy()) {
        take_written();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
}

std::optional<std::filesystem::path> SessionKeeper::take_picture() {
    if (!std::exchange(wants_picture_, false) || !folder_) {
        return std::nullopt;
    }
    return folder_->next_screenshot();
}

void SessionKeeper::note_picture(const std::filesystem::path &file, const session::Session &session,
                                 const EventLog &log) {
    pictures_.push_back(file.filename());
    save(session, log);
}

} // namespace springdrive::app
