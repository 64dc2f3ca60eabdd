// Records the servo's samples from its ring to a record file.
//
//   servo ── push ──► ring ── drain ──► Recorder ──► RecordWriter ──► file
//                     never waits       own thread, or the thread that runs the servo in lockstep
//
//   Recorder recorder(ring);
//   recorder.start("grasp.rec", header, Recorder::Mode::own_thread);
//   ...
//   recorder.stop(R"({"end": "asked for"})");
//
// A full disk ends the recording, not the servo: what was written is kept, the status holds the
// error message, and the ring is still drained.
#pragma once

#include "base/hand_over.h"
#include "engine/record/record_file.h"
#include "engine/record/record_format.h"
#include "engine/servo/servo_sample.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive::record {

struct RecorderStatus {
    std::uint64_t rows = 0;  ///< in the file
    std::uint64_t bytes = 0; ///< of the file
    std::uint64_t lost = 0;  ///< samples lost because the ring was full, up to the last row
    std::string error;       ///< why the recording ended early; empty if it did not
};

/// Call start, stop and pump from one thread; note, is_recording and status from any.
class Recorder {
public:
    enum class Mode : std::uint8_t {
        own_thread, ///< drains every 10 ms; the file lags by at most 50 ms
        pumped,     ///< drains when `pump` is called
    };

    /// The ring must outlive the recorder, which alone drains it while recording. It must buffer
    /// the samples while the disk stalls: 32,768 samples are 3.2 s at 10 kHz.
    explicit Recorder(SampleRing<servo::ServoSample> &ring) : ring_(ring) {}
    ~Recorder();
    Recorder(const Recorder &) = delete;
    Recorder &operator=(const Recorder &) = delete;

    /// Samples already in the ring are dropped. A running recording is stopped first.
    /// @throw InputError as RecordWriter's constructor does.
    void start(const std::filesystem::path &path, const RecordHeader &header, Mode mode,
               FilePolicy policy = Existing::keep);

    /// Records what is in the ring, then `last_note` (JSON text) if given, and closes the file. May
    /// be called twice. Does not throw: see `status`.
    void stop(std::string_view last_note = {});

    /// Records what is in the ring. Only for Mode::pumped; otherwise it does nothing.
    void pump();

    /// Queues JSON text to be written after all samples that are in the ring at the next drain.
    /// Does nothing while not recording. @throw InputError for a text longer than
    /// RecordWriter::kMaxNote.
    void note(std::string_view json);

    [[nodiscard]] bool is_recording() const;

    /// Status of the current recording, or else of the last one.
    [[nodiscard]] RecorderStatus status() const;

private:
    using Clock = std::chrono::steady_clock;

    void run();
    void drain();
    void take(const servo::ServoSample &sample);
    void write_notes();
    void flush_what_is_old();
    void publish_status();
    template <typename Step> void guarded(Step &&step);

    SampleRing<servo::ServoSample> &ring_;
    Mode mode_ = Mode::pumped;
    std::thread thread_;

    // Used by the draining thread, and by `start` and `stop` while there is none.
    std::unique_ptr<RecordWriter> writer_;
    std::uint64_t lost_before_ = 0; ///< by the ring before the start
    std::uint64_t gaps_ = 0;        ///< in the ticks
    std::optional<std::uint64_t> last_tick_;
    Clock::time_point waiting_since_{}; ///< time of the first row that is not in the file yet

    mutable std::mutex mutex_; ///< guards all members below
    std::condition_variable wake_;
    bool is_stopping_ = false;
    std::vector<std::string> notes_;
    bool is_recording_ = false;
    RecorderStatus status_;
};

} // namespace springdrive::record
