// A record opened beside the session: loaded in the background, shown at any time of it, and
// computed again with another tuning.
//
//   open ──► load_record ──► store ──► playhead ──► sample
//   ask  ──► what_if ──► answer: first some seconds around the playhead, then all rows
//
// Loading and answers are ready some time after they were asked; `advance` takes them over.
#pragma once

#include "base/background.h"
#include "device/core/haptic_device.h"
#include "device/core/split_delay.h"
#include "engine/control/tuning.h"
#include "engine/record/replay.h"
#include "engine/servo/servo_sample.h"
#include "engine/session/record.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::session {

// What the law would have commanded during a recorded motion with another tuning, and the currents
// and forces that would have followed.
//
//   recorded tick, tuning ──► record::Replay ──► θ̇_f, η, α, x_Sd, θ_Sd, e_W, R̂
//   e_W, R̂ after the delay d; recorded θ ──► windings (11) ──► i ──► tip force (3), (22)
//
// The motion is the recorded one, although the hand would have moved otherwise. So the commands are
// exact for this motion, but only for it; currents and force are an open-loop prediction, in which
// nothing corrects what is not known: R, k_T and the sensor's offset are what the servo knew of
// them in that tick (of the device file, if it did not observe them), and each rotor turns with the
// mean velocity between two readings of its encoder. A reading is wrong by up to half a count,
// which makes up to k_T/L times a count of current. All else is as recorded, including the proxy's
// contact, the monitor's decisions and the offset of e_W after changes of the record's own tuning.

/// Predicts the currents of windings that get other commands than recorded.
class PredictedCurrents {
public:
    /// @param delay_periods  d of the recorded device
    PredictedCurrents(const device::DeviceDescription &device, double delay_periods);

    /// The currents as measured at the next tick of a record, with the sensors' offsets [A]: the
    /// recorded ones until all commands are known that acted since the measurement before, again
    /// after missing ticks, and while the monitor lets no command pass.
    [[nodiscard]] Vector3 at(const servo::ServoSample &recorded);

    /// Before `at`: from this tick on.
    void set_delay(double delay_periods);

    /// Once a tick, after `at`: the command of this tick.
    void note(const device::DeviceCommand &command) { commands_.push_back(command); }

private:
    [[nodiscard]] bool follows(const servo::ServoSample &recorded) const;
    [[nodiscard]] int periods_until(const servo::ServoSample &recorded);
    void run(const servo::ServoSample &recorded, int periods);
    void drive(const device::DeviceCommand &command, const servo::ServoSample &recorded,
               double duration_s);

    device::DeviceDescription device_;
    device::SplitDelay delay_;
    std::optional<std::uint64_t> last_tick_;
    std::optional<servo::ServoSample> measured_; ///< the last tick with a new measurement
    Vector3 current_A_{Vector3::Zero()};         ///< at that time, without the sensors' offsets
    std::deque<device::DeviceCommand> commands_; ///< one per period, the newest last
};

/// Computes consecutive ticks of a record again with another tuning.
class WhatIf {
public:
    WhatIf(const device::DeviceDescription &device, double delay_periods,
           const control::Tuning &tuning);

    /// From the next tick on.
    void set_delay(double delay_periods) { currents_.set_delay(delay_periods); }

    /// The next tick with what this tuning changes. A tick that cannot be replayed stays as it is,
    /// such as the first one and those after missing ticks.
    [[nodiscard]] servo::ServoSample of(const servo::ServoSample &recorded);

private:
    void take_law(const record::ReplayedTick &tick, servo::ServoSample &answer) const;
    void take_force(const record::ReplayedTick &tick, servo::ServoSample &answer) const;

    control::Tuning tuning_;
    control::HapticLaw law_;
    record::Replay replay_;
    PredictedCurrents currents_;
};

/// The rows of a range with another tuning: of the same times as in the record, but numbered from
/// the range's first. The rows before it are used as far as they matter. Any thread.
/// @pre the range is in the store
/// @throw Cancelled soon after this thread's work was cancelled
[[nodiscard]] record::ChannelStore what_if(const Record &record, const control::Tuning &tuning,
                                           const RowRange &rows);

/// For use by one thread. The destructor cancels what runs in the background and waits until it has
/// ended, a fraction of a second.
class RecordPlayback {
public:
    /// Of a record's rows: some 13 minutes at 1 kHz. An answer needs up to as much again, and so
    /// does the next record while it is being loaded.
    static constexpr std::size_t kMaxBytes = std::size_t{512} << 20;
    static constexpr double kMaxSpeed = 100.0;

