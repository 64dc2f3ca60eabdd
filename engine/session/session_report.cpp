#include "engine/session/session.h"

#include "base/print.h"
#include "base/text.h"

#include <nlohmann/json.hpp>

#include <ostream>
#include <string>
#include <vector>

namespace springdrive::session {

namespace {

constexpr double kMicro = 1e6;
constexpr double kMilli = 1e3;
constexpr double kMega = 1e-6;

void print_durations(std::ostream &out, const char *name,
                     const servo::DurationHistogram &durations) {
    if (durations.count() > 0) {
        print(out,
              "servo: {} median {:.1f} µs, 99 % {:.1f} µs, 99.9 % {:.1f} µs, longest {:.1f} µs\n",
              name, kMicro * durations.quantile_s(0.5), kMicro * durations.quantile_s(0.99),
              kMicro * durations.quantile_s(0.999), kMicro * durations.longest_s());
    }
}

nlohmann::json json_of(const servo::DurationHistogram &durations) {
    return {{"count", durations.count()},
            {"mean_s", durations.mean_s()},
            {"p50_s", durations.quantile_s(0.5)},
            {"p99_s", durations.quantile_s(0.99)},
            {"p999_s", durations.quantile_s(0.999)},
            {"longest_s", durations.longest_s()}};
}

/// A device with its own clock misses deadlines; a simulated one is paused instead.
void print_time(std::ostream &out, const Session &session) {
    const ServoRun &servo = session.servo();
    print(out, "servo: {} ticks at {:g} Hz{}", servo.statistics().ticks(), servo.rate_hz(),
          servo.is_in_lockstep() ? " in lockstep" : "");
    if (session.device().device().clock() == device::DeviceClock::own) {
        print(out, ", {} deadlines missed", servo.statistics().missed_deadlines());
    }
    print(out, "\n");
    const Stalls &still = servo.stalls();
    if (still.times > 0) {
        print(out,
              "simulation: paused {} times, {:.1f} ms in total, at most {:.1f} ms in a row, while "
              "this computer was busy\n",
              still.times, kMilli * still.seconds, kMilli * still.longest_s);
    }
}

std::vector<std::string> names_of(const std::vector<std::filesystem::path> &files) {
    return {files.begin(), files.end()};
}

} // namespace

void write_session_report(std::ostream &out, const Session &session) {
    print_time(out, session);
    const servo::ServoStatistics &servo = session.servo().statistics();
    print_durations(out, "jitter", servo.lateness());
    print_durations(out, "compute", servo.compute());
    const servo::SafetyStatus &safety = session.latest().safety;
    if (safety.state == servo::SafetyState::tripped) {
        print(out, "safety: stopped, {}\n", servo::description(safety));
    }
    if (!session.recording().parts().empty()) {
        const record::RecorderStatus record = session.recording().status();
        std::string files;
        for (const std::filesystem::path &part : session.recording().parts()) {
            files += part.string() + ", ";
        }
        print(out, "record: {}{} ticks, {:.1f} MB, {} lost\n", files, record.rows,
              kMega * static_cast<double>(record.bytes), record.lost);
    }
}

void write_session_json(std::ostream &out, const Session &session) {
    const ServoRun &run = session.servo();
    const servo::ServoStatistics &servo = run.statistics();
    const servo::SafetyStatus &safety = session.latest().safety;
    const record::RecorderStatus record = session.recording().status();
    const device::DeviceIdentity identity = session.device().identity();
    nlohmann::json json;
    json["device"] = {{"name", session.description().name},
                      {"kind", identity.kind},
                      {"serial", identity.serial},
                      {"firmware", identity.firmware}};
    json["servo_hz"] = run.rate_hz();
    json["lockstep"] = run.is_in_lockstep();
    json["ticks"] = servo.ticks();
    json["missed_deadlines"] = servo.missed_deadlines();
    json["stood_still"] = {{"times", run.stalls().times}, {"seconds", run.stalls().seconds}};
    json["period"] = json_of(servo.period());
    json["jitter"] = json_of(servo.lateness());
    json["read"] = json_of(servo.read());
    json["compute"] = json_of(servo.compute());
    json["write"] = json_of(servo.write());
    json["refused"] = session.warnings().all();
    json["trip"] = safety.state == servo::SafetyState::tripped ? servo::description(safety) : "";
    json["record"] = {{"file", session.recording().file().string()},
                      {"files", names_of(session.recording().parts())},
                      {"rows", record.rows},
                      {"bytes", record.bytes},
                      {"lost", record.lost},
                      {"error", record.error}};
    out << json_text(json) << '\n';
}

bool was_stopped(const Session &session, std::ostream &errors) {
    const servo::SafetyStatus &safety = session.latest().safety;
    if (safety.state != servo::SafetyState::tripped) {
        return false;
    }
    errors << "springdrive: the servo was stopped: " << servo::description(safety) << '\n';
    return true;
}

bool record_is_whole(const Session &session, std::ostream &errors) {
    const record::RecorderStatus record = session.recording().status();
    if (!record.error.empty()) {
        errors << "springdrive: " << record.error << '\n';
        return false;
    }
    if (record.lost > 0) {
        errors << "springdrive: " << session.recording().file().string() << ": " << record.lost
               << " ticks are missing, the disk was too slow; record to a faster one, or at a "
                  "lower --servo-hz\n";
        return false;
    }
    return true;
}

} // namespace springdrive::session
