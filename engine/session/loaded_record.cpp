#include "engine/session/loaded_record.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/record/record_format.h"
#include "engine/record/record_reader.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>

namespace springdrive::session {

namespace {

/// Collects what a file's chunks contain.
class RecordLoading {
public:
    RecordLoading(const std::filesystem::path &file, double from_s, std::size_t max_bytes)
        : reader_(file), from_s_(from_s), max_bytes_(max_bytes),
          device_(device::read_device_text(reader_.header().device_toml,
                                           file.string() + ", its device")),
          rows_(history_for(device_.geometry, reader_.header())) {
        std::error_code ignored; // only for the progress
        file_bytes_ =
            std::max<double>(1.0, static_cast<double>(std::filesystem::file_size(file, ignored)));
    }

    LoadedRecord read(BackgroundTalk &talk) && {
        while (reader_.next()) {
            const double read_bytes = static_cast<double>(reader_.ending().rows) *
                                      static_cast<double>(reader_.header().row_bytes);
            talk.report("reading", std::min(1.0, read_bytes / file_bytes_));
            if (reader_.is_note()) {
                take_note();
            }
            for (std::uint32_t row = 0; row < reader_.rows(); ++row) {
                stop_if_given_up();
                take_row(row);
            }
        }
        check_rows();
        return result();
    }

private:
    /// Of any origin, or another version: what is not known is passed over.
    void take_note() {
        const nlohmann::json note = nlohmann::json::parse(reader_.note(), nullptr, false);
        try {
            if (note.contains("delay_periods")) {
                delays_.push_back({note.at("from_tick"), note.at("delay_periods")});
            } else if (note.contains("scene_id")) {
                const nlohmann::json &scene = note.at("scene");
                scenes_[note.at("scene_id")] = {scene.at("file"), scene.at("sha256")};
            }
        } catch (const nlohmann::json::exception &) {
            return;
        }
    }

    void take_row(std::uint32_t number) {
        if (!time_offset_) { // the first row: throws if there is no such column
            static_cast<void>(reader_.read_sample(number));
            time_offset_ = reader_.header().column("time_s")->offset;
        }
        const auto time_s = record::load<double>(reader_.row(number).data() + *time_offset_);
        if (!std::isfinite(time_s) || (all_ && time_s <= all_->last_s)) {
            ++left_out_rows_;
            return;
        }
        all_ = RowTimes{all_ ? all_->first_s : time_s, time_s};
        if (time_s >= from_s_ && rows_.store().bytes() < max_bytes_) {
            add(reader_.read_sample(number));
        }
    }

    void add(const servo::ServoSample &sample) {
        constexpr std::uint64_t kExact = std::uint64_t{1} << 53U; // below it, doubles are exact
        if (sample.tick < kExact && sample.measurement_number < kExact) {
            rows_.follow_rate(sample);
            rows_.add(sample);
        } else {
            ++left_out_rows_;
        }
    }

    void check_rows() const {
        if (!rows_.store().is_empty()) {
            return;
        }
        const std::string file = reader_.path().string();
        if (all_) {
            throw InputError(fmt::format("{}: has no rows from {:g} s on; it ends at {:g} s", file,
                                         from_s_, all_->last_s));
        }
        throw InputError(fmt::format("{}: has no usable rows ({}); record it again", file,
                                     reader_.ending().text()));
    }

    [[nodiscard]] std::string ending() const {
        std::string text = reader_.ending().text();
        if (left_out_rows_ > 0) {
            text +=
                fmt::format("; left out: {} whose time or number is invalid or not later than "
                            "the one before",
                            left_out_rows_ == 1 ? "1 row" : fmt::format("{} rows", left_out_rows_));
        }
        return text;
    }

    LoadedRecord result() {
        std::string text = ending();
        const record::ChannelStore &store = rows_.store();
        const RowTimes loaded{store.time_s(store.begin()), store.time_s(store.end() - 1)};
        return {reader_.path(),
                reader_.header(),
                device_,
                std::move(rows_).take(),
                *all_,
                loaded,
                std::move(text),
                std::move(delays_),
                std::move(scenes_)};
    }

    record::RecordReader reader_;
    double from_s_;
    std::size_t max_bytes_;
    double file_bytes_ = 1.0;
    device::DeviceDescription device_;
    TelemetryHistory rows_;
    std::optional<std::uint32_t> time_offset_; ///< of the time within a row
    std::optional<RowTimes> all_;              ///< so far
    std::vector<DelayChange> delays_;
    std::map<std::uint32_t, RecordedScene> scenes_;
    std::uint64_t left_out_rows_ = 0;
};

} // namespace

double LoadedRecord::delay_periods_at(std::uint64_t tick) const {
    double delay_periods = header.delay_periods;
    for (const DelayChange &change : delays) {
        delay_periods = change.from_tick <= tick ? change.delay_periods : delay_periods;
    }
    return delay_periods;
}

RecordedScene LoadedRecord::scene_of(const servo::ServoSample &sample) const {
    const auto noted = scenes.find(sample.scene_id);
    return noted != scenes.end() ? noted->second
                                 : RecordedScene{header.scene_file, header.scene_sha256};
}

std::uint64_t LoadedRecord::row_shown_at(double time_s) const {
    if (!(time_s > loaded.first_s)) {
        return store.begin();
    }
    const std::uint64_t row = store.row_at(time_s);
    return row < store.end() && store.time_s(row) == time_s ? row : row - 1;
}

LoadedRecord load_record(const std::filesystem::path &file, double from_s, std::size_t max_bytes,
                         BackgroundTalk &talk) {
    return RecordLoading(file, from_s, max_bytes).read(talk);
}

TelemetryHistory history_for(const device::PhantomGeometry &geometry,
                             const record::RecordHeader &header) {
    const double servo_hz = 1.0 / header.period_s; // of any origin
    return {geometry, std::isfinite(servo_hz) && servo_hz > 0.0 ? servo_hz : 1000.0,
            std::numeric_limits<std::size_t>::max()};
}

} // namespace springdrive::session
