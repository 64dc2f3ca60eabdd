// A record in the window: shown instead of the present, or behind it, and computed again with the
// active tuning.
#pragma once

#include "app/plots/plot_panel.h"
#include "engine/session/record_playback.h"
#include "engine/session/run_folder.h"
#include "engine/session/session.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

namespace springdrive::app {

/// What scene and plots show while a record is open.
enum class RecordView : std::uint8_t {
    present,    ///< the record is not shown
    behind,     ///< the present, with the record faintly behind it in the plots
    instead_of, ///< the record
};

inline constexpr std::array<const char *, 3> kRecordViewLabels{
    "show the present", "present, record behind", "show the record"};

class OpenedRecord {
public:
    /// Opens a record, or the first record of a run folder; in the background.
    void open(const std::filesystem::path &path);
    void open_part(std::size_t part);
    /// The same record, which does not fit into memory, from that time on.
    void open_from(double from_s);
    void close();

    /// Once a frame. @param tuning  the active one
    void update(double frame_s, const control::Tuning &tuning);

    [[nodiscard]] session::RecordPlayback &playback() { return playback_; }
    [[nodiscard]] const session::RecordPlayback &playback() const { return playback_; }
    /// The folder that the record belongs to; empty if it is a file alone.
    struct Run {
        std::filesystem::path folder;
        session::RunFacts facts;
        std::size_t part = 0; ///< the number of the record
    };
    [[nodiscard]] const std::optional<Run> &run() const { return run_; }
    /// Why nothing was opened, or computed; else empty.
    [[nodiscard]] const std::string &error() const {
        return error_.empty() ? playback_.error() : error_;
    }

    [[nodiscard]] bool is_shown() const {
        return view == RecordView::instead_of && playback_.is_open();
    }
    [[nodiscard]] PlotSubject subject(const session::Session &session) const;

    RecordView view = RecordView::instead_of;
    bool asks = false; ///< what the active tuning would have done

private:
    void load(const std::filesystem::path &file, std::optional<Run> run,
              double from_s = -std::numeric_limits<double>::infinity());
    void renew_behind();

    session::RecordPlayback playback_;
    std::optional<Run> run_;
    std::optional<Run> run_of_next_; ///< of the record that is being loaded
    bool loads_ = false;
    std::uint32_t number_ = 0; ///< of records opened so far
    std::string error_;
    std::optional<PlotTrace> behind_; ///< the record itself, or the answer
    const void *behind_of_ = nullptr; ///< the store that it is a copy of
};

} // namespace springdrive::app
