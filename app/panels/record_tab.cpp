#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "engine/control/tuning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

/// Records and run folders in the own folder, the newest first.
std::vector<std::filesystem::path> records_here() {
    constexpr std::size_t kMax = 50;
    std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> found;
    std::error_code ignored;
    for (const auto &entry : std::filesystem::directory_iterator(output_dir(), ignored)) {
        const bool is_run = entry.is_directory(ignored) &&
                            std::filesystem::exists(entry.path() / "run.json", ignored);
        if (is_run || entry.path().extension() == ".rec") {
            found.emplace_back(entry.last_write_time(ignored), entry.path().lexically_normal());
        }
    }
    std::ranges::sort(found, std::greater());
    std::vector<std::filesystem::path> files;
    for (std::size_t i = 0; i < std::min(kMax, found.size()); ++i) {
        files.push_back(found[i].second);
    }
    return files;
}

void draw_chooser(OpenedRecord &opened, RecordTabState &state) {
    ImGui::SetNextItemWidth(7.0F * ImGui::GetFontSize());
    {
        const ui::DropDown list("##files", "open");
        if (list && ImGui::IsWindowAppearing()) {
            state.files = records_here();
        }
        if (list && state.files.empty()) {
            ui::text(kFaintInk, "no records in {}", output_dir_text());
        }
        for (const std::filesystem::path &file : state.files) {
            if (list && ui::selectable(file.filename().c_str(), false)) {
                opened.open(file);
            }
        }
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0F);
    if (ui::text_field("##path", "path of a record or run", state.path)) {
        opened.open(state.path);
    }
}

void draw_parts(OpenedRecord &opened) {
    const std::vector<session::RunRecord> &records = opened.run()->facts.records;
    if (records.size() < 2) {
        return;
    }
    ImGui::SetNextItemWidth(7.0F * ImGui::GetFontSize());
    const ui::DropDown list("##part", records[opened.run()->part].file.filename().c_str());
    for (std::size_t i = 0; i < records.size(); ++i) {
        if (list && ui::selectable(records[i].file.filename().c_str(), i == opened.run()->part)) {
            opened.open_part(i);
        }
    }
}

/// What a tick has, and what it would have with the tuning that was answered.
void compare(const char *name, const char *format, double recorded,
             const std::optional<double> &answered) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui::text(kFaintInk, "{}", name);
    const ui::Scope scope(name);
    const auto show = [&](double value) {
        ImGui::TableNextColumn();
        if (std::isnan(value)) {
            ui::text(kFaintInk, "–");
        } else {
            ui::show_text(kInk, fmt::vformat(format, fmt::make_format_args(value)), false);
        }
    };
    show(recorded);
    if (answered) {
        show(*answered);
    }
}

void draw_values(const session::RecordPlayback &playback) {
    const servo::ServoSample now = playback.sample();
    const std::optional<servo::ServoSample> other = playback.answered_sample();
    if (!ImGui::BeginTable("values", other ? 3 : 2, ImGuiTableFlags_SizingStretchProp)) {
        return;
    }
    if (other) {
        ImGui::TableNextColumn();
        ImGui::TableNextColumn();
        ui::text(kFaintInk, "recorded");
        ImGui::TableNextColumn();
        ui::text(kFaintInk, "{}",
                 playback.is_answer_current() ? "active tuning" : "tuning before it");
    }
    const auto row = [&](const char *name, const char *format, auto &&value_of) {
        compare(name, format, value_of(now),
                other ? std::optional<double>(value_of(*other)) : std::nullopt);
    };
    using servo::ServoSample;
    row("force", "{:.2f} N", [](const ServoSample &s) { return s.tip_force_N.norm(); });
    row("direction error", "{:.1f}°",
        [](const ServoSample &s) { return kDegreesPerRadian * s.rendered_error_rad; });
    row("greatest |e_W|", "{:.3f} V",
        [](const ServoSample &s) { return s.command.e_W_V.cwiseAbs().maxCoeff(); });
    ImGui::EndTable();
}

void draw_tuning_of_record(session::Session &session, TuningEditor &editor,
                           const session::RecordPlayback &playback) {
    const control::Tuning then = playback.sample().tuning;
    const std::vector<control::TuningChange> changes =
        control::changes_between(then, session.tuning().now());
    if (changes.empty()) {
        ui::text(kFaintInk, "it is that of the record");
        return;
    }
    if (ui::button("load its tuning")) {
        editor.replace(then, playback.record().file.filename().string());
    }
    std::string text;
    for (const control::TuningChange &change : changes) {
        text += ui::formatted("{}{} {} → {}", text.empty() ? "" : ", ", change.symbol,
                              change.before, change.after);
    }
    ui::explain("recorded → active: " + text);
}

