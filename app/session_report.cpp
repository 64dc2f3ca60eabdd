#include "app/session_report.h"

#include "base/print.h"

#include <nlohmann/json.hpp>

#include <array>
#include <iostream>

namespace springdrive {

namespace {

constexpr double kMicro = 1e6;
constexpr double kMega = 1e-6;

void print_durations(std::ostream &out, const char *name, const DurationHistogram &durations) {
    if (durations.count() > 0) {
        print(out, "servo: %s median %.1f µs, 99 %% %.1f µs, 99.9 %% %.1f µs, longest %.1f µs\n",
              name, kMicro * durations.quantile_s(0.5), kMicro * durations.quantile_s(0.99),
              kMicro * durations.quantile_s(0.999), kMicro * durations.longest_s());
    }
}

nlohmann::json json_of(const DurationHistogram &durations) {
    return {{"count", durations.count()},
            {"mean_s", durations.mean_s()},
            {"p50_s", durations.quantile_s(0.5)},
            {"p99_s", durations.quantile_s(0.99)},
            {"p999_s", durations.quantile_s(0.999)},
            {"longest_s", durations.longest_s()}};
}

} // namespace

void write_session_report(std::ostream &out, const SessionOptions &options,
                          const Session &session) {
    const ServoStatistics &servo = session.statistics();
    print(out, "servo: %llu ticks at %g Hz%s", static_cast<unsigned long long>(servo.ticks()),
          options.servo_hz, options.lockstep ? " in lockstep\n" : "");
    if (!options.lockstep) {
        print(out, ", %llu deadlines missed\n",
              static_cast<unsigned long long>(servo.missed_deadlines()));
    }
    print_durations(out, "jitter", servo.lateness());
    print_durations(out, "compute", servo.compute());
    const SafetyStatus &safety = session.latest().safety;
    if (safety.state == SafetyState::tripped) {
        print(out, "safety: stopped, %s\n", description(safety).c_str());
    }
    if (!session.record_file().empty()) {
        const RecorderStatus record = session.record_status();
        print(out, "record: %s, %llu ticks, %.1f MB, %llu lost\n", session.record_file().c_str(),
              static_cast<unsigned long long>(record.rows),
              kMega * static_cast<double>(record.bytes),
              static_cast<unsigned long long>(record.lost));
    }
}

void write_session_json(std::ostream &out, const SessionOptions &options, const Session &session) {
    const ServoStatistics &servo = session.statistics();
    const SafetyStatus &safety = session.latest().safety;
    const RecorderStatus record = session.record_status();
    nlohmann::json json;
    json["servo_hz"] = options.servo_hz;
    json["lockstep"] = options.lockstep;
    json["ticks"] = servo.ticks();
    json["missed_deadlines"] = servo.missed_deadlines();
    json["period"] = json_of(servo.period());
    json["jitter"] = json_of(servo.lateness());
    json["read"] = json_of(servo.read());
    json["compute"] = json_of(servo.compute());
    json["write"] = json_of(servo.write());
    json["refused"] = session.remarks();
    json["trip"] = safety.state == SafetyState::tripped ? description(safety) : "";
    json["record"] = {{"file", session.record_file().string()},
                      {"rows", record.rows},
                      {"bytes", record.bytes},
                      {"lost", record.lost},
                      {"error", record.error}};
    out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

bool was_stopped(const Session &session) {
    const SafetyStatus &safety = session.latest().safety;
    if (safety.state != SafetyState::tripped) {
        return false;
    }
    std::cerr << "springdrive: the servo was stopped: " << description(safety) << '\n';
    return true;
}

bool record_is_whole(const Session &session) {
    const RecorderStatus record = session.record_status();
    if (!record.error.empty()) {
        std::cerr << "springdrive: " << record.error << '\n';
        return false;
    }
    if (record.lost > 0) {
        std::cerr << "springdrive: " << session.record_file().string() << ": " << record.lost
                  << " ticks are missing, the disk was too slow; record to a faster one, or at a "
                     "lower --servo-hz\n";
        return false;
    }
    return true;
}

} // namespace springdrive