    /// Loads a record; of several requests while loading, the last one counts. The open record
    /// stays open until the next one is ready. If loading fails, it remains, and `error` holds the
    /// reason.
    /// @param from_s  rows before that time are left out, to get another part of a record that does
    ///                not fit into memory
    void open(const std::filesystem::path &file,
              double from_s = -std::numeric_limits<double>::infinity());
    /// Closes the record, and cancels loading.
    void close();

    [[nodiscard]] bool is_open() const { return record_ != nullptr; }
    [[nodiscard]] bool is_loading() const { return loading_.is_busy(); }
    /// Progress of loading, 0 to 1.
    [[nodiscard]] double share() const { return loading_.share(); }
    /// One line: why the last record was not loaded, or a tuning has no answer; else empty.
    [[nodiscard]] const std::string &error() const { return error_; }

    // What follows, except for `advance`, `play`, `set_speed` and `ask`, is for an open record.

    /// File, header, device, rows, notes and times. It is valid until `close`, or an `advance` that
    /// takes over the next record.
    [[nodiscard]] const Record &record() const;
    [[nodiscard]] const record::ChannelStore &store() const { return record().store; }

    /// The playhead, by the servo's time [s]: between the times of the first and last loaded row.
    [[nodiscard]] double position_s() const { return position_s_; }
    void seek(double time_s);
    /// Stops playing, and moves to the row so many rows later, or earlier where negative.
    void step(int rows);

    /// @param speed  1 as recorded, negative backwards, up to ±kMaxSpeed; ignored if not finite
    void set_speed(double speed);
    [[nodiscard]] double speed() const { return speed_; }
    /// Started at the end towards which it plays, it plays from the other end.
    void play(bool on);
    [[nodiscard]] bool is_playing() const { return is_playing_; }

    /// Once a frame: takes over what the background has completed, and moves the playhead while
    /// playing, which ends at the ends.
    void advance(double frame_s);

    /// The row at the playhead: the last one until then.
    [[nodiscard]] std::uint64_t row() const {
        return store().row_shown_at(position_s_).value_or(store().begin());
    }
    [[nodiscard]] servo::ServoSample sample() const { return sample_at(store(), row()); }
    /// The scene on which that row was recorded.
    [[nodiscard]] RunScene scene() const;

    /// Computes the record again with this tuning, now and whenever another record is opened;
    /// without effect if it is the one last asked for, or not valid. The newest request counts, but
    /// its first part is only begun after that of the one before it, so that answers keep arriving
    /// while a slider is moved.
    void ask(const control::Tuning &tuning);
    /// Drops question and answer.
    void stop_asking();

    /// The question; empty if none.
    [[nodiscard]] const std::optional<control::Tuning> &asked() const { return asked_; }
    /// Whether the answer is not complete yet.
    [[nodiscard]] bool is_answering() const { return answering_.is_busy(); }

    /// Channels and times as in `store`, but rows numbered from the answer's own first; see
    /// `what_if` for what they mean. Null until the first part of an answer is ready; stays until
    /// that of the next is. Valid until the next `advance`, `close` or `stop_asking`.
    [[nodiscard]] const record::ChannelStore *answer() const {
        return answer_ ? &answer_->store : nullptr;
    }
    /// Its tuning. Only with an answer.
    [[nodiscard]] const control::Tuning &answered_tuning() const { return answer_->tuning; }
    /// Whether it is for the present question, not for the one before. Only with an answer.
    [[nodiscard]] bool is_answer_current() const { return answer_->tuning == asked_; }
    /// Its row at the playhead; empty if it has none.
    [[nodiscard]] std::optional<servo::ServoSample> answered_sample() const;

private:
    using SharedRecord = std::shared_ptr<const Record>;

    struct Answer {
        control::Tuning tuning;
        bool is_complete = false;
        RowRange rows; ///< of the record
        record::ChannelStore store;
    };

    void take_record();
    void take_answer();
    void go_on_answering();
    void stop_reporting_failure();
    void move(double frame_s);
    [[nodiscard]] RowRange rows_to_answer_first() const;
    void drop_record();
    void drop_answer();

    SharedRecord record_;
    std::map<std::uint32_t, RunScene> scenes_; ///< noted in the record
    std::string error_;
    double position_s_ = 0.0;
    double speed_ = 1.0;
    bool is_playing_ = false;

    std::optional<control::Tuning> asked_;
    std::optional<control::Tuning> failed_; ///< could not be computed: not tried again
    std::unique_ptr<Answer> answer_;
    control::Tuning running_tuning_; ///< of the running computation
    bool running_completes_ = false; ///< whether it is that of all rows

    BackgroundRelease<SharedRecord> release_record_;
    BackgroundRelease<Answer> release_answer_;
    Background<SharedRecord> loading_;
    Background<std::unique_ptr<Answer>> answering_; ///< last members, so that they are joined first
};

} // namespace springdrive::session
