#include "engine/session/session.h"

#include "device/core/device_file.h"
#include "engine/control/motion_control.h"
#include "engine/servo/real_time.h"
#include "engine/session/session_parts.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace springdrive::session {

namespace {

/// Longest pause of a simulated device that causes no warning.
constexpr double kReportedStall_s = 0.05;

} // namespace

Session::Session(const SessionOptions &options, scene::LoadProgress *progress) : options_(options) {
    if (options.cpu) {
        servo::check_cpu(*options.cpu);
        servo::keep_off_cpu(
            *options.cpu); // window, recorder and loader; the servo's thread runs there
    }
    static_cast<void>(servo::servo_period_s(options.servo_hz));
    const std::string text = text_of_device(options.device.file);
    const device::DeviceDescription description =
        device::read_device_text(text, options.device.file);
    models_ = std::make_unique<SceneModels>(options.model, options.tuning,
                                            ground(text, description, options.servo_hz));
    scene::LoadProgress unwatched;
    scene::LoadProgress &watched = progress != nullptr ? *progress : unwatched;
    BackgroundTalk without_hand;
    std::unique_ptr<LoadedScene> scene =
        load_scene(options.scene, description.workspace, watched, options.gltf_scene);
    models_->finish(options.tuning)(*scene, watched, without_hand);
    models_->note_shown(*scene);
    scenes_ = std::make_unique<Scenes>(description.workspace, std::move(scene));

    control::Tuning tuning = options.tuning;
    Prepared first = prepare(options.device, text, tuning);
    simulation_ = first.request.simulation;
    if (first.text != text) {
        models_->set_ground(ground(first.text, first.request.description, options.servo_hz));
    }
    device_ = std::make_unique<factory::OpenDevice>(std::move(first.device));
    servo_ = std::make_unique<ServoRun>(
        device_->device(),
        ServoOptions{options.servo_hz, options.lockstep, options.cpu, options.history_bytes});
    recording_ = std::make_unique<Recording>(*servo_);
    hand_.take_hold(device_->hand(), description, simulation_.path, first.request.start_tip_m);
    servo_->set_global_alpha(control::global_alpha_bound(description));
    if (options.late_limit_s) {
        servo::SafetyLimits limits = servo::unlowered();
        limits.late_s = *options.late_limit_s;
        servo_->lower_limits(limits);
    }
    observe_as_requested();
    servo_->touch(scenes_->now().surface, scenes_->id(), tuning);
    tuning_ = std::make_unique<TuningHistory>(
        tuning, 0.0, [this](const control::Tuning &active) { servo_->tune(active); });
    begin_past();
}

Session::~Session() { end_exclusive_use(); }

void Session::start(const std::function<void()> &on_thread) {
    if (!options_.record.empty()) {
        start_recording(options_.record, options_.existing_record);
    }
    past_.clear();
    begin_past();
    has_started_ = true;
    on_thread_ = on_thread;
    if (options_.starts_at_zero && !is_zeroed()) {
        zero_device(Vector3::Zero());
    }
    if (!is_zeroed()) {
        warnings_.add(
            "no motor is driven until the device has been zeroed; in the window see Plant, "
            "or start with --at-zero");
    }
    move_emulated();
    release_until_zeroed();
    start_watching_windings();
    start_servo();
}

void Session::start_servo() {
    for (const std::string &refused : servo_->start(on_thread_)) {
        warnings_.add(refused);
    }
    if (const auto link = device_->device().link(); link && !link->warning.empty()) {
        warnings_.add(link->warning);
    }
}

void Session::advance(double frame_s) {
    servo_->advance(frame_s);
    go_on_with_exclusive_use(frame_s);
    recording_->pump();
    hand_.advance(latest().time_s);
    forget_old_past();
    scenes_->note_in_use(latest().scene_id);
    note_stall();
    note_failed_assertion();
    watch_zero();
    watch_link();
    if (const LoadedScene *const before = scenes_->take_loaded()) {
        show(*before);
    }
    models_->update();
    go_on_with_exchange();
}

void Session::stop() {
    end_exclusive_use();
    servo_->stop();
    keep_windings();
    note_failed_assertion();
    recording_->stop();
}

double Session::plot_time_s() const {
    const record::ChannelStore &store = servo_->history().store();
    return store.is_empty() ? 0.0 : store.time_s(store.end() - 1);
}

void Session::note_stall() {
    const double longest_s = servo_->stalls().longest_s;
    if (!reported_stall_ && longest_s > kReportedStall_s) {
        reported_stall_ = true;
        warnings_.add("this computer was busy for " + std::to_string(std::lround(1e3 * longest_s)) +
                      " ms; the simulation waited");
    }
}

