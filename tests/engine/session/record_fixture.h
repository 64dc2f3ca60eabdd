// Records of simulated presses, for tests of what is computed from records.
#pragma once

#include "device/core/device_file.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/record/record_file.h"
#include "engine/session/record.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/surfaces.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::testing {

inline constexpr double kRecorded_hz = 1000.0;

/// A tip that starts above a plate, presses on it, slides along it and lifts off.
struct Press {
    device::DeviceDescription device = phantom_1_0();
    simulated::SimulationOptions simulation = pressing();
    servo::ServoInputs inputs;
    double seconds = 3.0;
    /// Called before each tick; the rig's inputs can be changed.
    std::function<void(rig::ServoRig &, int tick)> before_tick{};

    [[nodiscard]] static simulated::SimulationOptions pressing() {
        simulated::SimulationOptions options;
        options.servo_period_s = 1.0 / kRecorded_hz;
        options.path.emplace(
            std::vector<simulated::HandPath::Point>{{1.0, Vector3(0.0, 0.02, 0.0)},
                                                    {1.3, Vector3(0.0, -0.005, 0.0)},
                                                    {1.8, Vector3(0.0, -0.005, 0.0)},
                                                    {2.4, Vector3(0.02, -0.006, 0.01)},
                                                    {2.7, Vector3(0.0, 0.02, 0.0)}});
        return options;
    }

    [[nodiscard]] std::vector<servo::ServoSample> samples() const {
        const contact::HapticSurface plate(
            box_soup(Vector3(-0.1, -0.02, -0.06), Vector3(0.1, 0.0, 0.06)));
        rig::ServoRig rig(device, simulation, Vector3(0.0, 0.02, 0.0), &plate);
        rig.inputs = inputs;
        rig.inputs.surface = &plate;
        rig.inputs.scene_id = 1;
        std::vector<servo::ServoSample> all;
        const int ticks = static_cast<int>(std::lround(seconds / simulation.servo_period_s));
        for (int tick = 0; tick < ticks; ++tick) {
            if (before_tick) {
                before_tick(rig, tick);
            }
            all.push_back(rig.tick());
        }
        return all;
    }
};

/// One for all tests that change nothing of it.
inline const std::vector<servo::ServoSample> &plain_press() {
    static const std::vector<servo::ServoSample> samples = Press{}.samples();
    return samples;
}

inline record::RecordHeader header_of(const std::string &device_file = "phantom_1_0",
                                      double delay_periods = 0.0) {
    record::RecordHeader header = record::record_header(kRecorded_hz);
    header.device_name = device_file;
    header.device_toml = contents_of(assets() / "devices" / (device_file + ".toml"));
    header.delay_periods = delay_periods;
    return header;
}

/// Writes a record, with a note after the first `note_after` samples.
inline void write_samples(const std::filesystem::path &file,
                          const std::vector<servo::ServoSample> &samples,
                          const record::RecordHeader &header = header_of(),
                          std::size_t note_after = 0) {
    record::RecordWriter writer(file, header, Existing::replace);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (i == note_after) {
            writer.note(R"({"event": "made up"})");
        }
        writer.write(samples[i]);
    }
    writer.close();
}

/// The same without a file.
inline session::Record in_memory(const std::vector<servo::ServoSample> &samples,
                                 const record::RecordHeader &header = header_of()) {
    const device::DeviceDescription device = device::read_device_text(header.device_toml, "test");
    session::TelemetryHistory rows = session::history_for(device.geometry, header);
    for (const servo::ServoSample &sample : samples) {
        rows.follow_rate(sample);
        rows.add(sample);
    }
    return {header, device, std::move(rows).take(), {0, samples.size()}};
}

} // namespace springdrive::testing