void draw_facts(session::Session &session, const OpenedRecord &opened) {
    const session::Record &record = opened.playback().record();
    ui::wrapped(kFaintInk, "{}, {:g} Hz, {:.1f} s from {}", record.header.device_name,
                record.header.servo_hz, record.all.last_s - record.all.first_s,
                record.header.started_utc);
    ui::explain(record.ending);
    const session::RunScene then = opened.playback().scene();
    const std::filesystem::path scene = then.file;
    if (!scene.empty() && then.sha256 != session.scenes().now().sha256) {
        ui::wrapped(kWarning, "recorded on {}, not on the scene that is shown",
                    scene.filename().string());
        if (ui::small_button("show its scene##scene")) {
            session.request_scene(scene);
        }
    }
    if (opened.run() && !opened.run()->facts.notes.empty()) {
        ui::wrapped(kInk, "{}", opened.run()->facts.notes);
    }
}

void draw_loaded_part(OpenedRecord &opened) {
    const session::Record &record = opened.playback().record();
    if (!record.is_partial()) {
        return;
    }
    const session::RowTimes loaded = record.times();
    ui::wrapped(kWarning, "in memory: {:.1f} to {:.1f} s of {:.1f} to {:.1f} s", loaded.first_s,
                loaded.last_s, record.all.first_s, record.all.last_s);
    const double length_s = loaded.last_s - loaded.first_s;
    {
        const ui::Disabled at_begin(loaded.first_s <= record.all.first_s);
        if (ui::small_button("earlier")) {
            opened.open_from(loaded.first_s - length_s);
            return;
        }
    }
    ImGui::SameLine();
    const ui::Disabled at_end(loaded.last_s >= record.all.last_s);
    if (ui::small_button("later")) {
        opened.open_from(loaded.last_s);
    }
}

void draw_playback_speed(session::RecordPlayback &playback) {
    constexpr std::array<double, 11> kPlaybackSpeeds{-10.0, -1.0, -0.1, 0.01, 0.1,  0.5,
                                                     1.0,   2.0,  10.0, 50.0, 100.0};
    const auto text_of_speed = [](double speed) { return ui::formatted("{:g} ×", speed); };
    {
        const ui::DropDown list("##speed", text_of_speed(playback.speed()).c_str());
        for (const double speed : kPlaybackSpeeds) {
            if (list && ui::selectable(text_of_speed(speed).c_str(), speed == playback.speed())) {
                playback.set_speed(speed);
            }
        }
    }
    ui::explain("speed, negative backwards");
}

} // namespace

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
    const record::ChannelStore *const requested =
        of_record ? &playback_.store() : playback_.answer();
    if (requested == nullptr) {
        behind_.reset();
    } else if (!behind_ || behind_of_ != requested) {
        behind_ = PlotTrace{*requested, {}, {}};
    }
    behind_of_ = requested;
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

void draw_record_tab(session::Session &session, TuningEditor &editor, OpenedRecord &opened,
                     RecordTabState &state) {
    draw_chooser(opened, state);
    session::RecordPlayback &playback = opened.playback();
    if (playback.is_loading()) {
        ui::progress("loading", playback.share(), "loading");
    }
    ui::show_error(opened.error());
    if (!playback.is_open()) {
        return;
    }
    ImGui::SetNextItemWidth(13.0F * ImGui::GetFontSize());
    ui::choice("##view", opened.view, kRecordViewLabels);
    ui::explain("key R");
    ImGui::SameLine();
    if (ui::button("close")) {
        opened.close();
        return;
    }
    if (opened.run()) {
        ImGui::SameLine();
        draw_parts(opened);
    }
    ui::checkbox("what if: the active tuning", opened.asks);
    ui::explain(
        "computes the record again with the active gains, for the same motion: e_W exactly,\n"
        "currents and force as predicted for it. The hand would have moved otherwise.\n"
        "Faintly in the plots, and here");
    ImGui::SameLine();
    draw_tuning_of_record(session, editor, playback);
    draw_values(playback);
    draw_facts(session, opened);
    draw_loaded_part(opened);
}

void draw_record_controls(OpenedRecord &opened, const Rectangle &view, float scale) {
    session::RecordPlayback &playback = opened.playback();
    const float margin = 10.0F * scale;
    const float height = ImGui::GetFrameHeight() + 1.4F * ImGui::GetStyle().WindowPadding.y;
    const ui::Scope scope("record");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.end().y - height - margin});
    ImGui::SetNextWindowSize({view.size.x - 2.0F * margin, height});
    ImGui::Begin("record", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    const float font = ImGui::GetFontSize();
    if (ui::button(playback.is_playing() ? "stop###play" : "play###play", {3.6F * font, 0.0F})) {
        playback.play(!playback.is_playing());
    }
    ui::explain("plays the record; key P");
    ImGui::SameLine();
    if (ui::button("<##back")) {
        playback.step(-1);
    }
    ui::explain("one tick back; key ,");
    ImGui::SameLine();
    if (ui::button(">##forward")) {
        playback.step(1);
    }
    ui::explain("one tick on; key .");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(5.6F * font);
    draw_playback_speed(playback);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0F);
    const session::RowTimes times = playback.record().times();
    double position_s = playback.position_s();
    if (ui::slider_with_number("##position", position_s, times.first_s, times.last_s, "%.3f s")) {
        playback.seek(position_s);
    }
    ImGui::End();
}

} // namespace springdrive::app