record::RecordHeader Session::header_of_record() const {
    const LoadedScene &scene = scenes_->now();
    record::RecordHeader header = record::record_header(servo_->rate_hz());
    header.software = options_.program_version;
    header.delay_periods = device_->device().delay_periods();
    header.device_name = description().name;
    header.device_file = options_.device.file.string();
    header.device_toml = models_->ground().memory.device_text;
    header.tuning = tuning_->now();
    header.scene_file = scene.scene.file.string();
    header.scene_sha256 = scene.sha256;
    header.scene_triangles = scene.scene.surface.triangles.size();
    header.global_alpha_rad2_per_m2 = servo_->inputs().global_alpha_rad2_per_m2;
    return header;
}

void Session::start_recording(const std::filesystem::path &file, FilePolicy policy) {
    recording_->start(file, header_of_record(), policy);
    reported_failure_ = false; // noted in each record
}

/// Of all that is recorded of the present device.
void Session::note(std::string json) {
    recording_->note(json);
    past_.back().ran_on = device_of_run();
    past_.back().notes.push_back(
        {servo_->history().store().end(), std::move(json),
         std::make_shared<const record::RecordHeader>(header_of_record())});
}

void Session::begin_past() {
    past_.push_back({header_of_record(), models_->ground().device});
    Record &record = past_.back();
    record.rows.from = servo_->history().store().end();
    record.start_s = servo_->history().start_s();
    record.ran_on = device_of_run();
}

RunDevice Session::device_of_run() const {
    return {description().name,
            options_.device.file.string(),
            models_->ground().memory.device_text,
            simulation_.device_seed,
            simulation_.effects,
            options_.observes_resistance};
}

void Session::forget_old_past() {
    const std::uint64_t begin = servo_->history().store().begin();
    while (past_.size() > 1 && past_[1].rows.from <= begin) {
        past_.pop_front();
    }
    past_.front().drop_before(begin);
}

std::vector<Record> Session::past() const {
    const record::ChannelStore &store = servo_->history().store();
    std::vector<Record> records;
    for (std::size_t i = 0; i < past_.size(); ++i) {
        Record record = past_[i];
        record.rows.to = i + 1 < past_.size() ? past_[i + 1].rows.from : store.end();
        record.drop_before(store.begin());
        if (record.rows.from < record.rows.to) {
            record.store = store;
            records.push_back(std::move(record));
        }
    }
    return records;
}

void Session::request_scene(const std::filesystem::path &file) {
    scenes_->request(file, file == options_.scene ? options_.gltf_scene : std::string(),
                     models_->finish(tuning_->now()));
}

void Session::choose_models() {
    models_->choose_automatically();
    request_scene(scenes_->now().scene.file);
}

/// Under changed conditions the running model was not measured: chooses it again.
void Session::choose_again() {
    if (models_->is_automatic()) {
        request_scene(scenes_->now().scene.file);
    }
}

void Session::measure_model(bool fresh) {
    models_->measure(scenes_->now().scene, tuning_->now(), fresh);
}

void Session::show(const LoadedScene &before) {
    const LoadedScene &now = scenes_->now();
    control::Tuning tuning = tuning_->now();
    models_->note_shown(now);
    models_->apply_to(now, before.choice, simulation_.planar, simulation_, tuning);
    if (now.choice && device_->has_world()) {
        world().simulate_as(simulation_);
    }
    observe_as_requested();
    servo_->touch(now.surface, scenes_->id(), tuning); // both with the same tick
    if (tuning != tuning_->now()) {
        tuning_->replace(tuning, plot_time_s(), "by the scene's model");
    }
    note(note_on_scene(scenes_->id(), now));
    if (next_device_) {
        prepare_again(); // to start above this scene, not the previous one
    }
}

void Session::observe_resistance(bool on) {
    options_.observes_resistance = on;
    observe_as_requested();
    past_.back().ran_on = device_of_run();
}

void Session::observe_as_requested() {
    const bool has_inductance = !device_->has_world() ||
                                simulation_.dynamics == simulated::PlantDynamics::electromechanical;
    servo_->observe_resistance(options_.observes_resistance, has_inductance);
}

void Session::set_servo_rate(double servo_hz) {
    require_no_exclusive_use();
    const double before_hz = servo_->rate_hz();
    const double period_s = servo::servo_period_s(servo_hz);
    if (next_device_) {
        next_device_->device.device().set_period(period_s);
        next_device_->request.simulation.servo_period_s = period_s;
    }
    servo_->paused([&] {
        const std::uint64_t from_tick = servo_->set_rate(servo_hz);
        note(dump({{"servo_hz", servo_hz}, {"from_tick", from_tick}}));
    });
    if (servo_hz == before_hz) {
        return;
    }
    simulation_.servo_period_s = period_s;
    measure_anew();
}

/// Of this device, after a change of rate or delay: what was measured of models holds no more.
void Session::measure_anew() {
    const ModelGround &old = models_->ground();
    models_->set_ground(ground(old.memory.device_text, old.device, servo_->rate_hz()));
    choose_again();
}

} // namespace springdrive::session
