#include "engine/session/record.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/record/record_file.h"
#include "engine/record/record_format.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

namespace springdrive::session {

namespace {

/// Notes are of any origin, or of another version: what is not known is passed over.
template <typename Read> void for_each_note(const Record &record, Read &&read) {
    for (const RecordNote &note : record.notes) {
        try {
            read(nlohmann::json::parse(note.json, nullptr, false));
        } catch (const nlohmann::json::exception &) {
            continue;
        }
    }
}

/// Collects what a file's chunks contain.
class RecordLoading {
public:
    RecordLoading(const std::filesystem::path &file, double from_s, std::size_t max_bytes)
        : reader_(file), from_s_(from_s),
          max_bytes_(max_bytes), record_{reader_.header(),
                                         device::read_device_text(reader_.header().device_toml,
                                                                  file.string() + ", its device")},
          rows_(history_for(record_.device.geometry, record_.header)) {
        record_.file = file;
        std::error_code ignored; // only for the progress
        file_bytes_ =
            std::max<double>(1.0, static_cast<double>(std::filesystem::file_size(file, ignored)));
    }

    Record read(BackgroundTalk &talk) && {
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
    void take_note() {
        note_bytes_ += sizeof(RecordNote) + reader_.note().size();
        if (note_bytes_ < max_bytes_) {
            record_.notes.push_back({rows_.store().end(), std::string(reader_.note())});
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

    Record result() {
        record_.ending = ending();
        record_.store = std::move(rows_).take();
        record_.rows = {record_.store.begin(), record_.store.end()};
        record_.all = *all_;
        return std::move(record_);
    }

    record::RecordReader reader_;
    double from_s_;
    std::size_t max_bytes_;
    double file_bytes_ = 1.0;
    Record record_;
    TelemetryHistory rows_;
    std::optional<std::uint32_t> time_offset_; ///< of the time within a row
    std::optional<RowTimes> all_;              ///< so far
    std::size_t note_bytes_ = 0;
    std::uint64_t left_out_rows_ = 0;
};

} // namespace

void Record::drop_before(std::uint64_t row) {
    rows.from = std::max(rows.from, row);
    auto note = notes.begin();
    for (; note != notes.end() && note->before_row <= rows.from; ++note) {
        header = note->header ? *note->header : header;
    }
    notes.erase(notes.begin(), note);
}

std::vector<DelayChange> delays_of(const Record &record) {
    std::vector<DelayChange> delays{{0, record.header.delay_periods}};
    for_each_note(record, [&](const nlohmann::json &note) {
        if (note.contains("delay_periods")) {
            delays.push_back({note.at("from_tick"), note.at("delay_periods")});
        }
    });
    return delays;
}

double delay_periods_at(std::uint64_t tick, const std::vector<DelayChange> &delays) {
    double delay_periods = 0.0;
    for (const DelayChange &change : delays) {
        delay_periods = change.from_tick <= tick ? change.delay_periods : delay_periods;
    }
    return delay_periods;
}

std::map<std::uint32_t, RunScene> noted_scenes(const Record &record) {
    std::map<std::uint32_t, RunScene> scenes;
    for_each_note(record, [&](const nlohmann::json &note) {
        if (note.contains("scene_id")) {
            const nlohmann::json &scene = note.at("scene");
            scenes[note.at("scene_id")] = {scene.at("file"), scene.at("sha256")};
        }
    });
    return scenes;
}

Record load_record(const std::filesystem::path &file, double from_s, std::size_t max_bytes,
                   BackgroundTalk &talk) {
    return RecordLoading(file, from_s, max_bytes).read(talk);
}

void write_record(const std::filesystem::path &file, const Record &record, BackgroundTalk &talk) {
    record::RecordHeader header = record.header;
    const std::uint64_t rows = std::max(record.rows.from, record.rows.to) - record.rows.from;
    if (rows > 0) {
        const servo::ServoSample first = sample_at(record.store, record.rows.from);
        header.tuning = first.tuning;
        header.global_alpha_rad2_per_m2 = first.global_alpha_rad2_per_m2;
    }
    const std::string what = "writing " + file.filename().string();
    record::RecordWriter writer(file, header);
    std::error_code ignored;
    try {
        std::uint64_t written = 0;
        record.for_each(
            [&](const servo::ServoSample &sample) {
                if (written % record::ChannelStore::kRowsPerChunk == 0) {
                    talk.report(what, static_cast<double>(written) / static_cast<double>(rows));
                }
                writer.write(sample);
                ++written;
            },
            [&](std::string_view json) { writer.note(json); });
        writer.close();
    } catch (const InputError &) {
        std::filesystem::remove(file, ignored);
        if (writer.is_open()) { // not the disk, but a note
            throw;
        }
        throw InputError(fmt::format("{}: cannot be written completely, but only {} of {} ticks; "
                                     "is the disk full? Nothing of it is kept",
                                     file.string(), writer.rows_in_file(), rows));
    } catch (...) {
        std::filesystem::remove(file, ignored);
        throw;
    }
}

TelemetryHistory history_for(const device::PhantomGeometry &geometry,
                             const record::RecordHeader &header) {
    const double servo_hz = 1.0 / header.period_s; // of any origin
    return {geometry, std::isfinite(servo_hz) && servo_hz > 0.0 ? servo_hz : 1000.0,
            std::numeric_limits<std::size_t>::max()};
}

} // namespace springdrive::session
